"""Interfaces of a beam that are at one place: each keeps coordinates, tied to the same node."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np

from solidwhirl.geometry import Body
from solidwhirl.rotordyn import InterfaceNode, Superelement
from solidwhirl.rotordyn.mass_moments import projected_moments


def with_shared_seats(element: Superelement, body: Body, owner: Mapping[str, str]) -> Superelement:
    """Return a superelement with coordinates for all interfaces of a body.

    Parameters
    ----------
    element
        With the interfaces that have a node of their own.
    body
        The body.
    owner
        By the name of each interface of the body: the interface whose node it has.

    Returns
    -------
    Superelement
        With a `constraint`: interfaces of one node move as one.
    """
    modal = [c for c in element.coordinates if c.kind == "modal"]
    held = [
        (
            dataclasses.replace(c, interface=i.name),
            element.interface_index(owner[i.name], c.component),
        )
        for i in body.interfaces
        for c in element.coordinates
        if c.interface == owner[i.name]
    ]
    source = [k for _, k in held] + list(range(element.size - len(modal), element.size))
    tie = np.eye(element.size)[source]
    spread = np.linalg.pinv(tie)
    generator = element.spin_generator
    return dataclasses.replace(
        element,
        coordinates=(*(c for c, _ in held), *modal),
        interfaces=tuple(
            InterfaceNode(name=i.name, position_m=np.array(i.position_m), coupling="none")
            for i in body.interfaces
        ),
        mass=spread.T @ element.mass @ spread,
        stiffness=spread.T @ element.stiffness @ spread,
        gyroscopic=spread.T @ element.gyroscopic @ spread,
        stress_stiffening=spread.T @ element.stress_stiffening @ spread,
        spin_softening=spread.T @ element.spin_softening @ spread,
        rigid_body_modes=tie @ element.rigid_body_modes,
        recovery_modes=element.recovery_modes @ spread,
        spin_generator=None if generator is None else tie @ generator @ spread,
        constraint=tie,
        moments=projected_moments(element.moments, spread),
    )
