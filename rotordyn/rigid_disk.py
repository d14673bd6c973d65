"""Rigid disks added to a body at its interfaces."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np

from solidwhirl.rotordyn.errors import SuperelementError
from solidwhirl.rotordyn.mass_moments import (
    joined_moments,
    projected_moments,
    rigid_motion_moments,
)
from solidwhirl.rotordyn.rigid_body import (
    MassProperties,
    joined_mass_properties,
    rigid_body_mass_matrix,
)
from solidwhirl.rotordyn.superelement_checks import MOTIONS, Component

if TYPE_CHECKING:
    from solidwhirl.rotordyn.superelement import Superelement


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
    were. Components the interface lacks are left out. The free frequencies of the result are
    not known and become empty; the fixed-interface frequencies do not change.

    Parameters
    ----------
    element
        The body.
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
    where = f"disk {name!r} on superelement {element.name!r}"
    node = element.interface_node(interface)
    components = element.components_at(interface)
    _check_disk(where, components, mass_kg, polar_kg_m2, diametral_kg_m2, offset_m)
    inertia = np.diag([diametral_kg_m2, diametral_kg_m2, polar_kg_m2])
    disk_mass = rigid_body_mass_matrix(mass_kg, np.array([0.0, 0.0, offset_m]), inertia)
    disk_gyroscopic = np.zeros((6, 6))
    disk_gyroscopic[3, 4], disk_gyroscopic[4, 3] = polar_kg_m2, -polar_kg_m2

    index = np.array([element.interface_index(interface, c) for c in components])
    motion = np.array([MOTIONS.index(c) for c in components])
    mass, gyroscopic = element.mass.copy(), element.gyroscopic.copy()
    mass[np.ix_(index, index)] += disk_mass[np.ix_(motion, motion)]
    gyroscopic[np.ix_(index, index)] += disk_gyroscopic[np.ix_(motion, motion)]

    center = node.position_m + np.array([0.0, 0.0, offset_m])
    whole = joined_mass_properties(
        (
            MassProperties(element.mass_kg, element.center_of_gravity_m, element.inertia_kg_m2),
            MassProperties(mass_kg, center, inertia),
        )
    )
    placed = np.zeros((6, element.size))
    placed[motion, index] = 1.0
    own = rigid_motion_moments(mass_kg, center, inertia, node.position_m)
    record = {
        "name": name,
        "interface": interface,
        "mass_kg": float(mass_kg),
        "polar_kg_m2": float(polar_kg_m2),
        "diametral_kg_m2": float(diametral_kg_m2),
        "offset_m": float(offset_m),
    }
    disks = [*element.provenance.get("rigid_disks", []), record]
    return dataclasses.replace(
        element,
        mass=mass,
        gyroscopic=gyroscopic,
        mass_kg=whole.mass_kg,
        center_of_gravity_m=whole.center_of_gravity_m,
        inertia_kg_m2=whole.inertia_kg_m2,
        free_frequencies_hz=np.empty(0),
        provenance={**element.provenance, "rigid_disks": disks},
        moments=joined_moments(element.moments, projected_moments(own, placed)),
    )


def _check_disk(
    where: str,
    components: tuple[Component, ...],
    mass_kg: float,
    polar_kg_m2: float,
    diametral_kg_m2: float,
    offset_m: float,
) -> None:
    if not components:
        raise SuperelementError(f"{where}: the interface has no coordinates to carry a disk")
    numbers = {"mass_kg": mass_kg, "polar_kg_m2": polar_kg_m2, "diametral_kg_m2": diametral_kg_m2}
    for label, value in numbers.items():
        if not (np.isfinite(value) and value >= 0):
            raise SuperelementError(f"{where}: {label} is {value}, allowed is 0 or more")
    if not np.isfinite(offset_m):
        raise SuperelementError(f"{where}: offset_m is {offset_m}, allowed is a finite number")
    for translation, tilt in (("ux", "ry"), ("uy", "rx")):
        if offset_m and translation in components and tilt not in components:
            raise SuperelementError(
                f"{where}: offset_m {offset_m} needs component {tilt!r} beside {translation!r}; "
                f"the interface has {list(components)}"
            )
