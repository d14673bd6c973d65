"""Mass moments of a body on the beam level: rings of its beams, of what rides on them, of plates.

Beams and fillets have the rings of any beam model; a plate acts as two rings at every radius.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from solidwhirl.beams.assembly import Pieces, PlateBlock
from solidwhirl.beams.attached_inertia import CarriedRing
from solidwhirl.beams.nodes import Layout
from solidwhirl.beams.plates import line_of, plate_center_m, wall_of
from solidwhirl.rotordyn.beams import moments
from solidwhirl.rotordyn.beams.elements import Family, Segment, section_motion
from solidwhirl.rotordyn.beams.families import ReducedFamily, node_rows, per_node
from solidwhirl.rotordyn.beams.moments import Rings
from solidwhirl.rotordyn.core.arrays import FloatArray


def family_rings(
    layout: Layout, pieces: Pieces, reduced: ReducedFamily, blocks: Sequence[PlateBlock]
) -> Rings:
    """Return the rings of a beam model and how one family of motions moves them.

    The same rings in the same order for every family.
    """
    nodes = [element.nodes for element in layout.elements]
    parts = [
        moments.segment_rings(p, n, reduced) for n, p in zip(nodes, pieces.segments, strict=True)
    ]
    for k in sorted({ring.element for ring in pieces.carried_rings}):
        own = [ring for ring in pieces.carried_rings if ring.element == k]
        parts.append(_carried_rings(own, pieces.segments[k], nodes[k], reduced))
    parts += [moments.attached_rings(ring, layout.nodes_m, reduced) for ring in pieces.fillets]
    shapes = reduced.shapes
    start = per_node(reduced.family) * layout.nodes_m.size
    for index in range(len(layout.plate_nodes)):
        motions = []
        for block in (block for block in blocks if block.plate == index):
            edges = block.edges @ shapes[: block.edges.shape[1]]
            stop = start + block.extra
            motions.append(block.matrices.fields @ np.vstack((edges, shapes[start:stop])))
            start = stop
        parts.append(_plate_rings(layout, index, reduced.family, motions))
    return moments.joined_rings(parts)


def _carried_rings(
    own: Sequence[CarriedRing], piece: Segment, nodes: tuple[int, int], reduced: ReducedFamily
) -> Rings:
    """Rings on one element, fixed to its cross-sections by arms."""
    xi = np.concatenate([ring.xi(piece) for ring in own])
    arms = np.array([ring.arm_m for ring in own])
    ends = reduced.shapes[node_rows(nodes, reduced.family)]
    moved, tilted = section_motion(piece, xi, reduced.family, arms)
    mass, second, place = np.array([(r.mass_kg, r.second_kg_m2, r.z_m) for r in own]).T
    rings = (mass, np.sqrt(2.0 * second / mass), place)
    return moments.rigid_rings(rings, reduced.family, moved @ ends, tilted @ ends)


def _plate_rings(layout: Layout, index: int, family: Family, motions: list[FloatArray]) -> Rings:
    """Two rings at each radius; `motions` are values of the plate's fields at its own nodes."""
    plate = layout.skeleton.plates[index]
    line, center = line_of(plate.cells), plate_center_m(plate)
    walls = [wall_of(plate.cells[k], center) for k in line.cell]
    apart = np.sqrt([wall.rotary / wall.mass for wall in walls])[:, None]
    area = 2.0 * np.pi * line.radius * line.weight * np.array([wall.mass for wall in walls])
    values = [
        line.value @ field
        for motion in motions
        for field in motion.reshape(-1, line.value.shape[1], motion.shape[1])
    ]
    zero = np.zeros_like(values[0])
    if family == "lateral":
        deflection, radial, around, shift, across = values
    elif family == "axial":
        # the translation along the axis is ζ here, and −ζ in a tilt
        deflection, radial = -values[0], -values[1]
        around = shift = across = zero
    else:
        deflection = radial = around = shift = zero
        across = -values[0]
    sides = [(shift + x * radial, -(across + x * around), -deflection) for x in (-apart, apart)]
    return Rings(
        np.tile(0.5 * area, 2),
        np.tile(line.radius, 2),
        np.concatenate([center + x[:, 0] for x in (-apart, apart)]),
        np.concatenate([np.array(side) for side in sides], axis=1),
    )
