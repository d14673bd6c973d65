"""Shapes of modes along the axis: the lateral motion of the centre line of every body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.assembly.coordinates import body_rows
from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.arrays import (
    BoolArray,
    ComplexArray,
    FloatArray,
    ReadOnlyArrays,
    StringArray,
)
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.modes.eigen import Modes
from solidwhirl.rotordyn.modes.whirl import interface_orbits, motion_at_speed
from solidwhirl.rotordyn.superelement.centreline import centreline_motion, interface_rows

# A mode whose largest deflection times the root of the mass is below this has no lateral motion
# (modes have unit modal mass, so a rigid translation has 1).
_NO_LATERAL = 1e-6


class Orbits(NamedTuple):
    """Ellipses of points, in units of the deflection, each (p, m).

    minor is positive for an orbit about +z, negative about −z, 0 for a line; inclination_rad is
    that of the major axis from +x towards +y, in (−π/2, π/2]; phase_rad that at which the point
    passes the end of the major axis.
    """

    major: FloatArray
    minor: FloatArray
    inclination_rad: FloatArray
    phase_rad: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class BodyShape(ReadOnlyArrays):
    """Hold the lateral motion of one body in m modes.

    The point at axial_m moves along x and y by Re(motion e^{λt}), in units of the largest
    semi-axis of all orbits of the mode.

    `axial_m`: points of the centre line along the axis, rising, shape (p,), m. `motion`: complex
    amplitudes of ux, uy, shape (p, 2, m). `deflection`: of the points in the plane of the largest
    orbit's major axis, at the moment it is at its end there, shape (p, m); 1 at that point.
    `interfaces`: names of the interface nodes that can move laterally. `interface_axial_m`: their
    places along the axis, shape (i,), m. `interface_motion`, `interface_deflection`: of these
    nodes, shapes (i, 2, m) and (i, m).
    """

    body: str
    axial_m: FloatArray
    motion: ComplexArray
    deflection: FloatArray
    interfaces: tuple[str, ...]
    interface_axial_m: FloatArray
    interface_motion: ComplexArray
    interface_deflection: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class ModeShapes(ReadOnlyArrays):
    """Hold the lateral shapes of the modes of a system at one speed.

    `speed_rad_s`: Ω, rad/s. `eigenvalues`: λ in 1/s, shape (m,). `whirl`: "forward", "backward",
    "mixed" or "straight" of lateral motion, else the kind, shape (m,). `shares`: of the kinetic
    energy by family: lateral, torsional, axial, disk, shape (m, 4). `bodies`: shapes of every body.
    A mode without lateral motion is zero throughout. `numbers`: what the modes are called, 0 for no
    number; None counts them.
    """

    speed_rad_s: float
    eigenvalues: ComplexArray
    whirl: StringArray
    shares: FloatArray
    bodies: tuple[BodyShape, ...]
    numbers: tuple[int, ...] | None = None

    @property
    def frequency_hz(self) -> FloatArray:
        """Damped natural frequencies, Hz, shape (m,)."""
        return np.asarray(self.eigenvalues.imag / (2.0 * np.pi))

    def body(self, name: str) -> BodyShape:
        """Return the shape of one body.

        Raises AnalysisError if there is none; the message names what exists.
        """
        for shape in self.bodies:
            if shape.body == name:
                return shape
        known = [shape.body for shape in self.bodies]
        raise AnalysisError(f"there is no body {name!r}; there are {known}")


def mode_shapes(
    assembled: AssembledSystem, modes: Modes, numbers: Sequence[int] | None = None
) -> ModeShapes:
    """Return the shapes of modes along the axis.

    `numbers`: what the modes are called, such as `branch_numbers`, 0 for no number, shape (m,);
    None counts them. Each mode scaled so that the largest orbit of all bodies has the semi-axis 1.
    Raises AnalysisError if the modes have another number of coordinates than the system.
    """
    if modes.shapes.shape[0] != assembled.size:
        raise AnalysisError(
            f"the modes have {modes.shapes.shape[0]} coordinates, the system has {assembled.size}"
        )
    raw = []
    for name, rotor in assembled.system.rotors.items():
        own = body_rows(assembled, name) @ modes.shapes
        line, nodes = centreline_motion(rotor.element), interface_rows(rotor.element)
        raw.append((name, line, nodes, line.modes @ own, nodes.modes @ own))
    everything = np.concatenate([part for *_, along, at in raw for part in (along, at)])
    factor = _unit_factor(assembled, modes.shapes, everything)
    plane = _plane(everything * factor)
    bodies = tuple(
        BodyShape(
            body=name,
            axial_m=line.axial_m,
            motion=along * factor,
            deflection=np.einsum("pcm,cm->pm", (along * factor).real, plane),
            interfaces=nodes.names,
            interface_axial_m=nodes.axial_m,
            interface_motion=at * factor,
            interface_deflection=np.einsum("pcm,cm->pm", (at * factor).real, plane),
        )
        for name, line, nodes, along, at in raw
    )
    motion = motion_at_speed(assembled, modes.shapes, modes.eigenvalues, modes.speed_rad_s)
    return ModeShapes(
        speed_rad_s=modes.speed_rad_s,
        eigenvalues=modes.eigenvalues,
        whirl=motion.whirl,
        shares=motion.shares,
        bodies=bodies,
        numbers=None if numbers is None else tuple(int(k) for k in numbers),
    )


def orbits(motion: ComplexArray) -> Orbits:
    """Return the ellipses points go round.

    `motion`: complex amplitudes X, Y of ux and uy, shape (p, 2, m). The result is of Re(X e^{iωt}),
    Re(Y e^{iωt}).

    x + iy = f e^{iωt} + b e^{−iωt} with f = (X + iY)/2 and b the conjugate of (X − iY)/2. The
    semi-axes are |f| ± |b|, the major one at half the sum of both angles, passed at half their
    difference.
    """
    forward = 0.5 * (motion[:, 0] + 1j * motion[:, 1])
    backward = 0.5 * (motion[:, 0] - 1j * motion[:, 1]).conj()
    inclination = 0.5 * (np.angle(forward) + np.angle(backward))
    phase = 0.5 * (np.angle(backward) - np.angle(forward))
    # The other end of the major axis is half a period away.
    turned = np.pi * np.ceil(inclination / np.pi - 0.5)
    return Orbits(
        major=np.abs(forward) + np.abs(backward),
        minor=np.abs(forward) - np.abs(backward),
        inclination_rad=inclination - turned,
        phase_rad=phase + turned,
    )


def _unit_factor(
    assembled: AssembledSystem, shapes: ComplexArray, motion: ComplexArray
) -> ComplexArray:
    """Return the factor of each mode that makes its largest orbit 1 and puts it at its end.

    0 for a mode without lateral motion.
    """
    ellipses = orbits(motion)
    size = np.sqrt(np.einsum("im,ij,jm->m", shapes.conj(), assembled.mass, shapes).real)
    mass = sum(rotor.element.mass_kg for rotor in assembled.system.rotors.values())
    factor = np.zeros(shapes.shape[1], dtype=complex)
    along = _is_along_axis(assembled, shapes)
    for k in range(factor.size):
        at = int(ellipses.major[:, k].argmax()) if len(motion) else 0
        largest = float(ellipses.major[at, k]) if len(motion) else 0.0
        if largest * np.sqrt(mass) > _NO_LATERAL * size[k] and not along[k]:
            factor[k] = np.exp(1j * ellipses.phase_rad[at, k]) / largest
    return factor


def _is_along_axis(assembled: AssembledSystem, shapes: ComplexArray) -> BoolArray:
    """Whether the interfaces of a mode move along or about the axis and not across, shape (m,).

    The mean over a ring does not tell radial growth and torsion from lateral motion.
    """
    across = interface_orbits(assembled, shapes)
    still = (np.abs(across.x) + np.abs(across.y)).sum(axis=0) == 0
    moving = np.zeros(shapes.shape[1], dtype=bool)
    for name, rotor in assembled.system.rotors.items():
        own = [c.component in ("uz", "rz") for c in rotor.element.coordinates]
        moving |= (body_rows(assembled, name)[own] @ shapes != 0).any(axis=0)
    return np.asarray(still & moving)


def _plane(motion: ComplexArray) -> FloatArray:
    """Return the direction of the largest deflection at t = 0, shape (2, m)."""
    now = motion.real
    at = np.hypot(now[:, 0], now[:, 1]).argmax(axis=0)
    direction = now[at, :, np.arange(at.size)].T
    length = np.hypot(*direction)
    return np.asarray(direction / np.where(length > 0, length, 1.0))
