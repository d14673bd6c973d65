"""Rigid bodies such as casings and hubs, delivered as superelements like every other body."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.errors import SuperelementError
from solidwhirl.rotordyn.mass_moments import projected_moments, rigid_motion_moments
from solidwhirl.rotordyn.rigid_body import rigid_body_mass_matrix
from solidwhirl.rotordyn.superelement import Coordinate, InterfaceNode, Superelement
from solidwhirl.rotordyn.superelement_checks import MOTIONS, Component


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
    name
        Name of the body.
    mass_kg
        Mass, kg.
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
        key: np.array(place, dtype=float) if np.ndim(place) else np.array([0.0, 0.0, float(place)])  # type: ignore[arg-type]
        for key, place in interface_positions_m.items()
    }
    kept = [MOTIONS.index(c) for c in MOTIONS if c in components]
    motions = np.vstack([_motion_at(place)[kept] for place in positions.values()])
    constraint = motions[:, kept]
    spread = np.linalg.pinv(constraint)
    mass = rigid_body_mass_matrix(float(mass_kg), center, inertia)[np.ix_(kept, kept)]
    gyroscopic = _gyroscopic(float(inertia[2, 2]))[np.ix_(kept, kept)]
    n = constraint.shape[0]
    rigid = np.zeros((n, 6))
    rigid[:, kept] = constraint
    turn = np.zeros((6, 6))
    turn[1, 0] = turn[4, 3] = 1.0
    turn[0, 1] = turn[3, 4] = -1.0
    return Superelement(
        name=name,
        level="lumped",
        harmonics=(),
        coordinates=tuple(
            Coordinate(kind="interface", interface=key, component=MOTIONS[k], frequency_hz=0.0)
            for key in positions
            for k in kept
        ),
        interfaces=tuple(
            InterfaceNode(name=key, position_m=place, coupling="none")
            for key, place in positions.items()
        ),
        mass=spread.T @ mass @ spread,
        stiffness=np.zeros((n, n)),
        gyroscopic=spread.T @ gyroscopic @ spread,
        stress_stiffening=np.zeros((n, n)),
        spin_softening=np.zeros((n, n)),
        rigid_body_modes=rigid,
        rigid_body_present=np.isin(np.arange(6), kept),
        mass_kg=float(mass_kg),
        center_of_gravity_m=center,
        inertia_kg_m2=inertia,
        full_dofs=len(kept),
        maximum_speed_rad_s=np.inf,
        recovery_points_m=np.array(list(positions.values())),
        recovery_modes=_recovery(len(positions), kept),
        free_frequencies_hz=np.empty(0),
        fixed_interface_frequencies_hz=np.empty(0),
        frequency_error_estimate=np.empty(0),
        provenance={"model": "rigid body", "components": [MOTIONS[k] for k in kept]},
        spin_generator=np.kron(np.eye(len(positions)), turn[np.ix_(kept, kept)]),
        constraint=constraint,
        moments=projected_moments(
            rigid_motion_moments(float(mass_kg), center, inertia), np.eye(6)[:, kept] @ spread
        ),
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


def _motion_at(place: FloatArray) -> FloatArray:
    """Return ux to rz at a place for the six motions about the origin, shape (6, 6)."""
    x, y, z = place
    motion = np.eye(6)
    motion[:3, 3:] = -np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return motion


def _gyroscopic(polar: float) -> FloatArray:
    """Return G of a spinning body of revolution: Ip (rx ry' − ry rx')."""
    matrix = np.zeros((6, 6))
    matrix[3, 4], matrix[4, 3] = polar, -polar
    return matrix


def _recovery(count: int, kept: list[int]) -> FloatArray:
    modes = np.zeros((count, 3, count * len(kept)))
    for point in range(count):
        for column, motion in enumerate(kept):
            if motion < 3:
                modes[point, motion, point * len(kept) + column] = 1.0
    return modes
