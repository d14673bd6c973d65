"""Shapes of nodal-diameter modes: stress at the roots of blades, arrays of files, pictures.

All shapes are those of a unit of the largest displacement over a cycle on the outer surface.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from solidwhirl.core.blocks import TurningMode, TurningModes
from solidwhirl.rotordyn import nodal_diameters as nd
from solidwhirl.rotordyn.core.arrays import FloatArray, Matrix

Document = Mapping[str, Any]
DIRECTIONS: tuple[nd.Direction, ...] = ("backward", "forward")


def family_amplitudes(amplitudes: Matrix, family: nd.Family, at: int) -> Matrix:
    """Return the fields of the modes of a family at a speed, (p, 3, m), of unit largest size.

    `amplitudes`: of the coordinates of its index, (p, 3, n). `at`: number of the speed.
    """
    moved = amplitudes @ family.vectors[at]
    return np.asarray(moved / nd.cycle_peak(moved).max(axis=0))


def root_document(shapes: Any, modes: nd.NodalDiameterModes, count: int) -> dict[str, Any] | None:
    """Return stress amplitudes at the roots over the largest displacement, by direction (h, s, m).

    None where no blades are known. `count`: modes, of which few may be fewer.
    """
    if not any(shapes.roots):
        return None
    document: dict[str, Any] = {"nominal_pa_per_m": {}, "peak_pa_per_m": {}}
    for direction in DIRECTIONS:
        found = [
            _stresses(roots, amplitudes, modes, (own.index, direction))
            for own, roots, amplitudes in zip(
                modes.body.indices, shapes.roots, shapes.amplitudes, strict=True
            )
        ]
        for k, key in enumerate(document):
            document[key][direction] = [
                np.pad(f[k], ((0, 0), (0, count - f.shape[2])), constant_values=np.nan).tolist()
                for f in found
            ]
    return document


def _stresses(
    roots: Sequence[nd.BladeRoot], amplitudes: Matrix, modes: nd.NodalDiameterModes,
    which: tuple[int, Any],
) -> FloatArray:  # fmt: skip
    """Nominal and peak stress of a family, the largest of all roots, (2, s, m)."""
    family = modes.family(*which)
    out = []
    for k, speed in enumerate(modes.speeds_rad_s.tolist()):
        vectors, rates = family.vectors[k], family.frequency_hz[k] / nd.HZ_PER_RAD_S
        signed = -rates if family.direction == "forward" else rates
        found = [nd.root_stress(root, signed, speed, vectors) for root in roots]
        out.append(np.max(found, axis=0) / nd.cycle_peak(amplitudes @ vectors).max(axis=0))
    return np.stack(out, axis=1)


def file_arrays(body: nd.CyclicBody, shapes: Any, modes: nd.NodalDiameterModes) -> dict[str, Any]:
    """Return what a file holds: matrices of every index, the surface, and its modes.

    Modes are those of the first and the last speed: Φ (2, p, 3, m) of every index and direction.
    """
    arrays: dict[str, Any] = {
        "nodal_diameter": np.array([m.index for m in body.indices]),
        "points_m": shapes.points_m,
        "cells": shapes.cells,
    }
    for own, amplitudes in zip(body.indices, shapes.amplitudes, strict=True):
        for name in ("mass", "stiffness", "coriolis", "centrifugal"):
            arrays[f"{name}_{own.index}"] = getattr(own, name)
        for direction in nd.directions_of(body, own.index):
            family = modes.family(own.index, direction)
            moved = [family_amplitudes(amplitudes, family, at) for at in (0, -1)]
            arrays[f"displacement_{own.index}_{direction}"] = np.array(moved, dtype=np.complex64)
    return arrays


def turning_modes(document: Document, record: Mapping[str, Any]) -> TurningModes:
    """Return the modes at the first and the last speed for a picture in space."""
    states = []
    for at in (0, -1):
        rpm = f"{document['speed_rpm'][at]:.0f} rpm"
        for k, index in enumerate(document["nodal_diameter"]):
            waves = "nodal diameter" if index == 1 else "nodal diameters"
            shown = _modes_at(document, record, k, at)
            states.append((f"{index} {waves}, {rpm}", shown))
    return TurningModes(
        name="blade-modes",
        title="Modes in space",
        caption="The modes in the frame that turns with the body, much enlarged and slowed down: "
        "a backward wave runs against the spin (which is counterclockwise as seen from the end of "
        "large z), a forward one with it. Each mode has its own scale.",
        alt=f"Viewer of the modes of {document['body']} with "
        f"{document['nodal_diameter'][0]} to {document['nodal_diameter'][-1]} nodal diameters in "
        "space; the table of frequencies has their numbers.",
        body=document["body"],
        points_m=record["points_m"],
        cells=record["cells"],
        copies=document["sectors"],
        states=states,
    )


def _modes_at(document: Document, record: Mapping[str, Any], k: int, at: int) -> list[TurningMode]:
    """All modes of a nodal diameter at a speed."""
    index, found = document["nodal_diameter"][k], []
    for direction in ("standing",) if document["standing"][k] else DIRECTIONS:
        key = "backward" if direction == "standing" else direction
        fields = record[f"displacement_{index}_{direction}"][at]
        for mode in range(fields.shape[2]):
            hertz = document["frequency_hz"][key][k][at][mode]
            moved, order = fields[:, :, mode], index
            if direction == "forward":  # Re[Φ e^{-iωt}] = Re[Φ* e^{iωt}]
                moved, order = moved.conj(), -index
            found.append(
                TurningMode(
                    label=f"mode {mode + 1}, {direction}, {hertz:.5g} Hz",
                    hertz=hertz,
                    whirl="straight" if direction == "standing" else direction,
                    order=order,
                    displacement=moved,
                )
            )
    return found
