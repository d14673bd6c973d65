"""Loads on a system in a turning frame: unbalance, weight, and what an uneven speed does."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.parts import End
from solidwhirl.rotordyn.asymmetric.assembly import RotatingSystem
from solidwhirl.rotordyn.asymmetric.in_time.gauss_steps import Instants
from solidwhirl.rotordyn.asymmetric.loads import gravity_force, own_unbalance
from solidwhirl.rotordyn.asymmetric.periodic import Harmonics
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.response.unbalance import Unbalance
from solidwhirl.rotordyn.run_up.loads import TurningLoads, torsion_load, turning_loads
from solidwhirl.rotordyn.superelement.record import Superelement

# Motions of a body that a torque about its axis does not cause: ux, uy, rx, ry.
_LATERAL, _TORSION = (0, 1, 3, 4), 5


class FrameLoads(NamedTuple):
    """Forces on the n coordinates of a system in the frame.

    `turning`: unbalance, whose ratios are to the speed of the frame, with columns (n, 2r) by
    harmonic in `columns`; `weight`: (n, 1) by harmonic; `own`: of the bodies' own unbalance per p²,
    `euler`: of all per p', shape (n,).
    """

    turning: TurningLoads
    columns: Harmonics
    weight: Harmonics
    own: FloatArray
    euler: FloatArray

    def at(self, instants: Instants) -> FloatArray:
        """Return the force at some instants, (s, n)."""
        angles, speeds, rise = instants
        values, _ = self.turning.amplitudes(angles, speeds, rise)
        out: FloatArray = np.multiply.outer(speeds**2, self.own) + rise * self.euler
        for harmonics, factors in (
            (self.columns, values),
            (self.weight, np.ones((angles.size, 1))),
        ):
            for harmonic, columns in harmonics.items():
                if harmonic == 0:
                    out += factors @ columns.real.T
                elif harmonic > 0:  # that of −h is conjugate
                    turn = 2.0 * np.exp(1j * harmonic * angles)[:, None]
                    out += (factors * turn.real) @ columns.real.T
                    out -= (factors * turn.imag) @ columns.imag.T
        return out

    def on(self, shapes: FloatArray) -> FrameLoads:
        """Return the forces on the coordinates w in q = shapes w."""
        return FrameLoads(
            self.turning,
            {h: shapes.T @ part for h, part in self.columns.items()},
            {h: shapes.T @ part for h, part in self.weight.items()},
            shapes.T @ self.own,
            shapes.T @ self.euler,
        )


def frame_loads(
    rotating: RotatingSystem,
    unbalances: Sequence[Unbalance],
    gravity_m_per_s2: npt.ArrayLike | None,
    drives: Sequence[End],
    acts: bool,
) -> FrameLoads:
    """Return the loads on a system, see `run_up_rotating`; `acts`: of its own unbalance."""
    transformation, ratio = rotating.transformation, abs(rotating.frame_ratio)
    turning = turning_loads(rotating, unbalances)
    weight: Harmonics = {}
    if gravity_m_per_s2 is not None:
        found = gravity_force(rotating, gravity_m_per_s2)
        weight = {harmonic: force[:, None] for harmonic, force in found.items()}
    euler = torsion_load(rotating, rotating.periodic.stiffness_at_rest(), drives) / ratio
    for name, rotor in rotating.system.rotors.items():
        if rotor.element.frame != "rotating":
            continue
        # a drive's load is of the whole inertia, also of what is off the axis
        missing = float(acts) - float(bool(drives))
        euler[rotating.body_slices[name]] -= missing * rotating.sense * _eccentric(rotor.element)
    return FrameLoads(
        turning=TurningLoads(turning.ratios / ratio, turning.columns),
        columns=_turning_columns(rotating, turning),
        weight=weight,
        own=own_unbalance(rotating) if acts else np.zeros(rotating.periodic.size),
        euler=transformation.T @ euler,
    )


def _turning_columns(rotating: RotatingSystem, turning: TurningLoads) -> Harmonics:
    """Columns of the unbalances by harmonic: pairs that turn as ux and uy do, (n, 2r)."""
    found = []
    for k in range(turning.ratios.size):
        rows = np.zeros((6, len(turning.columns)))
        rows[:2] = turning.columns[:, 2 * k : 2 * k + 2].T
        found.append(rotating.fixed(rows))
    every = {h for one in found for h in one}
    none = np.zeros((6, rotating.periodic.size))
    return {h: np.hstack([one.get(h, none)[:2].T for one in found]) for h in every}


def _eccentric(element: Superelement) -> FloatArray:
    """The part of ∫ρ v·(e_z×x) that no drive takes off: resultants across the axis, no torque.

    The rest is what a torque, spread as the inertia is, takes to turn the body faster.
    """
    moments = element.moments
    assert moments is not None
    whole: FloatArray = moments.first_kg_m[0, 1] - moments.first_kg_m[1, 0]
    lateral, turn = element.rigid_body_modes[:, _LATERAL], element.rigid_body_modes[:, _TORSION]
    momentum = element.mass @ lateral
    rest = whole - momentum @ (la.pinv(lateral.T @ momentum) @ (lateral.T @ whole))
    torque = float(turn @ rest)
    return np.asarray(whole - (float(turn @ whole) / torque if torque else 1.0) * rest)
