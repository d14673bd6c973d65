"""Mass properties of rigid bodies: the six-motion mass matrix and the sum of two bodies."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.core.arrays import FloatArray, cross_matrix, motion_at
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.superelement.mass_moments import (
    joined_moments,
    projected_moments,
    rigid_motion_moments,
)
from solidwhirl.rotordyn.superelement.record import Coordinate, InterfaceNode, Superelement
from solidwhirl.rotordyn.superelement.validation import MOTIONS, Component


class MassProperties(NamedTuple):
    """Mass (kg), centre of gravity (3,) (m) and inertia about it (3, 3) (kg m²)."""

    mass_kg: float
    center_of_gravity_m: FloatArray
    inertia_kg_m2: FloatArray


def body_mass_matrix(element: Superelement) -> FloatArray:
    """Return the mass matrix of a body taken as a rigid one, see `rigid_body_mass_matrix`."""
    return rigid_body_mass_matrix(
        element.mass_kg, element.center_of_gravity_m, element.inertia_kg_m2
    )


def rigid_body_mass_matrix(
    mass_kg: float, center_of_gravity_m: FloatArray, inertia_kg_m2: FloatArray
) -> FloatArray:
    """Return the mass matrix of a rigid body for its six motions about the origin.

    `center_of_gravity_m`: centre of gravity, shape (3,), m; `inertia_kg_m2`: inertia tensor about
    the centre of gravity, shape (3, 3), kg m². Returns shape (6, 6), order ux, uy, uz, rx, ry, rz.
    A point moves by t + θ × x.
    """
    cross = cross_matrix(np.asarray(center_of_gravity_m))
    matrix = np.zeros((6, 6))
    matrix[:3, :3] = mass_kg * np.eye(3)
    matrix[:3, 3:] = -mass_kg * cross
    matrix[3:, :3] = mass_kg * cross
    matrix[3:, 3:] = inertia_kg_m2 - mass_kg * cross @ cross
    return matrix


def joined_mass_properties(parts: Sequence[MassProperties]) -> MassProperties:
    """Return the mass properties of rigid parts with mass taken as one body (parallel axes)."""
    total = sum(part.mass_kg for part in parts)
    moment = sum((p.mass_kg * p.center_of_gravity_m for p in parts), np.zeros(3))
    center = moment / total
    tensor = np.zeros((3, 3))
    for part in parts:
        arm = part.center_of_gravity_m - center
        tensor += part.inertia_kg_m2
        tensor += part.mass_kg * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return MassProperties(total, center, tensor)


def attach_rigid_disk(
    element: Superelement,
    interface: str,
    name: str,
    mass_kg: float,
    polar_kg_m2: float,
    diametral_kg_m2: float,
    offset_m: float = 0.0,
) -> Superelement:
    """Return the superelement with a rigid disk added at an interface.

    The disk turns with the body. It adds Id rx'' + Ω Ip ry' and Id ry'' − Ω Ip rx' and its mass;
    in the inertial frame its stress stiffening and spin softening cancel, so both stay as they
    were; in the rotating one they are those of a rigid body. Components the interface lacks are
    left out. The free frequencies of the result are
    not known and become empty; the fixed-interface frequencies do not change.

    Parameters
    ----------
    interface
        Where the disk sits; it must have "ux" or "uy" or another component.
    name
        Name of the disk, kept in the provenance.
    mass_kg, polar_kg_m2, diametral_kg_m2
        Mass, polar and diametral moment of inertia about the disk's own centre; kg, kg m².
    offset_m
        Axial distance of the disk's centre from the interface node, m; joined by a rigid arm.

    Returns
    -------
    Superelement
        With mass, centre of gravity, inertia, M, G and moments updated. The error forms stay as
        they were: the disk acts on interface motions, which the larger model moves alike.

    Raises
    ------
    SuperelementError
        If the interface does not exist or has no coordinates, a number is negative or not
        finite, or an offset is given where the interface has a translation but not the tilt
        that moves the arm.
    """
    record = {
        "mass_kg": float(mass_kg),
        "polar_kg_m2": float(polar_kg_m2),
        "diametral_kg_m2": float(diametral_kg_m2),
        "offset_m": float(offset_m),
    }
    components = element.components_at(interface) if element.interface_node(interface) else ()
    _check_disk(f"disk {name!r} on superelement {element.name!r}", components, record)
    arm = np.array([0.0, 0.0, offset_m])
    inertia = np.diag([diametral_kg_m2, diametral_kg_m2, polar_kg_m2])
    disks = element.provenance.get("rigid_disks", [])
    disks = [*disks, {"name": name, "interface": interface, **record}]
    return dataclasses.replace(
        _with_ring(element, interface, MassProperties(mass_kg, arm, inertia)),
        free_frequencies_hz=np.empty(0),
        provenance={**element.provenance, "rigid_disks": disks},
    )


def interface_motion(element: Superelement, interface: str) -> FloatArray:
    """Return ux to rz of an interface in the coordinates of a body, (6, n); absent ones are 0."""
    placed = np.zeros((6, element.size))
    for component in element.components_at(interface):
        placed[MOTIONS.index(component), element.interface_index(interface, component)] = 1.0
    return placed


def _with_ring(element: Superelement, interface: str, ring: MassProperties) -> Superelement:
    """Return a body with a rigid ring; its centre is given from the interface node."""
    node, placed = element.interface_node(interface), interface_motion(element, interface)
    center = node.position_m + ring.center_of_gravity_m
    body = MassProperties(element.mass_kg, element.center_of_gravity_m, element.inertia_kg_m2)
    whole = joined_mass_properties((body, ring._replace(center_of_gravity_m=center)))
    moments = rigid_motion_moments(ring.mass_kg, center, ring.inertia_kg_m2, node.position_m)
    own = rigid_body_mass_matrix(*ring)
    turning = {"gyroscopic": _gyroscopic(float(ring.inertia_kg_m2[2, 2]))}
    if element.frame == "rotating":
        turning = _rotating(own, moments.second_kg)
    spun = {name: getattr(element, name) + placed.T @ a @ placed for name, a in turning.items()}
    return dataclasses.replace(
        element,
        mass=element.mass + placed.T @ own @ placed,
        **spun,
        **whole._asdict(),
        moments=joined_moments(element.moments, projected_moments(moments, placed)),
    )


def _rotating(mass: FloatArray, second: FloatArray) -> dict[str, FloatArray]:
    """G, Kgeo and S at unit spin of a rigid body in its own axes, (6, 6) each.

    `second`: ∫ φ_a φ_b dm of its six motions. What stands still in space needs no force: with the
    turn T of the motions Kgeo = S + G T − M T².
    """
    gyroscopic = 2.0 * (second[1, 0] - second[0, 1])
    softening = second[0, 0] + second[1, 1]
    stiffening = softening + gyroscopic @ RIGID_TURN - mass @ RIGID_TURN @ RIGID_TURN
    return {
        "gyroscopic": gyroscopic,
        "stress_stiffening": 0.5 * (stiffening + stiffening.T),
        "spin_softening": softening,
    }


def _check_disk(
    where: str, components: tuple[Component, ...], numbers: Mapping[str, float]
) -> None:
    if not components:
        raise SuperelementError(f"{where}: the interface has no coordinates to carry a disk")
    for label, value in numbers.items():
        allowed = "a finite number" if label == "offset_m" else "0 or more"
        if not (np.isfinite(value) and (value >= 0 or label == "offset_m")):
            raise SuperelementError(f"{where}: {label} is {value}, allowed is {allowed}")
    for translation, tilt in (("ux", "ry"), ("uy", "rx")):
        if numbers["offset_m"] and translation in components and tilt not in components:
            raise SuperelementError(
                f"{where}: offset_m {numbers['offset_m']} needs component {tilt!r} beside "
                f"{translation!r}; the interface has {list(components)}"
            )


#: L of a rigid body on ux to rz: a quarter turn of the lateral ones, ux to uy, rx to ry.
RIGID_TURN = np.zeros((6, 6))
RIGID_TURN[1, 0] = RIGID_TURN[4, 3] = 1.0
RIGID_TURN[0, 1] = RIGID_TURN[3, 4] = -1.0
RIGID_TURN.setflags(write=False)


def rigid_superelement(
    name: str,
    mass_kg: float,
    center_of_gravity_m: npt.ArrayLike,
    inertia_kg_m2: npt.ArrayLike,
    interface_positions_m: Mapping[str, npt.ArrayLike],
    components: tuple[Component, ...] = MOTIONS,
) -> Superelement:
    """Build the superelement of a rigid body with any number of interfaces.

    Parameters
    ----------
    center_of_gravity_m
        Shape (3,), m.
    inertia_kg_m2
        Tensor about the centre of gravity, shape (3, 3), or its diagonal, shape (3,), kg m².
    interface_positions_m
        Place of each interface by name, shape (3,), or its z on the axis, m; at least one.
    components
        Motions the body can make, of "ux" to "rz"; the others are held.

    Returns
    -------
    Superelement
        Level "lumped", with a `constraint` that ties all interfaces to one rigid motion. Its
        gyroscopic matrix is that of a spin about the z axis through the origin.

    Raises
    ------
    SuperelementError
        If a number is out of range or the body has no interface or motion.
    """
    where = f"rigid body {name!r}"
    center = np.array(center_of_gravity_m, dtype=float)
    inertia = np.array(inertia_kg_m2, dtype=float)
    inertia = np.diag(inertia) if inertia.shape == (3,) else inertia
    _check(where, float(mass_kg), center, inertia, interface_positions_m, components)
    positions = {
        key: np.array(place, dtype=float) if np.ndim(place) else np.array([0.0, 0.0, place])
        for key, place in interface_positions_m.items()
    }
    kept = [MOTIONS.index(c) for c in MOTIONS if c in components]
    return _tied_element(name, MassProperties(float(mass_kg), center, inertia), positions, kept)


def _tied_element(
    name: str, whole: MassProperties, positions: Mapping[str, FloatArray], kept: list[int]
) -> Superelement:
    """Return a body with those of the six motions, all interfaces tied to them."""
    motions = np.vstack([motion_at(place)[kept] for place in positions.values()])
    constraint = motions[:, kept]
    spread = np.linalg.pinv(constraint)
    mass = rigid_body_mass_matrix(*whole)[np.ix_(kept, kept)]
    gyroscopic = _gyroscopic(float(whole.inertia_kg_m2[2, 2]))[np.ix_(kept, kept)]
    n = constraint.shape[0]
    rigid = np.zeros((n, 6))
    rigid[:, kept] = constraint
    none = np.empty(0)
    return Superelement(
        name=name,
        level="lumped",
        harmonics=(),
        coordinates=tuple(
            Coordinate(kind="interface", interface=name, component=MOTIONS[k], frequency_hz=0.0)
            for name in positions
            for k in kept
        ),
        interfaces=tuple(
            InterfaceNode(name=k, position_m=x, coupling="none") for k, x in positions.items()
        ),
        mass=spread.T @ mass @ spread,
        stiffness=np.zeros((n, n)),
        gyroscopic=spread.T @ gyroscopic @ spread,
        stress_stiffening=np.zeros((n, n)),
        spin_softening=np.zeros((n, n)),
        rigid_body_modes=rigid,
        rigid_body_present=np.isin(np.arange(6), kept),
        **whole._asdict(),
        full_dofs=len(kept),
        maximum_speed_rad_s=np.inf,
        recovery_points_m=np.array(list(positions.values())),
        recovery_modes=_recovery(len(positions), kept),
        free_frequencies_hz=none,
        fixed_interface_frequencies_hz=none,
        frequency_error_estimate=none,
        provenance={"model": "rigid body", "components": [MOTIONS[k] for k in kept]},
        spin_generator=np.kron(np.eye(len(positions)), RIGID_TURN[np.ix_(kept, kept)]),
        constraint=constraint,
        moments=projected_moments(rigid_motion_moments(*whole), np.eye(6)[:, kept] @ spread),
    )


def _check(
    where: str,
    mass_kg: float,
    center: FloatArray,
    inertia: FloatArray,
    interfaces: Mapping[str, npt.ArrayLike],
    components: tuple[Component, ...],
) -> None:
    if not (np.isfinite(mass_kg) and mass_kg > 0):
        raise SuperelementError(f"{where}: mass_kg is {mass_kg}; it must be positive")
    if center.shape != (3,) or not np.isfinite(center).all():
        raise SuperelementError(f"{where}: center_of_gravity_m is {center.tolist()}; 3 numbers")
    even = inertia.shape == (3, 3) and np.isfinite(inertia).all()
    if not even or np.linalg.eigvalsh(0.5 * (inertia + inertia.T)).min() <= 0:
        raise SuperelementError(
            f"{where}: inertia_kg_m2 is {inertia.tolist()}; a positive definite (3, 3) or 3 "
            "positive numbers are allowed"
        )
    if not interfaces:
        raise SuperelementError(f"{where}: has no interface; at least one is needed")
    if not components or not set(components) <= set(MOTIONS):
        raise SuperelementError(f"{where}: components {components}; allowed are some of {MOTIONS}")


def _gyroscopic(polar: float) -> FloatArray:
    """Return G of a spinning body of revolution: Ip (rx ry' − ry rx')."""
    matrix = np.zeros((6, 6))
    matrix[3, 4], matrix[4, 3] = polar, -polar
    return matrix


def _recovery(count: int, kept: list[int]) -> FloatArray:
    """Return the translations of the interfaces, shape (count, 3, n)."""
    modes = np.einsum("pq,am->paqm", np.eye(count), np.eye(6)[:3, kept])
    return np.asarray(modes.reshape(count, 3, -1))
