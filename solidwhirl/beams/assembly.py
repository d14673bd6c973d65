"""Matrices of a beam model: bending in one plane, axial motion, torsion, before any reduction."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from solidwhirl.beams import plates
from solidwhirl.beams.attached_inertia import CarriedRing, carried_rings, fillet_rings
from solidwhirl.beams.nodes import Layout
from solidwhirl.beams.plates import Edge, PlateMatrices, PlateMotion
from solidwhirl.beams.profile import Cell, Place
from solidwhirl.beams.sections import ShearRule, column_segment, stiff_radii
from solidwhirl.geometry import Body
from solidwhirl.rotordyn.beams import families
from solidwhirl.rotordyn.beams.elements import Family, Segment, section_motion
from solidwhirl.rotordyn.beams.families import Attached, FamilyMatrices, per_node
from solidwhirl.rotordyn.core.arrays import FloatArray

RootRule = Literal["elastic", "rigid"]


class Pieces(NamedTuple):
    """Cross-sections along all elements, the rings that ride on them, and fillets at nodes."""

    segments: tuple[Segment, ...]
    carried_rings: tuple[CarriedRing, ...]
    fillets: tuple[Attached, ...]


def pieces_of(body: Body, layout: Layout, slope: float, shear: ShearRule) -> Pieces:
    """Return stiffness and inertia along all elements, and what is attached to them."""
    radii = stiff_radii(layout.skeleton, slope)
    columns = layout.skeleton.columns
    along = tuple(
        column_segment(columns[e.column], radii[e.column], e.ends_m, shear) for e in layout.elements
    )
    return Pieces(along, carried_rings(layout, radii, along), fillet_rings(body, layout))


def assembled_family(
    layout: Layout, pieces: Pieces, family: Family, blocks: tuple[PlateBlock, ...]
) -> FamilyMatrices:
    """Assemble one family of motions: nodes, then what the plates of the family add."""
    nodes = [element.nodes for element in layout.elements]
    found = families.family_matrices(
        layout.nodes_m,
        zip(nodes, pieces.segments, strict=True),
        family,
        extra=sum(block.extra for block in blocks),
    )
    for carried in pieces.carried_rings:
        piece = pieces.segments[carried.element]
        rows = families.node_rows(nodes[carried.element], family)
        at = np.ix_(rows, rows)
        (moved,), (tilted,) = section_motion(piece, carried.xi(piece), family, carried.arm_m)
        inertia = 2.0 * carried.second_kg_m2 if family == "torsion" else carried.mass_kg
        spin = carried.second_kg_m2 * np.outer(tilted, tilted)
        found.mass[at] += inertia * np.outer(moved, moved) + spin
        found.gyroscopic[at] += 2.0 * spin
    next_free = per_node(family) * layout.nodes_m.size
    for block in blocks:
        columns = np.zeros((len(block.matrices.mass), len(found.mass)))
        columns[: block.held, : block.edges.shape[1]] = block.edges
        columns[block.held :, next_free : next_free + block.extra] = np.eye(block.extra)
        next_free += block.extra
        for total, local in zip(found, block.matrices[:5], strict=False):
            total += columns.T @ local @ columns
    for ring in pieces.fillets:
        families.add_attached(found, layout.nodes_m, ring, family)
    return found


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
    layout: Layout, family: Family, roots: RootRule = "elastic"
) -> tuple[PlateBlock, ...]:
    """Return the motions of all plates that belong to a family; `roots`: of columns under them."""
    return tuple(
        block
        for index in range(len(layout.plate_nodes))
        for block in _plate(layout, index, family, roots)
    )


def _plate(layout: Layout, index: int, family: Family, roots: RootRule) -> list[PlateBlock]:
    plate, nodes = layout.skeleton.plates[index], layout.plate_nodes[index]
    edges = _edges(layout, index, roots)
    center, rings = plates.plate_center_m(plate), _rings(layout, index)
    blocks = []
    for motion in _MOTIONS[family]:
        matrices = plates.plate_matrices(plate, motion, edges, rings=rings)
        count = sum(edge is not None for edge in edges)
        follow = np.zeros((count, per_node(family) * layout.nodes_m.size))
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
            held = layout.skeleton, cell, place
            return Edge(root=plates.root_stiffness(*held), hoop=plates.hoop_stiffness(*held))
        return Edge(root=None, rigid=rigid) if node >= 0 else None

    return (
        edge(plate.inner, nodes[0], plate.cells[0]),
        edge(plate.outer, nodes[1], plate.cells[-1]),
    )


def _rings(layout: Layout, index: int) -> tuple[Cell | None, Cell | None]:
    """Return the rings of the columns that stretch with a plate."""
    plate, skeleton = layout.skeleton.plates[index], layout.skeleton
    hub = rim = None
    if plate.inner is not None:
        hub = plates.held_ring(skeleton, plate.cells[0], plate.inner, outer=False)
    if plate.outer is not None:
        rim = plates.held_ring(skeleton, plate.cells[-1], plate.outer, outer=True)
    return hub, rim
