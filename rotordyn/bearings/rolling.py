"""Static equilibrium and stiffness of a rolling bearing under its loads, at rest and at speed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solidwhirl.rotordyn.bearings.balls import BallBearing
from solidwhirl.rotordyn.bearings.elements import ElementForces
from solidwhirl.rotordyn.bearings.rollers import RollerBearing
from solidwhirl.rotordyn.bearings.validity import Exceeded
from solidwhirl.rotordyn.core.arrays import FloatArray, ReadOnlyArrays
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S

RollingBearing = BallBearing | RollerBearing

_STEPS, _HALVINGS = 200, 40
# Forces on the ring balance to this fraction of the load.
_BALANCED = 1e-11
# A bearing whose elements are pressed together by more than this of their diameter is crushed.
_CRUSHED = 0.02
# Speed times pitch diameter from which on what is left out matters, mm/min: common practice.
_FAST = 1e6


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class RingEquilibrium(ReadOnlyArrays):
    """An inner ring in equilibrium.

    Everything is on (ux, uy, uz, rx, ry) of the inner ring from the outer one. `motion`: m and rad,
    shape (5,); `load`: on the ring, with what holds it, N and N m, shape (5,); `stiffness`: exact
    derivative of the load, shape (5, 5); `speed_rad_s`: of the inner ring; loads and contact angles
    at both races per element: shape (Z,).
    """

    motion: FloatArray
    load: FloatArray
    stiffness: FloatArray
    speed_rad_s: float
    inner_load_n: FloatArray
    outer_load_n: FloatArray
    inner_angle_rad: FloatArray
    outer_angle_rad: FloatArray

    @property
    def lateral_stiffness_n_per_m(self) -> FloatArray:
        """Stiffness on (ux, uy), the other motions held, shape (2, 2)."""
        return self.stiffness[:2, :2]


def loaded_ring(
    bearing: RollingBearing,
    load_n: tuple[float, float, float],
    tilt_rad: tuple[float, float] = (0.0, 0.0),
    speed_rad_s: float = 0.0,
) -> RingEquilibrium:
    """Return the equilibrium under constant loads, an axial one such as the force of springs too.

    `load_n`: on the inner ring along x, y, z; `tilt_rad`: rx and ry, held; `speed_rad_s`: of the
    inner ring. Raises AnalysisError if the bearing cannot carry the load.
    """
    force = np.array([*load_n, 0.0, 0.0])
    beyond = [axis for k, axis in enumerate("xyz") if force[k] and k not in bearing.carried]
    if beyond:
        raise AnalysisError(f"load {list(load_n)} N: this bearing carries none along {beyond}")
    if not force.any():
        raise AnalysisError("load [0, 0, 0] N: without a load a rolling bearing has no stiffness")
    start = bearing.start(force, bearing.centrifugal_n(speed_rad_s))
    start[3:] = tilt_rad
    return _equilibrium(bearing, force, start, bearing.carried, speed_rad_s)


def preloaded_ring(
    bearing: BallBearing,
    preload_n: float,
    radial_load_n: tuple[float, float] = (0.0, 0.0),
    speed_rad_s: float = 0.0,
) -> RingEquilibrium:
    """Return the equilibrium of a ring held axially where a preload at rest has put it.

    `preload_n`: axial force at rest without other loads; the axial force at speed and under the
    radial load is in the result. Raises AnalysisError as `loaded_ring`.
    """
    start = loaded_ring(bearing, (0.0, 0.0, preload_n)).motion.copy()
    force = np.array([*radial_load_n, 0.0, 0.0, 0.0])
    return _equilibrium(bearing, force, start, (0, 1), speed_rad_s)


def _equilibrium(
    bearing: RollingBearing,
    force: FloatArray,
    start: FloatArray,
    free: tuple[int, ...],
    speed_rad_s: float,
) -> RingEquilibrium:
    """Find the place of the ring by Newton's method; its energy is convex."""
    own, rows, motion = bearing.centrifugal_n(speed_rad_s), list(free), start.copy()
    now = bearing.forces(motion, own)
    for _ in range(_STEPS):
        miss = (now.force - force)[rows]
        scale = np.abs(force).max() + now.inner_load_n.max()
        if np.abs(miss).max() <= _BALANCED * scale:
            _refuse_misplaced(bearing, now, force)
            return _result(now, motion, speed_rad_s)
        jacobian = now.stiffness[np.ix_(rows, rows)]
        least = 1e-12 * np.trace(jacobian) + scale / bearing.size_m * 1e-6
        step = np.linalg.solve(jacobian + least * np.eye(len(rows)), -miss)
        step *= min(1.0, 0.1 * bearing.size_m / np.abs(step).max())
        for _ in range(_HALVINGS):
            trial = motion.copy()
            trial[rows] += step
            after = bearing.forces(trial, own)
            nearer = np.linalg.norm((after.force - force)[rows]) < np.linalg.norm(miss)
            if nearer and after.inner_load_n.any():
                break
            step = 0.5 * step
        motion, now = trial, after
    raise AnalysisError(f"no equilibrium of the rolling bearing under {force[:3].tolist()} N")


def _refuse_misplaced(bearing: RollingBearing, found: ElementForces, force: FloatArray) -> None:
    """Raise AnalysisError if elements leave their races or are crushed."""
    problem, load = bearing.misplaced(found), found.outer_load_n.max()
    if isinstance(bearing, BallBearing):
        approach = (load / bearing.stiffness_n_per_m15) ** (2.0 / 3.0)
    else:
        approach = (load / bearing.stiffness_n_per_m109) ** 0.9
    if approach > _CRUSHED * bearing.size_m:
        problem = f"the elements would be pressed in by {approach / bearing.size_m:.2g} diameters"
    if problem:
        raise AnalysisError(f"load {force[:3].tolist()} N cannot be carried: {problem}")


def _result(found: ElementForces, motion: FloatArray, speed_rad_s: float) -> RingEquilibrium:
    return RingEquilibrium(
        motion=motion,
        load=found.force,
        stiffness=found.stiffness,
        speed_rad_s=speed_rad_s,
        inner_load_n=found.inner_load_n,
        outer_load_n=found.outer_load_n,
        inner_angle_rad=found.inner_angle_rad,
        outer_angle_rad=found.outer_angle_rad,
    )


def exceeded(bearing: RollingBearing, found: RingEquilibrium) -> tuple[Exceeded, ...]:
    """Return where an equilibrium is beyond what the theory is for: contact pressure and speed."""
    beyond = []
    loads = (float(found.inner_load_n.max()), float(found.outer_load_n.max()))
    pressure, limit = bearing.pressure_pa(*loads), bearing.highest_pressure_pa
    if pressure > limit:
        why = "it is above that of the static load rating, contacts are elastic no more"
        beyond.append(Exceeded("contact pressure [Pa]", pressure, limit, why))
    fast = abs(found.speed_rad_s) * RPM_PER_RAD_S * 1e3 * bearing.pitch_diameter_m
    if fast > _FAST:
        why = "gyroscopic moments, slip, oil film and growth of the rings are left out"
        beyond.append(Exceeded("speed times pitch diameter [mm/min]", fast, _FAST, why))
    return tuple(beyond)
