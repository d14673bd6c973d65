"""Loads of a run-up: unbalance, gravity, and the torque that accelerates the shafts.

All are given on the coordinates of the bodies, stacked as in the rows of the transformation T; on
the independent coordinates a load f is Tᵀf.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.coordinates import Placed, interface_row
from solidwhirl.rotordyn.assembly.parts import End
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.response.unbalance import Unbalance

# Singular values below this fraction of the largest count as zero.
_RANK = 1e-9
_TORSION = 5


class TurningLoads(NamedTuple):
    """Unbalance forces, two columns for each speed ratio.

    The force is Σ_r columns[:, 2r] (ω² cos θ + ω' sin θ) + columns[:, 2r+1] (ω² sin θ − ω' cos θ)
    with ω = ratio · Ω and θ = ratio · ∫Ω dt.

    `ratios`: shape (r,); `columns`: on the stacked coordinates, kg m, shape (N, 2r).
    """

    ratios: FloatArray
    columns: FloatArray

    def amplitudes(
        self, angle_rad: FloatArray, speed_rad_s: FloatArray, acceleration_rad_s2: float
    ) -> tuple[FloatArray, FloatArray]:
        """Return the factors of the columns and their time derivatives.

        `angle_rad`, `speed_rad_s`: ∫Ω dt and Ω, shape (t,); `acceleration_rad_s2`: Ω', constant
        over these times. Returns `values`, `rates`: shape (t, 2r), 1/s² and 1/s³.
        """
        omega = np.multiply.outer(speed_rad_s, self.ratios)
        change = acceleration_rad_s2 * self.ratios
        turn = np.exp(1j * np.multiply.outer(angle_rad, self.ratios))
        value = (omega**2 - 1j * change) * turn
        rate = (3.0 * omega * change + 1j * omega**3) * turn
        return _interleaved(value), _interleaved(rate)


def turning_loads(assembled: Placed, unbalances: Sequence[Unbalance]) -> TurningLoads:
    """Return the columns of the unbalance forces of a system.

    `unbalances`: where and how much; bodies that stand still are refused. Unbalances of bodies
    with the same speed ratio share their columns. Raises AnalysisError if a body with
    unbalance does not turn. Raises AssemblyError if a body or interface does not exist or has no ux
    and uy.
    """
    columns: dict[float, FloatArray] = {}
    for unbalance in unbalances:
        in_x = _unit_load(assembled, unbalance.body, unbalance.interface, "ux")
        in_y = _unit_load(assembled, unbalance.body, unbalance.interface, "uy")
        ratio = assembled.system.rotors[unbalance.body].speed_ratio
        if ratio == 0:
            raise AnalysisError(
                f"unbalance at {unbalance.body}.{unbalance.interface}: the body has speed ratio 0 "
                "and does not turn"
            )
        c, s = np.cos(unbalance.phase_rad), np.sin(unbalance.phase_rad)
        pair = unbalance.moment_kg_m * np.stack((c * in_x + s * in_y, c * in_y - s * in_x), axis=1)
        columns[ratio] = columns.get(ratio, np.zeros_like(pair)) + pair
    if not columns:
        return TurningLoads(np.empty(0), np.zeros((assembled.transformation.shape[0], 0)))
    return TurningLoads(np.array(list(columns)), np.hstack(list(columns.values())))


def torsion_load(assembled: Placed, stiffness: FloatArray, drives: Sequence[End]) -> FloatArray:
    """Return the load on the torsion of all bodies per unit acceleration of the shaft.

    Seen from a shaft that follows Ω(t) its inertia pulls back with −M r n_i Ω', r the turn about
    the axis. The torque at the drives balances that over each train of bodies turning together.

    `stiffness`: elastic one, shape (n, n). `drives`: interfaces with rz where torque enters, one
    for each train that is free to turn. Without any, each body is taken to be driven where its
    inertia is, and torsion is left in peace.
    The result is on the stacked coordinates, shape (N,), N m s²/rad; times Ω' it is a load. Raises
    AnalysisError if the drives do not balance the trains one by one. Raises AssemblyError if a
    drive has no rz.
    """
    load = np.zeros(assembled.transformation.shape[0])
    if not drives:
        return load
    spins = np.zeros((assembled.transformation.shape[0], len(assembled.system.rotors)))
    for column, (name, rotor) in enumerate(assembled.system.rotors.items()):
        turn = rotor.element.rigid_body_modes[:, _TORSION]
        spins[assembled.body_slices[name], column] = turn
        load[assembled.body_slices[name]] = -rotor.speed_ratio * (rotor.element.mass @ turn)
    torques = [_unit_load(assembled, end.body, end.interface, "rz") for end in drives]
    columns = np.stack(torques, axis=1)
    trains = assembled.transformation @ _free_turns(assembled.transformation, stiffness, spins)
    lever = trains.T @ columns
    values = la.svdvals(lever) if lever.size else np.empty(0)
    square = lever.shape[0] == lever.shape[1]
    if not square or (values.size and values[-1] <= _RANK * values[0]):
        names = [end.label for end in drives]
        raise AnalysisError(
            f"the drives {names} do not balance the {trains.shape[1]} train(s) of bodies that are "
            "free to turn; name one interface of each train"
        )
    if trains.shape[1]:
        load = load - columns @ la.solve(lever, trains.T @ load)
    return load


def _unit_load(assembled: Placed, body: str, interface: str, component: str) -> FloatArray:
    """Return a load of one on an interface coordinate, shape (N,)."""
    interface_row(assembled, body, interface, component)  # says what exists if it does not
    load = np.zeros(assembled.transformation.shape[0])
    element = assembled.system.rotors[body].element
    at = assembled.body_slices[body].start + element.interface_index(interface, component)
    load[at] = 1.0
    return load


def _free_turns(transformation: FloatArray, stiffness: FloatArray, spins: FloatArray) -> FloatArray:
    """Return motions in which bodies turn about the axis and no spring is strained, (n, m)."""
    spins = spins[:, spins.any(axis=0)]
    if not spins.size:
        return np.zeros((len(stiffness), 0))
    spins = spins / la.norm(spins, axis=0)
    motions, *_ = la.lstsq(transformation, spins)
    together = motions @ _null_space(transformation @ motions - spins, _RANK)
    root = np.sqrt(np.abs(np.diag(stiffness)))
    inverse = np.divide(1.0, root, out=np.zeros_like(root), where=root > 0)
    strain = inverse[:, None] * (stiffness @ together)
    limit = _RANK * float(la.norm(root[:, None] * together))
    return np.asarray(together @ _null_space(strain, limit))


def _null_space(matrix: FloatArray, limit: float) -> FloatArray:
    """Return directions that a matrix shortens to the limit or below, as columns."""
    _, values, rows = la.svd(matrix, full_matrices=True)
    rank = int(np.count_nonzero(values > limit))
    return np.asarray(rows[rank:].T)


def _interleaved(values: ComplexArray) -> FloatArray:
    """Return Re and Im of each column side by side, (t, 2r) from (t, r)."""
    return np.stack((values.real, values.imag), axis=-1).reshape(values.shape[0], -1)
