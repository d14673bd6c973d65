"""What the coefficients of a table say of themselves, before a rotor runs on them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from solidwhirl.bearing_tables.records import CoefficientTable
from solidwhirl.rotordyn.core.arrays import BoolArray
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S

# Part of the largest entry below which one is rounding.
_ROUNDING = 1e-9
_NOT_POSITIVE = {
    "stiffness_n_per_m": "direct stiffness below zero",
    "damping_n_s_per_m": "direct damping below zero",
    "mass_kg": "direct mass below zero",
}


def findings(table: CoefficientTable) -> tuple[str, ...]:
    """Return lines on the signs and cross terms of a table; what is unusual begins "warning:".

    The cross stiffness kxy − kyx does work on a forward circular whirl, π a² (kxy − kyx) in a turn
    of radius a, and the damping takes π a² ω (cxx + cyy); at ω = Ω their ratio is the whirl
    frequency ratio of an isotropic film.
    """
    return (*_negative(table), *_active(table), *_cross(table))


def _negative(table: CoefficientTable) -> Iterator[str]:
    for name, said in _NOT_POSITIVE.items():
        values = np.diagonal(getattr(table, name), axis1=-2, axis2=-1)
        bad = (values < 0).any(axis=-1)
        if bad.any():
            yield f"warning: {said} at {_points(table, bad)}"


def _active(table: CoefficientTable) -> Iterator[str]:
    """Damping that drives some motion although its direct terms do not."""
    damping = table.damping_n_s_per_m
    lowest = np.linalg.eigvalsh(0.5 * (damping + damping.swapaxes(-1, -2)))[..., 0]
    direct = np.diagonal(damping, axis1=-2, axis2=-1).min(axis=-1)
    bad = (lowest < -_ROUNDING * np.abs(damping).max()) & (direct >= 0)
    if bad.any():
        yield f"warning: damping drives motion in one direction at {_points(table, bad)}"


def _cross(table: CoefficientTable) -> Iterator[str]:
    stiffness = table.stiffness_n_per_m
    xy, yx = stiffness[..., 0, 1], stiffness[..., 1, 0]
    small = _ROUNDING * np.abs(stiffness).max()
    skew = xy - yx
    if (np.abs(skew) <= small).all():
        yield "cross stiffness is symmetric: it drives no whirl"
        return
    if ((xy > 0) & (yx < 0)).all():
        sign = "kxy > 0 > kyx: cross stiffness drives forward whirl"
    elif (skew >= -small).all():
        sign = "kxy > kyx: cross stiffness drives forward whirl"
    elif (skew <= small).all():
        sign = (
            "warning: kxy < kyx: cross stiffness drives backward whirl; is the maker's shaft "
            "turning from y to x, or one of the axes reversed?"
        )
    else:
        sign = f"cross stiffness drives backward whirl at {_points(table, skew < -small)}"
    yield sign + _whirl_ratio(table)


def _whirl_ratio(table: CoefficientTable) -> str:
    """The largest whirl frequency ratio, where there are speeds and damping."""
    if table.speeds_rad_s is None:
        return ""
    speeds = table.speeds_rad_s.reshape(1, -1, 1)
    damping = np.trace(table.damping_n_s_per_m, axis1=-2, axis2=-1)
    skew = table.stiffness_n_per_m[..., 0, 1] - table.stiffness_n_per_m[..., 1, 0]
    known = (speeds * damping > 0) & np.ones_like(skew, dtype=bool)
    if not known.any():
        return ""
    ratio = np.divide(skew, speeds * damping, out=np.full_like(skew, -np.inf), where=known)
    return f"; (kxy - kyx)/(speed (cxx + cyy)) is up to {ratio.max():.3g}"


def _points(table: CoefficientTable, which: BoolArray) -> str:
    """How many points of a table, and the first of them."""
    first = np.argwhere(which)[0]
    axes = (
        (table.loads_n, 1.0, "N"),
        (table.speeds_rad_s, RPM_PER_RAD_S, "rpm"),
        (table.frequencies_rad_s, 0.5 / np.pi, "Hz"),
    )
    words = [
        f"{values[k] * scale:.6g} {unit}"
        for k, (values, scale, unit) in zip(first, axes, strict=True)
        if values is not None
    ]
    where = f", first at {', '.join(words)}" if words else ""
    return f"{int(which.sum())} of {which.size} points{where}"
