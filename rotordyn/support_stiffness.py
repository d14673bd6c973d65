"""The same system with other bearing stiffness, for maps over the stiffness of supports."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from solidwhirl.rotordyn.errors import AnalysisError
from solidwhirl.rotordyn.system import AssembledSystem, assemble


def with_bearing_stiffness(
    assembled: AssembledSystem, names: Sequence[str], stiffness_n_per_m: float
) -> AssembledSystem:
    """Assemble a system again with another lateral stiffness of some bearings.

    Parameters
    ----------
    assembled
        The system; it stays as it is.
    names
        Bearings that get the stiffness, one or more.
    stiffness_n_per_m
        k of the new stiffness k·I on (ux, uy), N/m; 0 or more.

    Returns
    -------
    AssembledSystem
        All else is that of `assembled`: rotors, gears, the other bearings, and the damping, tilt,
        axial and torsional stiffness of the named ones. A bearing with a speed law keeps it; k is
        what the law scales. The independent coordinates may be others, since joined ones are
        chosen by stiffness: compare motions of interfaces, not coordinates.

    Raises
    ------
    AnalysisError
        If a name is unknown, none is given, a named bearing joins ux or uy rigidly, or the
        stiffness is negative or not finite.
    """
    value = float(stiffness_n_per_m)
    if not (np.isfinite(value) and value >= 0):
        raise AnalysisError(f"stiffness_n_per_m is {value}; finite and 0 or more is allowed")
    system = assembled.system
    known = [bearing.name for bearing in system.bearings]
    unknown = [name for name in names if name not in known]
    if isinstance(names, str) or not names or unknown:
        raise AnalysisError(
            f"names is {names!r}; a sequence of one or more of the bearings {known} is allowed"
        )
    bearings = []
    for bearing in system.bearings:
        if bearing.name not in names:
            bearings.append(bearing)
            continue
        if {"ux", "uy"} & set(bearing.rigid):
            raise AnalysisError(
                f"bearing {bearing.name!r} joins {list(bearing.rigid)} rigidly and has no lateral "
                "stiffness to replace; name bearings with flexible ux and uy"
            )
        bearings.append(dataclasses.replace(bearing, stiffness_n_per_m=value * np.eye(2)))
    return assemble(system.rotors, tuple(bearings), system.reference, system.gears)
