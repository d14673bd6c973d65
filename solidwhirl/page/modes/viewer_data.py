"""What the viewer of mode shapes is given, as `shapes.js` reads it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from solidwhirl.drawing.modes import ShownModes
from solidwhirl.drawing.motion import EngineInSpace, mode_in_space, with_few_points
from solidwhirl.drawing.surfaces import Piece
from solidwhirl.rotordyn.core.arrays import ComplexArray

_WHOLE = 32767
#: Numbers below this are zero; a step of them could not be represented.
NOTHING = 1e-290


def viewer_data(engine: EngineInSpace, shown: Sequence[ShownModes]) -> dict[str, Any]:
    """Return surfaces, centre lines, joints and motions of modes.

    Notes
    -----
    Motions are whole numbers of 16 bits, real and imaginary part of each amplitude in turn, times
    ``scale``.
    """
    engine = with_few_points(engine)
    rotors = engine.system.system.rotors
    bodies = list(rotors)
    first, last, radius = engine.reach_m
    return {
        "bodies": [{"name": n, "ratio": r.speed_ratio} for n, r in rotors.items()],
        "pieces": [
            {
                "body": bodies.index(p.body),
                "kind": p.surface.kind,
                "disk": bool(p.disk),
                "points": p.surface.points_m,
                "cells": p.surface.cells,
            }
            for p in engine.pieces
        ],
        "stations": {
            "body": np.array([bodies.index(s.body) for s in engine.stations]),
            "z": np.array([s.axial_m for s in engine.stations]),
            "orbit": np.array([s.has_orbit for s in engine.stations], dtype=int),
        },
        "lines": [np.array(at) for at in engine.lines.values()],
        "joints": [joint._asdict() for joint in engine.joints],
        "reach": {"first": first, "last": last, "radius": radius},
        "states": [
            {"label": s.label, "modes": [_mode(engine, s, k) for k in range(len(s.texts))]}
            for s in shown
        ],
    }


def _mode(engine: EngineInSpace, shown: ShownModes, k: int) -> dict[str, Any]:
    mode = mode_in_space(engine, shown, k)
    value = shown.modes.eigenvalues[k]
    return {
        "label": shown.texts[k],
        "hertz": float(value.imag / (2.0 * np.pi)),
        "rpm": float(shown.rpm[k]),
        "whirl": shown.whirl[k],
        "growth": float(value.real),
        "terms": [_terms(piece, mode.coordinates[piece.body]) for piece in engine.pieces],
        "center": packed(mode.center),
        "sense": list(mode.senses),
    }


def _terms(piece: Piece, motion: ComplexArray) -> dict[str, Any]:
    """Amplitudes (p, 3) by circumferential order and family; of a solid order 0, family 0."""
    surface = piece.surface
    q = motion[surface.coordinate]
    orders, families, values = [], [], []
    for order, family in sorted(
        {*zip(surface.order.tolist(), surface.family.tolist(), strict=True)}
    ):
        own = (surface.order == order) & (surface.family == family)
        if np.any(q[own]):
            orders.append(order)
            families.append(family)
            values.append(surface.amplitudes[:, :, own] @ q[own])
    return {"order": orders, "family": families, **packed(np.array(values))}


def packed(values: ComplexArray) -> dict[str, Any]:
    """Return complex numbers as whole ones of 16 bits, two to a number of 32, and their scale.

    `values`: of any shape; real and imaginary parts follow each other.
    """
    flat = np.ascontiguousarray(values, dtype=complex).view(float).ravel()
    largest = float(np.abs(flat).max(initial=0.0))
    scale = largest / _WHOLE if largest > NOTHING else 1.0
    whole = np.round(flat / scale).astype("<i2")
    return {"scale": scale, "packed": whole.view("<i4")}
