"""What takes part in a mode: energy and damping of every body, bearing and gear."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.assembly.coordinates import body_rows, joint_motion, tooth_motion
from solidwhirl.rotordyn.assembly.internal_damping import body_damping
from solidwhirl.rotordyn.assembly.parts import Bearing, Rotor
from solidwhirl.rotordyn.assembly.system import AssembledSystem, bearing_matrices
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, ReadOnlyArrays
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.modes.eigen import Modes
from solidwhirl.rotordyn.superelement.free_body import free_body_matrices


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Participation(ReadOnlyArrays):
    """Hold the part of each body and joint in m modes.

    Energies are means over a period, divided by those of the whole system.

    `speed_rad_s`: Ω, rad/s. `eigenvalues`: λ in 1/s, shape (m,). `bodies`, `joints`: names; the
    joints are the bearings, then the gears with an elastic mesh. `kinetic_bodies`: shares of the
    kinetic energy (of the motion against the inertial frame, without the spin), shape (b, m); 1 in
    all. `strain_bodies`, `centrifugal_bodies`, `strain_joints`: shares of the energy of the
    symmetric stiffness: elastic, centrifugal (stress stiffening less spin softening, may be
    negative) and of the joints, shapes (b, m), (b, m), (k, m); 1 in all, nan for a mode that has
    none, such as the nutation of a free rigid body. `decrement_bodies`, `decrement_joints`: parts
    of the logarithmic decrement from internal damping and from the joints, shapes (b, m) and (k,
    m). Their sum is the decrement of the mode; negative drives the motion.
    """

    speed_rad_s: float
    eigenvalues: ComplexArray
    bodies: tuple[str, ...]
    joints: tuple[str, ...]
    kinetic_bodies: FloatArray
    strain_bodies: FloatArray
    centrifugal_bodies: FloatArray
    strain_joints: FloatArray
    decrement_bodies: FloatArray
    decrement_joints: FloatArray


class _Part(NamedTuple):
    """Forms of one body or joint: φᴴMφ, φᴴKφ, φᴴΩ²K2φ, φᴴCφ, Im φᴴ(skew K)φ, each (m,)."""

    kinetic: FloatArray
    strain: FloatArray
    centrifugal: FloatArray
    damping: FloatArray
    circulation: FloatArray


def participation(assembled: AssembledSystem, modes: Modes) -> Participation:
    """Share out the energy and the damping of modes.

    By body and joint. Raises AnalysisError if the modes have another number of coordinates than the
    system.

    The real part of λ̄ φᴴ(λ²M + λ(C + ΩG) + K)φ = 0 is, with K = S + W (symmetric and skew) and
    λ = δ + iω, −δ = Σ (|λ|² φᴴCφ + ω Im φᴴWφ) / (|λ|² φᴴMφ + φᴴSφ): a sum over the parts.
    """
    if modes.shapes.shape[0] != assembled.size:
        raise AnalysisError(
            f"the modes have {modes.shapes.shape[0]} coordinates, the system has {assembled.size}"
        )
    system, speed = assembled.system, modes.speed_rad_s
    bodies = {name: _body(assembled, name, speed, modes.shapes) for name in system.rotors}
    joints = [(b.name, _bearing(assembled, b, speed, modes.shapes)) for b in system.bearings]
    joints += _gears(assembled, modes.shapes)
    values = modes.eigenvalues
    own = _stacked(list(bodies.values()), values.size)
    tied = _stacked([part for _, part in joints], values.size)
    whole = [a.sum(axis=0) + b.sum(axis=0) for a, b in zip(own, tied, strict=True)]
    squared = np.abs(values) ** 2
    stored = whole[1] + whole[2]
    stored = np.where(np.abs(stored) > np.finfo(float).tiny, stored, np.nan)
    rate = 2.0 * np.pi / values.imag / (squared * whole[0] + whole[1] + whole[2])
    return Participation(
        speed_rad_s=speed,
        eigenvalues=values,
        bodies=tuple(bodies),
        joints=tuple(name for name, _ in joints),
        kinetic_bodies=own.kinetic / whole[0],
        strain_bodies=own.strain / stored,
        centrifugal_bodies=own.centrifugal / stored,
        strain_joints=tied.strain / stored,
        decrement_bodies=rate * (squared * own.damping + values.imag * own.circulation),
        decrement_joints=rate * (squared * tied.damping + values.imag * tied.circulation),
    )


def _stacked(parts: list[_Part], count: int) -> _Part:
    """Return each form of all parts in one array (parts, m)."""
    if not parts:
        return _Part(*(np.zeros((0, count)) for _ in _Part._fields))
    return _Part(*(np.stack(form) for form in zip(*parts, strict=True)))


def _forms(
    motion: ComplexArray, mass: FloatArray, k: FloatArray, k2: FloatArray, c: FloatArray
) -> _Part:
    """Return the forms of a part; `motion` is that of its own coordinates, (n_part, m)."""

    def form(matrix: FloatArray) -> ComplexArray:
        return np.asarray(np.einsum("im,ij,jm->m", motion.conj(), matrix, motion, optimize=True))

    skew = 0.5 * (k - k.T)
    return _Part(form(mass).real, form(k).real, form(k2).real, form(c).real, form(skew).imag)


def _body(assembled: AssembledSystem, name: str, speed: float, shapes: ComplexArray) -> _Part:
    rotor: Rotor = assembled.system.rotors[name]
    spin = rotor.speed_ratio * speed
    matrices = free_body_matrices(rotor.element)
    damping = body_damping(rotor, matrices)
    return _forms(
        body_rows(assembled, name) @ shapes,
        matrices.mass,
        0.5 * (matrices.stiffness + matrices.stiffness.T) + spin * damping.circulatory,
        spin**2 * matrices.centrifugal_stiffness,
        damping.damping,
    )


def _bearing(
    assembled: AssembledSystem, bearing: Bearing, speed: float, shapes: ComplexArray
) -> _Part:
    stiffness, damping = bearing_matrices(assembled, bearing, speed)
    none = np.zeros((6, 6))
    return _forms(joint_motion(assembled, bearing) @ shapes, none, stiffness, none, damping)


def _gears(assembled: AssembledSystem, shapes: ComplexArray) -> list[tuple[str, _Part]]:
    """Return the forms of the gears with an elastic mesh; a rigid one stores nothing."""
    none = np.zeros((1, 1))
    found = []
    for gear in assembled.system.gears:
        if gear.mesh_stiffness_n_per_m is None:
            continue
        teeth = tooth_motion(assembled, gear)
        stiffness = np.array([[gear.mesh_stiffness_n_per_m]])
        damping = np.array([[gear.mesh_damping_n_s_per_m]])
        part = _forms(teeth[None] @ shapes, none, stiffness, none, damping)
        found.append((gear.name, part))
    return found
