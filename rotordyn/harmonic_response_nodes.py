"""Complex amplitudes of interface nodes from those of the independent coordinates."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.coordinates import interface_row
from solidwhirl.rotordyn.errors import AnalysisError
from solidwhirl.rotordyn.parts import End
from solidwhirl.rotordyn.system import AssembledSystem

TRANSLATIONS = ("ux", "uy")
TILTS = ("rx", "ry")


def interface_nodes(assembled: AssembledSystem) -> tuple[End, ...]:
    """Return all interface nodes of a system, body by body.

    Parameters
    ----------
    assembled
        The system.

    Returns
    -------
    tuple of End
        In the order of the bodies and of their interfaces.
    """
    return tuple(
        End(body=name, interface=node.name)
        for name, rotor in assembled.system.rotors.items()
        for node in rotor.element.interfaces
    )


def node_amplitudes(
    assembled: AssembledSystem,
    nodes: Sequence[End],
    components: Sequence[str],
    displacement: ComplexArray,
) -> ComplexArray:
    """Return motions of interface nodes.

    Parameters
    ----------
    assembled
        The system.
    nodes
        Where.
    components
        Of "ux" to "rz".
    displacement
        Amplitudes of the independent coordinates, shape (p, n).

    Returns
    -------
    ndarray
        Shape (p, nodes, components), m and rad; nan where a node lacks the component.
    """
    motion = np.full((displacement.shape[0], len(nodes), len(components)), complex(np.nan))
    for at, node in enumerate(nodes):
        element = assembled.system.rotors[node.body].element
        for place, component in enumerate(components):
            if component in element.components_at(node.interface):
                row = interface_row(assembled, node.body, node.interface, component)
                motion[:, at, place] = displacement @ row
    return motion


def check_lateral(assembled: AssembledSystem, node: End, what: str) -> None:
    """Refuse a node that does not exist or lacks ux or uy.

    Parameters
    ----------
    assembled
        The system.
    node
        Where.
    what
        Begins the message, such as "unbalance 2".

    Raises
    ------
    AnalysisError
        The message names what exists.
    """
    rotors = assembled.system.rotors
    if node.body not in rotors:
        raise AnalysisError(f"{what}: there is no body {node.body!r}; there are {list(rotors)}")
    element = rotors[node.body].element
    names = [interface.name for interface in element.interfaces]
    if node.interface not in names:
        raise AnalysisError(
            f"{what}: body {node.body!r} has no interface {node.interface!r}; it has {names}"
        )
    has = element.components_at(node.interface)
    if not set(TRANSLATIONS) <= set(has):
        raise AnalysisError(f"{what}: {node.label} needs ux and uy; it has {list(has)}")


def non_negative(name: str, values: npt.ArrayLike) -> FloatArray:
    """Return speeds or frequencies as an array.

    Parameters
    ----------
    name
        Of the argument, for the message.
    values
        A list of numbers.

    Returns
    -------
    ndarray
        Shape (s,).

    Raises
    ------
    AnalysisError
        If it is not a list of finite numbers, 0 or more.
    """
    array = np.array(values, dtype=float)
    if array.ndim != 1 or not array.size or not np.isfinite(array).all() or array.min() < 0:
        raise AnalysisError(
            f"{name} needs a list of finite numbers, 0 or more; found {values!r:.200}"
        )
    return array
