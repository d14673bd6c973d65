"""A body whose stages have no common sector: a drum, a sector of every stage, and their joints.

Stage and drum are meshed apart from each other and meet at joints, along the edges that the drum's
meridian has there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from solidwhirl.geometry import Body
from solidwhirl.geometry.parts import JOINT, layout_of, part_bodies
from solidwhirl.meshing.own.features.sector import mesh_sector
from solidwhirl.meshing.own.meridian import compact, mesh_meridian
from solidwhirl.meshing.own.revolved import revolved, sectors_of, unfolded
from solidwhirl.meshing.records import FloatArray, IntArray, Mesh, MeshSize, Parts
from solidwhirl.rotordyn.core.arrays import BoolArray

# Pitches from the joints within which the drum is copied for the fields of one more order.
_PITCHES = 2.0


def mesh_joined(body: Body, size: MeshSize) -> Mesh:
    """Mesh the drum and one sector of every stage, with copies of the drum for further orders.

    A further order is that of some stages, and copied for it is what of the drum is near to them.

    `body`: its symmetry is "staged". Returned: `Mesh.parts` says what is what; points (x, y, z)
    [m]. Raises GeometryError: see `layout_of`, or an interface on both drum and stage. Raises
    MeshingError: what meshing a part raises.
    """
    layout = layout_of(body)
    bodies = part_bodies(body, layout)
    pieces = len(layout.drum)
    meridians = [mesh_meridian(part, size) for part in bodies[:pieces]]
    sectors = max(sectors_of(meridian) for meridian in meridians)
    meshes = [revolved(meridian, sectors) for meridian in meridians]
    meshes += [mesh_sector(part, size) for part in bodies[pieces:]]
    if not all(mesh.sector is not None and mesh.sector.mirrored for mesh in meshes):
        meshes = [unfolded(m) if m.sector is not None and m.sector.mirrored else m for m in meshes]
    shifts: list[int | None] = [*[0] * pieces, *[None] * len(layout.stages)]
    drum, stages = meshes[:pieces], meshes[pieces:]
    for count in sorted(set(layout.counts)):
        # joints of the stages that have fields of this order: no other drum is reached by it
        having = [s for s, n in zip(stages, layout.counts, strict=True) if count % n == 0]
        reached = {name for stage in having for name in _joints(stage)}
        own = [(piece, reached & set(_joints(piece))) for piece in drum]
        copies = [_near(piece, names, count) for piece, names in own if names]
        for shift in (count, -count):
            meshes += copies
            shifts += [shift] * len(copies)
    edges = [m.points[rows[:, :2]] for m in meridians for rows in _joints(m).values()]
    return _merged(meshes, tuple(shifts), np.concatenate(edges))


def _near(mesh: Mesh, names: set[str], count: int) -> Mesh:
    """Copy a piece of the drum where fields of an order reach from some of its joints.

    They fall by exp(-2 pi) from one pitch to the next. Cells further than that are left out.
    """
    on = np.unique(np.concatenate([mesh.interfaces[name].ravel() for name in names]))
    z_r = np.column_stack([mesh.points[:, 2], np.hypot(mesh.points[:, 0], mesh.points[:, 1])])
    away = cKDTree(z_r[on]).query(z_r)[0]
    is_near = away <= _PITCHES * 2.0 * np.pi * z_r[on, 1].max() / count
    kept = {n: rows[is_near[rows].all(axis=1)] for n, rows in _joints(mesh).items()}
    interfaces = {n: rows for n, rows in kept.items() if len(rows)}
    return _cells_of(replace(mesh, interfaces=interfaces), is_near[mesh.cells].any(axis=1))


def own_parts(mesh: Mesh) -> tuple[Mesh, ...]:
    """Return every part of a joined mesh by itself, copies of the drum left out; else the mesh."""
    if mesh.parts is None:
        return (mesh,)
    parts = mesh.parts
    return tuple(
        replace(_cells_of(mesh, parts.cell_part == k), sector=sector)
        for k, (sector, shift) in enumerate(zip(parts.sectors, parts.shifts, strict=True))
        if not shift
    )


def without_copies(mesh: Mesh) -> Mesh:
    """Return a joined mesh without the copies of its drum, which lie where the drum does."""
    assert mesh.parts is not None
    is_own = np.array([not shift for shift in mesh.parts.shifts])
    return _cells_of(mesh, is_own[mesh.parts.cell_part])


def _cells_of(mesh: Mesh, chosen: BoolArray) -> Mesh:
    """Some cells of a mesh, which is no joined one any more."""
    cells, points, used = compact(mesh.points, mesh.cells[chosen])
    return replace(
        mesh,
        points=points,
        cells=cells,
        cell_section=mesh.cell_section[chosen],
        cell_material=mesh.cell_material[chosen],
        interfaces={n: used[f[(used[f] >= 0).all(axis=1)]] for n, f in mesh.interfaces.items()},
        outline=used[mesh.outline[used[mesh.outline] >= 0]],
        parts=None,
    )


def _joints(mesh: Mesh) -> dict[str, IntArray]:
    return {name: rows for name, rows in mesh.interfaces.items() if name.startswith(JOINT)}


def _merged(meshes: Sequence[Mesh], shifts: tuple[int | None, ...], edges: FloatArray) -> Mesh:
    """One mesh of parts that have no nodes in common."""
    starts = np.concatenate([[0], np.cumsum([len(m.points) for m in meshes])])[:-1]
    sections = tuple(dict.fromkeys(name for m in meshes for name in m.section_names))
    materials = tuple(dict.fromkeys(material for m in meshes for material in m.materials))
    interfaces: dict[str, IntArray] = {}
    joints, section, material = [], [], []
    for mesh, start in zip(meshes, starts, strict=True):
        joints += [rows + start for rows in _joints(mesh).values()]
        own = {n: rows + start for n, rows in mesh.interfaces.items() if n not in _joints(mesh)}
        interfaces |= own
        section.append(np.array([sections.index(n) for n in mesh.section_names])[mesh.cell_section])
        material.append(np.array([materials.index(m) for m in mesh.materials])[mesh.cell_material])
    drum = meshes[0]
    assert all(m.sector is not None for m in meshes)
    worst = min(meshes, key=lambda m: m.quality.minimum_scaled_jacobian)
    return replace(
        drum,
        points=np.concatenate([m.points for m in meshes]),
        cells=np.concatenate([m.cells + s for m, s in zip(meshes, starts, strict=True)]),
        cell_section=np.concatenate(section),
        cell_material=np.concatenate(material),
        materials=materials,
        section_names=sections,
        interfaces=interfaces,
        quality=worst.quality,
        parts=Parts(
            sectors=tuple(m.sector for m in meshes if m.sector is not None),
            shifts=shifts,
            cell_part=np.repeat(np.arange(len(meshes)), [len(m.cells) for m in meshes]),
            joint_facets=np.concatenate(joints),
            joint_edges_m=edges,
        ),
    )
