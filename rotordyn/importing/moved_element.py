"""A superelement again under another name, with other names of its interfaces, at another place."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np

from solidwhirl.rotordyn.core.arrays import motion_at
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.superelement.mass_moments import MassMoments
from solidwhirl.rotordyn.superelement.record import Superelement


def renamed_superelement(
    element: Superelement, name: str, interfaces: Mapping[str, str]
) -> Superelement:
    """Return a superelement with other names; `interfaces`: old names by the new ones."""
    new_names = {old: new for new, old in interfaces.items()}
    known = [node.name for node in element.interfaces]
    for new, old in interfaces.items():
        if old not in known:
            raise SuperelementError(
                f"superelement {element.name!r} has no interface {old!r}, which {new!r} is to be; "
                f"it has {known}"
            )
    if len(new_names) < len(interfaces):
        raise SuperelementError(
            f"superelement {element.name!r}: two names for one interface in {dict(interfaces)}"
        )
    return dataclasses.replace(
        element,
        name=name,
        interfaces=tuple(
            dataclasses.replace(node, name=new_names.get(node.name, node.name))
            for node in element.interfaces
        ),
        coordinates=tuple(
            dataclasses.replace(c, interface=new_names.get(c.interface, c.interface))
            for c in element.coordinates
        ),
    )


def shifted_superelement(element: Superelement, along_m: float) -> Superelement:
    """Return a superelement at another place on the axis."""
    if along_m == 0.0:
        return element
    shift = np.array([0.0, 0.0, along_m])
    motions = np.array(element.rigid_body_modes)
    # a rotation about the origin moves the body's own origin by θ × shift
    motions[:, 3:] += motions[:, :3] @ motion_at(shift)[:3, 3:]
    motions[:, ~element.rigid_body_present] = 0.0
    changes: dict[str, Any] = {}
    if element.moments is not None:
        moments = element.moments
        first = np.array(moments.first_kg_m)
        first[2] += along_m * moments.displacement_kg
        changes["moments"] = MassMoments(
            displacement_kg=moments.displacement_kg,
            first_kg_m=first,
            second_kg=moments.second_kg,
        )
    surface = element.surface
    if surface is not None:
        axis = 0 if surface.points_m.shape[1] == 2 else 2
        points = np.array(surface.points_m)
        points[:, axis] += along_m
        changes["surface"] = dataclasses.replace(surface, points_m=points)
    return dataclasses.replace(
        element,
        interfaces=tuple(
            dataclasses.replace(node, position_m=node.position_m + shift)
            for node in element.interfaces
        ),
        rigid_body_modes=motions,
        center_of_gravity_m=element.center_of_gravity_m + shift,
        recovery_points_m=element.recovery_points_m + shift,
        **changes,
    )
