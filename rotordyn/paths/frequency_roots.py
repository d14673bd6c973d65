"""Roots with laws over the frequency: where a path over the frozen frequency meets itself.

For a frozen ω the problem is an ordinary one, with paths s_j(ω); a root is Im s_j(ω) = ω. All 2n
paths are there, so that two roots of a fold are two zeros of one path, and no number of roots is
presumed. The index of a root, the sign of 1 − Im ds_j/dω, is −1 for one of each pair: the law rises
faster there than a passive support with so little damping can, and its growth has no meaning.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.core.arrays import ComplexArray
from solidwhirl.rotordyn.core.second_order import SecondOrder
from solidwhirl.rotordyn.core.spectrum import Spectrum, residuals_of, spectrum
from solidwhirl.rotordyn.core.tolerances import AT_REST
from solidwhirl.rotordyn.paths.eigenvalue_paths import EigenvaluePaths, meets_band
from solidwhirl.rotordyn.paths.events import refined

# Steps of Newton's method for one root.
_STEPS = 30
# Roots within this part of a strip's end belong to it; two of neighbouring strips are one.
_RIM, _SAME = 1e-10, 1e-9
# Im s below this part of |s|, or of a strip's end, is none.
_STILL = 1e-9
# Paths are followed where they come within this part of a strip beyond its ends.
_BEYOND = 0.6


class FrequencyRoot(NamedTuple):
    """A root s of P(s; Ω, |Im s|), with Im s > 0.

    `value`: s, 1/s; `right`, `left`: vectors (n,), yᴴ P'(s) x = 1 with the laws frozen;
    `sign`: its index, 1, or −1 for the other one of a fold; `turned`: c = ds_j/dω of the frozen
    problem; `residual`: backward error with the laws at |Im s|.
    """

    value: complex
    right: ComplexArray
    left: ComplexArray
    sign: int
    turned: complex
    residual: float


def frequency_roots(
    operator: SecondOrder, speed: float, top: float | None = None
) -> list[FrequencyRoot]:
    """Return all roots with Im s > 0 of an operator with laws over the frequency, by rising Im s.

    `speed`: Ω, rad/s; `top`: leave out those with a larger Im s, rad/s; None for all. Real roots
    are those of the spectrum with the laws at zero frequency.
    """
    knots = operator.frequency_knots
    limit = np.inf if top is None else top
    scale = top if top is not None else max(knots[-1], 1.0)
    solve = cache(lambda frequency: spectrum(operator, speed, frequency, scale))
    ends = [knot for knot in knots if knot < limit] + ([limit] if knots[-1] > limit else [])
    # below the first knot and beyond the last the laws are constant, and so are the paths
    first, last = solve(ends[0]), solve(ends[-1])
    roots = constant_law_roots(first, 0.0, ends[0])
    for low, high in pairwise(ends):
        if not any(change.any() for change in operator.by_frequency(speed, low, 1)):
            roots += _new(constant_law_roots(solve(low), low, high), roots)
            continue
        paths = EigenvaluePaths(
            solve,
            lambda frequency, side: operator.by_frequency(speed, frequency, side),
            (low, high),
            wanted=meets_band(low - _BEYOND * (high - low), high + _BEYOND * (high - low)),
            scale=scale,
        )
        events = paths.crossings(
            lambda frequency, values: values.imag - frequency, lambda _, slopes: slopes.imag - 1.0
        )
        found: list[tuple[int, FrequencyRoot]] = []
        for event in events:
            if event.at <= _STILL * high:  # real roots: they are those of the laws at rest
                continue
            root = root_near(operator, speed, event.value, (low, high))
            # the same path meets itself twice at two places, other paths may do so at one
            if root and not any(path == event.path and _same(root, r) for path, r in found):
                found.append((event.path, root))
        roots += _new([root for _, root in found], roots)
    if knots[-1] < limit:
        roots += _new(constant_law_roots(last, ends[-1], limit), roots)
    roots.sort(key=lambda root: (root.value.imag, root.value.real))
    return _with_own_vectors(operator, speed, roots)


def constant_law_roots(
    found: Spectrum, low: float = 0.0, high: float = np.inf
) -> list[FrequencyRoot]:
    """Return the roots that oscillate, low ≤ Im s < high, of a problem whose laws do not change."""
    inside = (found.values.imag >= low * (1.0 - _RIM)) & (found.values.imag < high)
    inside &= found.values.imag > _STILL * np.abs(found.values)
    return [
        FrequencyRoot(
            complex(found.values[at]),
            found.right[:, at],
            found.left[:, at],
            1,
            0j,
            float(found.residuals[at]),
        )
        for at in np.flatnonzero(inside)
    ]


def root_near(
    operator: SecondOrder,
    speed: float,
    start: complex,
    strip: tuple[float, float] = (0.0, np.inf),
) -> FrequencyRoot | None:
    """Return the root next to a number by Newton's method for ω = Im s_j(ω), which is real.

    `strip`: frequencies that it must lie in, rad/s; the law is smooth within. None if there is no
    root in the strip that it comes to.
    """
    low, high = strip
    margin = 1e-3 * (high if np.isfinite(high) else abs(start))
    value = start
    for _ in range(_STEPS):
        triple = operator.at(speed, value.imag)
        values, rights, lefts = refined(triple, value)
        found, right, left = complex(values[0]), rights[:, 0], lefts[:, 0]
        side = 1 if value.imag - low < high - value.imag else -1
        change = operator.by_frequency(speed, value.imag, side)
        turned = -complex(left.conj() @ change.value(found) @ right)
        slope = 1.0 - turned.imag
        if slope == 0.0:
            return None
        step = (found.imag - value.imag) / slope
        before, value = value, complex((found + turned * step).real, value.imag + step)
        if not low - margin < value.imag < high + margin:
            return None
        if abs(value - before) <= AT_REST * abs(value):
            break
    else:
        return None
    if not low * (1.0 - _RIM) <= value.imag <= high * (1.0 + _RIM):
        return None
    triple = operator.at(speed, value.imag)
    residual = residuals_of(triple, np.array([value]), right[:, None])[0]
    return FrequencyRoot(value, right, left, int(np.sign(slope)), turned, float(residual))


def _same(one: FrequencyRoot, other: FrequencyRoot) -> bool:
    return abs(one.value - other.value) <= _SAME * abs(one.value)


def _new(found: Sequence[FrequencyRoot], known: Sequence[FrequencyRoot]) -> list[FrequencyRoot]:
    """Return roots that are not among those of the strips before: at a rim each is found twice."""
    left, new = list(known), []
    for root in found:
        twin = next((other for other in left if _same(root, other)), None)
        if twin is None:
            new.append(root)
        else:
            left.remove(twin)
    return new


def _with_own_vectors(
    operator: SecondOrder, speed: float, roots: list[FrequencyRoot]
) -> list[FrequencyRoot]:
    """Return roots of which equal ones have independent vectors."""
    out: list[FrequencyRoot] = []
    while len(out) < len(roots):
        at = len(out)
        group = [root for root in roots[at:] if _same(root, roots[at])]
        if len(group) == 1 or group[0].value == 0:
            out.append(roots[at])
            continue
        value = roots[at].value
        _, right, left = refined(operator.at(speed, value.imag), value, len(group))
        out += [root._replace(right=right[:, k], left=left[:, k]) for k, root in enumerate(group)]
    return out
