"""Parametric bodies as solids in a STEP file."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import gmsh
import numpy as np

from solidwhirl.geometry import Blade, Body, merge_fillets, subdivide
from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.own.drawing import draw, gmsh_session
from solidwhirl.meshing.own.features.solids import feature_solid
from solidwhirl.rotordyn.core.atomic import replacing

# Unit of a STEP file by its length [m], as gmsh names it.
_UNITS = {1e-3: "MM", 1.0: "M"}
# Largest relative difference between the volume of a solid and the ring that it should be.
_SAME_VOLUME = 1e-6
# Names that the kernel gives: of the whole, and of its parts by number.
_PRODUCT = re.compile(r"'Open CASCADE STEP translator [0-9.]+ [0-9]+(?:\.([0-9]+))?'")


def write_step(bodies: Sequence[Body], path: Path, *, unit_m: float = 1e-3) -> tuple[str, ...]:
    """Write bodies as closed solids, one for every region of one material.

    `bodies`: the bodies, with their fillets, blades, holes and slots. Rigid disks are no geometry
    and are left out. `path`: the file; it appears when it is complete. `unit_m`: unit of its
    coordinates: 1e-3 (millimetres) or 1. Result: names of the solids, body_material. Raises
    GeometryError: an invalid body.
    Raises MeshingError: the kernel made no closed solids.
    """
    if unit_m not in _UNITS:
        raise MeshingError(f"unit_m is {unit_m}; allowed are {', '.join(map(str, _UNITS))}")
    occ = gmsh.model.occ
    with gmsh_session():
        gmsh.option.setString("Geometry.OCCTargetUnit", _UNITS[unit_m])
        solids = [pair for body in bodies for pair in _revolved(body, unit_m)]
        for dimension in (2, 1, 0):  # what bounds no solid
            occ.remove(occ.getEntities(dimension))
        occ.synchronize()
        names = tuple(name for _, name in sorted(solids))
        with replacing(path) as temporary:
            drawn = temporary.with_name(temporary.name + ".step")  # gmsh goes by the suffix
            try:
                gmsh.write(str(drawn))
                text = drawn.read_text(encoding="utf-8")
                temporary.write_text(_named(text, path.stem, names), encoding="utf-8")
            finally:
                drawn.unlink(missing_ok=True)
    return names


def _revolved(body: Body, unit_m: float) -> list[tuple[int, str]]:
    """Solids of a body by tag, with their names, in the open gmsh model."""
    subdivision = merge_fillets(subdivide(body))
    drawing = draw(subdivision, unit_m)
    occ = gmsh.model.occ
    regions: dict[int, list[tuple[int, int]]] = {}
    for tag, face in zip(drawing.faces, subdivision.faces, strict=True):
        regions.setdefault(face.material, []).append((2, tag))
    solids, expected = [], 0.0
    for material, faces in regions.items():
        joined = occ.fuse(faces[:1], faces[1:])[0] if len(faces) > 1 else faces
        for _, tag in joined:
            area, (r, _, _) = occ.getMass(2, tag), occ.getCenterOfMass(2, tag)
            expected += 2.0 * np.pi * r * area  # Pappus
            swept = occ.revolve([(2, tag)], 0, 0, 0, 0, 0, 1, 2.0 * np.pi)
            name = f"{body.name}_{subdivision.materials[material].name}"
            solids += [(t, name) for dimension, t in swept if dimension == 3]
    solids, more = _with_features(body, solids, unit_m)
    found, expected = sum(occ.getMass(3, tag) for tag, _ in solids), expected + more
    if not solids or abs(found / expected - 1.0) > _SAME_VOLUME:
        raise MeshingError(
            f"body {body.name!r}: the CAD kernel made {len(solids)} solids of {found:.9g} in "
            f"place of {expected:.9g} cubed units"
        )
    return solids


def _with_features(
    body: Body, solids: list[tuple[int, str]], unit_m: float
) -> tuple[list[tuple[int, str]], float]:
    """Solids with all features cut out or joined on, and the volume that this should add."""
    occ = gmsh.model.occ
    more = 0.0
    for feature in body.features:
        copies = feature_solid(feature, body, np.radians(feature.angle_deg), unit_m)
        drawn = [(3, tag) for tag, _ in solids]
        if isinstance(feature, Blade):
            more += feature.count * occ.getMass(*copies[0])
        else:
            common = occ.intersect(occ.copy(copies), drawn, removeTool=False)[0]
            more -= feature.count * sum(occ.getMass(*pair) for pair in common)
            occ.remove(common, recursive=True)
        for k in range(1, feature.count):
            copies += occ.copy(copies[:1])
            occ.rotate(copies[-1:], 0, 0, 0, 0, 0, 1, 2.0 * np.pi * k / feature.count)
        if isinstance(feature, Blade):
            name = f"{body.name}_{feature.material.name}"
            same = [(3, tag) for tag, own in solids if own == name]
            joined = occ.fuse(same, copies)[0] if same else copies
            solids = [(tag, own) for tag, own in solids if own != name]
            solids += [(tag, name) for _, tag in joined]
        else:
            parts = occ.cut(drawn, copies)[1][: len(solids)]
            cut = zip(solids, parts, strict=True)
            solids = [(tag, name) for (_, name), own in cut for _, tag in own]
    return solids, more


def _named(text: str, whole: str, names: Sequence[str]) -> str:
    """The file with the names of its solids in the place of the kernel's own."""

    def name(found: re.Match[str]) -> str:
        number = int(found[1]) - 1 if found[1] else -1
        return f"'{names[number] if 0 <= number < len(names) else whole}'"

    return _PRODUCT.sub(name, text)
