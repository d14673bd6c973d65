"""Critical speeds without damping: roots of a Hermitian problem."""

from __future__ import annotations

import numpy as np

from solidwhirl.rotordyn.assembly.system import (
    AssembledSystem,
    at_whirl_ratio,
    matrices_at_speed,
)
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.critical_speeds.speed_roots import SpeedRoots, speed_roots
from solidwhirl.rotordyn.critical_speeds.whirl_pencils import (
    DirectSpeeds,
    Pencil,
    direct_speeds,
    separate_pencils,
)
from solidwhirl.rotordyn.modes.eigen import scaled_stiffness
from solidwhirl.rotordyn.modes.whirl import separated_whirl


def undamped_critical_speeds(
    assembled: AssembledSystem, ratio: float, limit: float
) -> tuple[FloatArray, ComplexArray]:
    """Return the critical speeds and shapes without damping, by rising speed.

    `ratio`, `limit`: |α| and the largest Ω. Bearings are as they are at the frequency |αΩ|. Returns
    Ω, shape (m,), and φ, shape (n, m).
    """
    assembled = at_whirl_ratio(assembled, ratio)
    speeds, shapes = [], []
    for pencil in separate_pencils(assembled, ratio):
        found = _speeds_of(pencil, assembled.body_rate, limit)
        speeds.append(found.speeds_rad_s)
        shapes.append(pencil.expand(found.shapes))
    together, columns = np.concatenate(speeds), np.hstack(shapes)
    order = np.argsort(together, kind="stable")
    return together[order], separated_whirl(assembled, together[order], columns[:, order])


def _speeds_of(pencil: Pencil, body_rate: float, limit: float) -> DirectSpeeds | SpeedRoots:
    if not pencil.laws:
        return direct_speeds(pencil, pencil.stiffness, body_rate, limit)
    if not np.isfinite(limit):
        raise AnalysisError(
            "speed_max_rad_s is needed: bearings depend on the speed, and critical speeds are "
            "searched for up to a finite one"
        )
    return speed_roots(pencil, body_rate, limit)


def undamped_places(assembled: AssembledSystem, ratio: float, limit: float) -> FloatArray:
    """Return the critical speeds without damping and skew stiffness, and where modes touch.

    Where a mode touches the excitation without them it may cross it twice.

    `ratio`, `limit`: |α| and the largest Ω, finite. Returns Ω, rising. None if K is negative, or
    the pieces of a law are not known.
    """
    if any(joint.pieces is None for joint in assembled.law_joints):
        return np.empty(0)
    start = matrices_at_speed(assembled, 0.0)
    for matrices in (start, start._replace(stiffness=assembled.stiffness)):
        if scaled_stiffness(assembled, matrices).negative_count:
            return np.empty(0)
    seeds = []
    for pencil in separate_pencils(assembled, ratio):
        found = _speeds_of(pencil, assembled.body_rate, limit)
        seeds.append(found.speeds_rad_s)
        if isinstance(found, SpeedRoots):
            seeds.append(np.array([0.5 * (low + high) for low, high in found.unresolved]))
    return np.sort(np.concatenate(seeds))
