"""Matrices of a beam model: bending in one plane, axial motion, torsion, before any reduction."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from solidwhirl.beam_level_elements import (
    Stretch,
    beam_matrices,
    beam_shapes,
    rod_matrices,
    stretch,
)
from solidwhirl.beam_level_fillets import Lump
from solidwhirl.beam_level_nodes import Layout
from solidwhirl.beam_level_plates import Edge, PlateMatrices, PlateMotion, plate_matrices
from solidwhirl.beam_level_profile import Cell, Place
from solidwhirl.beam_level_radial import plate_center_m
from solidwhirl.beam_level_roots import held_ring, root_stiffness
from solidwhirl.beam_level_sections import ShearRule, Spread, stiff_radii
from solidwhirl.beam_level_shadow import Rider, riders
from solidwhirl.rotordyn.arrays import FloatArray

DiskRule = Literal["rigid", "plate"]
RootRule = Literal["elastic", "rigid"]
Family = Literal["lateral", "axial", "torsion"]

# A rigid disk with an interface on its rim: its plate is this much stiffer than it is.
_RIGID = 1e4


class FamilyMatrices(NamedTuple):
    """M, K, gyroscopic weight, Kσ and S of one family of motions, and its rigid motions.

    Lateral coordinates are w, θ of every node, others one per node; those of plates follow. The
    rigid motions are the columns of `rigid`.
    """

    mass: FloatArray
    stiffness: FloatArray
    gyroscopic: FloatArray
    stiffening: FloatArray
    softening: FloatArray
    rigid: FloatArray


class Pieces(NamedTuple):
    """Cross-sections along all elements, and the rings that ride on them."""

    stretches: tuple[Stretch, ...]
    riders: tuple[Rider, ...]


def pieces_of(layout: Layout, spread: Spread, shear: ShearRule) -> Pieces:
    """Return stiffness and inertia along all elements.

    Parameters
    ----------
    layout
        Nodes and elements.
    spread, shear
        Stiffness rule and shear coefficient.

    Returns
    -------
    Pieces
    """
    radii = stiff_radii(layout.skeleton, spread)
    columns = layout.skeleton.columns
    along = tuple(
        stretch(columns[e.column], radii[e.column], e.ends_m, shear) for e in layout.elements
    )
    return Pieces(along, riders(layout, radii, along))


def family_matrices(
    layout: Layout,
    pieces: Pieces,
    family: Family,
    blocks: tuple[PlateBlock, ...],
    lumps: tuple[Lump, ...],
) -> FamilyMatrices:
    """Assemble one family of motions.

    Parameters
    ----------
    layout
        Nodes and elements.
    pieces
        From `pieces_of`.
    family
        "lateral" is bending in one plane, order w1, θ1, w2, θ2, ...
    blocks
        The family's plates.
    lumps
        Fillets.

    Returns
    -------
    FamilyMatrices
        Nodes that follow others are taken out: their rows and columns are zero.
    """
    per_node = 2 if family == "lateral" else 1
    size = per_node * layout.nodes_m.size + sum(block.extra for block in blocks)
    zero = np.zeros((size, size))
    found = FamilyMatrices(
        zero, zero.copy(), zero.copy(), zero.copy(), zero.copy(), np.zeros((size, per_node))
    )
    for element, piece in zip(layout.elements, pieces.stretches, strict=True):
        at = _dofs(element.nodes, per_node)
        own = (
            beam_matrices(piece)
            if family == "lateral"
            else rod_matrices(piece, twisted=family == "torsion")
        )
        for total, local in zip(found, own, strict=False):
            total[np.ix_(at, at)] += local
    for rider in pieces.riders:
        _add_rider(found, layout, pieces.stretches[rider.element], rider, family)
    next_free = per_node * layout.nodes_m.size
    for block in blocks:
        columns = np.zeros((len(block.matrices.mass), size))
        columns[: block.held, : block.edges.shape[1]] = block.edges
        columns[block.held :, next_free : next_free + block.extra] = np.eye(block.extra)
        next_free += block.extra
        for total, local in zip(found, block.matrices[:5], strict=False):
            total += columns.T @ local @ columns
    for lump in lumps:
        _add_lump(found, layout, lump, family)
    found.rigid[: per_node * layout.nodes_m.size] = _rigid(layout, per_node)
    return found


def _dofs(nodes: tuple[int, int], per_node: int) -> list[int]:
    return [per_node * node + k for node in nodes for k in range(per_node)]


def _rigid(layout: Layout, per_node: int) -> FloatArray:
    if per_node == 1:
        return np.ones((layout.nodes_m.size, 1))
    modes = np.zeros((2 * layout.nodes_m.size, 2))
    modes[0::2, 0] = modes[1::2, 1] = 1.0
    modes[0::2, 1] = layout.nodes_m
    return modes


class PlateBlock(NamedTuple):
    """One motion of a plate: its number, its matrices, and the motion of its edges from nodes."""

    plate: int
    matrices: PlateMatrices
    edges: FloatArray

    @property
    def held(self) -> int:
        """Number of edges that nodes move."""
        return len(self.edges)

    @property
    def extra(self) -> int:
        """Number of coordinates of its own."""
        return len(self.matrices.mass) - self.held


_MOTIONS: dict[Family, tuple[PlateMotion, ...]] = {
    "lateral": ("tilt", "shift"),
    "axial": ("axial",),
    "torsion": ("torsion",),
}


def plate_blocks(
    layout: Layout, family: Family, disks: DiskRule, roots: RootRule = "elastic"
) -> tuple[PlateBlock, ...]:
    """Return the motions of all plates that belong to a family.

    Parameters
    ----------
    layout
        Nodes and plates.
    family
        Which motions.
    disks
        Whether disks with a free rim bend.
    roots
        Whether columns give way at the roots of plates.
    """
    return tuple(
        block
        for index in range(len(layout.plate_nodes))
        for block in _plate(layout, index, family, disks, roots)
    )


def _plate(
    layout: Layout, index: int, family: Family, disks: DiskRule, roots: RootRule
) -> list[PlateBlock]:
    plate, nodes = layout.skeleton.plates[index], layout.plate_nodes[index]
    free = plate.inner is None or plate.outer is None
    rigid = disks == "rigid" and free
    edges = _edges(layout, index, roots)
    per_node = 2 if family == "lateral" else 1
    center = plate_center_m(plate)
    rings = None if rigid else _rings(layout, index)
    blocks = []
    for motion in _MOTIONS[family]:
        matrices = plate_matrices(plate, motion, edges, rings=rings)
        count = sum(edge is not None for edge in edges)
        if rigid:
            matrices = _stiffened(matrices, count)
        follow = np.zeros((count, per_node * layout.nodes_m.size))
        for row, node in enumerate(n for n in nodes if n >= 0):
            if motion == "tilt":
                follow[row, 2 * node + 1] = 1.0
            elif motion == "shift":
                follow[row, 2 * node] = 1.0
                follow[row, 2 * node + 1] = center - layout.nodes_m[node]
            else:
                follow[row, node] = 1.0
        blocks.append(PlateBlock(index, matrices, follow))
    return blocks


def _edges(layout: Layout, index: int, roots: RootRule) -> tuple[Edge | None, Edge | None]:
    """Return how the edges of a plate are held: by columns, by the node of a rim, or not."""
    plate, nodes = layout.skeleton.plates[index], layout.plate_nodes[index]
    rigid = any(rim.plate == index and rim.rigid for rim in layout.rims)

    def edge(place: Place | None, node: int, cell: Cell) -> Edge | None:
        if place is not None and roots == "rigid":
            return Edge(root=np.inf)
        if place is not None:
            return Edge(root=root_stiffness(layout.skeleton, cell, place))
        return Edge(root=None, rigid=rigid) if node >= 0 else None

    return (
        edge(plate.inner, nodes[0], plate.cells[0]),
        edge(plate.outer, nodes[1], plate.cells[-1]),
    )


def _stiffened(matrices: PlateMatrices, count: int) -> PlateMatrices:
    """Return a plate without its modes and without freedom between its edges."""
    kept = slice(0, count)
    mass, stiffness, gyroscopic, stiffening, softening = (m[kept, kept] for m in matrices[:5])
    return PlateMatrices(
        mass,
        _RIGID * stiffness,
        gyroscopic,
        stiffening,
        softening,
        np.empty(0),
        matrices.fields[:, kept],
    )


def _rings(layout: Layout, index: int) -> tuple[Cell | None, Cell | None]:
    """Return the rings of the columns that stretch with a plate."""
    plate, skeleton = layout.skeleton.plates[index], layout.skeleton
    hub = rim = None
    if plate.inner is not None:
        hub = held_ring(skeleton, plate.cells[0], plate.inner, outer=False)
    if plate.outer is not None:
        rim = held_ring(skeleton, plate.cells[-1], plate.outer, outer=True)
    return hub, rim


def _add_rider(
    found: FamilyMatrices, layout: Layout, piece: Stretch, rider: Rider, family: Family
) -> None:
    element = layout.elements[rider.element]
    xi = (rider.carrier_m - element.ends_m[0]) / piece.length_m
    if family != "lateral":
        at = np.ix_(element.nodes, element.nodes)
        share = np.array([1.0 - xi, xi])
        inertia = rider.mass_kg if family == "axial" else 2.0 * rider.second_kg_m2
        found.mass[at] += inertia * np.outer(share, share)
        return
    dofs = _dofs(element.nodes, 2)
    at = np.ix_(dofs, dofs)
    (deflection,), (slope,) = beam_shapes(piece, np.array([xi]))
    moved = deflection + (rider.z_m - rider.carrier_m) * slope
    spin = rider.second_kg_m2 * np.outer(slope, slope)
    found.mass[at] += rider.mass_kg * np.outer(moved, moved) + spin
    found.gyroscopic[at] += 2.0 * spin


def _add_lump(found: FamilyMatrices, layout: Layout, lump: Lump, family: Family) -> None:
    node = lump_node(layout, lump)
    arm = lump.z_m - layout.nodes_m[node]
    if family != "lateral":
        found.mass[node, node] += lump.mass_kg if family == "axial" else lump.polar_kg_m2
        return
    at = np.ix_([2 * node, 2 * node + 1], [2 * node, 2 * node + 1])
    lever = np.array([1.0, arm])
    found.mass[at] += lump.mass_kg * np.outer(lever, lever)
    found.mass[2 * node + 1, 2 * node + 1] += lump.diametral_kg_m2
    found.gyroscopic[2 * node + 1, 2 * node + 1] += lump.polar_kg_m2


def lump_node(layout: Layout, lump: Lump) -> int:
    """Return the node of its column that a fillet is fixed to."""
    column_nodes = sorted({n for e in layout.elements if e.column == lump.column for n in e.nodes})
    return min(column_nodes, key=lambda n: abs(float(layout.nodes_m[n]) - lump.z_m))
