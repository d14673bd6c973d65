"""The meridian of a body taken apart for a beam model: columns that bend, plates that tilt.

Material that is long along the axis carries bending and becomes columns, stacks of rings between
two planes. Material that is taller than wide between two flat faces becomes annular plates: disks
with a free rim, and webs between a shaft and a drum.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy

from solidwhirl.geometry import Body, GeometryError, Material, Section
from solidwhirl.geometry.meridian.snapping import scale_of, snap_body
from solidwhirl.rotordyn.core.arrays import IntArray

# Slope dr/dz of a wall beyond which it bends as a plate, not as a cone.
_STEEPEST = 6.0


class BeamLevelError(GeometryError):
    """A body that a beam model made from the profile can not represent."""


class Place(NamedTuple):
    """Where a plate or an interface sits: index of a column and z [m]."""

    column: int
    z_m: float


@dataclass(frozen=True, kw_only=True)
class Column:
    """Rings bonded in radial direction between two planes."""

    #: Planes, m
    start_m: float
    end_m: float
    layers: tuple[Section, ...]  #: Rings from the axis outwards; each may reach beyond the planes
    #: Plates on the outer and under the inner surface: they carry no axial stress far from the
    #: column, and stiffen it as far as the stiffness rule says
    outer_plates: tuple[Section, ...] = ()
    inner_plates: tuple[Section, ...] = ()

    @property
    def is_straight(self) -> bool:
        """Whether all radii are constant, and no plate ends within the column."""
        rings = (*self.layers, *self.outer_plates, *self.inner_plates)
        return all(
            r.inner_radius_m[0] == r.inner_radius_m[1]
            and r.outer_radius_m[0] == r.outer_radius_m[1]
            and r.start_m <= self.start_m
            and r.end_m >= self.end_m
            for r in rings
        )

    def inner_m(self, z_m: float) -> float:
        """Return the inner radius at a place, m."""
        return self.layers[0].radii_at(z_m)[0]

    def outer_m(self, z_m: float) -> float:
        """Return the outer radius at a place, m."""
        return self.layers[-1].radii_at(z_m)[1]


@dataclass(frozen=True, kw_only=True)
class Slice:
    """One material of a plate cell between two planes."""

    start_m: float
    end_m: float
    material: Material


@dataclass(frozen=True, kw_only=True)
class Cell:
    """A ring of a plate with flat faces; slices follow each other along the axis."""

    inner_m: float
    outer_m: float
    slices: tuple[Slice, ...]

    @property
    def start_m(self) -> float:
        """First face, m."""
        return self.slices[0].start_m

    @property
    def end_m(self) -> float:
        """Last face, m."""
        return self.slices[-1].end_m


@dataclass(frozen=True, kw_only=True)
class Plate:
    """An annular plate of stepped thickness."""

    cells: tuple[Cell, ...]
    #: Columns that hold the edges; None is a free edge. One of them is not None.
    inner: Place | None
    outer: Place | None


@dataclass(frozen=True, kw_only=True)
class Skeleton:
    """Columns, their contacts and the plates on them."""

    columns: tuple[Column, ...]  #: Ordered by start, then radius
    #: Pairs of columns (left, right) that share a piece of the plane between them
    contacts: tuple[tuple[int, int], ...]
    plates: tuple[Plate, ...]
    tolerance_m: float  #: Length below which places are the same, m


def skeleton_of(body: Body) -> Skeleton:
    """Take the meridian of a body apart into columns and plates.

    `body`: body of revolution; fillets, interfaces and rigid disks are not looked at. Raises
    BeamLevelError if a part hangs on the rest by neither an end face nor the rim of a plate, or a
    wall is steeper than 6 to 1.

    A flat section (radial faces, constant radii, taller than wide) is a plate where nothing but
    other flat sections touches its faces, and as long as the stack of such rings is taller than
    its widest one. The rest are columns: cut at all section ends, merged where they touch.
    """
    tolerance = scale_of(body).tolerance_m
    sections = snap_body(body, tolerance).sections
    _refuse_steep(body)
    radii = sorted({r for s in sections for r in (*s.inner_radius_m, *s.outer_radius_m)})
    bands = _bands_of(sections, radii, tolerance)
    chains = _plate_chains(bands, sections, radii, tolerance)
    while True:
        pieces = _pieces_without(sections, bands, chains, radii)
        columns = _columns(pieces, sections, tolerance)
        plates = [_plate(chain, sections, radii, columns, tolerance) for chain in chains]
        loose = [k for k, p in enumerate(plates) if p.inner is None and p.outer is None]
        if not loose:
            break
        # a disk that no shaft carries is a body of its own: it bends as a short thick column
        chains = [chain for k, chain in enumerate(chains) if k not in loose]
    contacts = _contacts(columns, tolerance)
    columns = [_with_plates(column, plates, tolerance) for column in columns]
    _refuse_pieces(body, columns, contacts, plates)
    return Skeleton(
        columns=tuple(columns),
        contacts=tuple(contacts),
        plates=tuple(plates),
        tolerance_m=tolerance,
    )


class _Band(NamedTuple):
    """An elementary radial interval of flat sections that follow each other along the axis."""

    interval: int
    sections: tuple[int, ...]
    held: bool


def grouped(count: int, pairs: Iterable[tuple[int, int]]) -> IntArray:
    """Return a label per item, shape (count,): equal for items that pairs join."""
    first, second = np.array(list(pairs), dtype=int).reshape(-1, 2).T
    graph = scipy.sparse.coo_array((np.ones(first.size), (first, second)), shape=(count, count))
    return np.asarray(scipy.sparse.csgraph.connected_components(graph, directed=False)[1])


def _is_flat(section: Section) -> bool:
    inner, outer = section.inner_radius_m, section.outer_radius_m
    straight = inner[0] == inner[1] and outer[0] == outer[1]
    return straight and outer[0] - inner[0] > section.end_m - section.start_m


def _is_rim(index: int, sections: Sequence[Section], tolerance: float) -> bool:
    """Return whether a short straight ring has free faces and one free surface, as a rim has."""
    own = sections[index]
    (low, low_end), (high, high_end) = own.inner_radius_m, own.outer_radius_m
    if low != low_end or high != high_end or own.end_m - own.start_m > high:
        return False
    sides = set()
    for k, other in enumerate(sections):
        if k == index:
            continue
        for plane, end in ((own.start_m, other.end_m), (own.end_m, other.start_m)):
            if plane == end:
                inner, outer = other.radii_at(plane)
                if min(high, outer) - max(low, inner) > tolerance:
                    return False
        start, stop = max(own.start_m, other.start_m), min(own.end_m, other.end_m)
        if stop - start > tolerance:
            inner, outer = other.radii_at(0.5 * (start + stop))
            sides |= {"inner"} if abs(outer - low) <= tolerance else set()
            sides |= {"outer"} if abs(inner - high) <= tolerance else set()
    return len(sides) == 1


def _bands_of(sections: Sequence[Section], radii: list[float], tolerance: float) -> list[_Band]:
    """Return the flat sections by elementary radial interval, chained where faces touch."""
    flat = [k for k, s in enumerate(sections) if _is_flat(s) or _is_rim(k, sections, tolerance)]
    found = []
    for j, (low, high) in enumerate(pairwise(radii)):
        middle = 0.5 * (low + high)
        inside = [
            k
            for k in flat
            if sections[k].inner_radius_m[0] < middle < sections[k].outer_radius_m[0]
        ]
        inside.sort(key=lambda k: sections[k].start_m)
        chain: list[int] = []
        for k in inside:
            if chain and sections[k].start_m - sections[chain[-1]].end_m > tolerance:
                found.append(_band(j, chain, sections, flat, middle))
                chain = []
            chain.append(k)
        if chain:
            found.append(_band(j, chain, sections, flat, middle))
    return found


def _band(
    interval: int, chain: list[int], sections: Sequence[Section], flat: list[int], middle: float
) -> _Band:
    start, end = sections[chain[0]].start_m, sections[chain[-1]].end_m
    held = False
    for k, section in enumerate(sections):
        if k in flat:
            continue
        for plane, own in ((start, section.end_m), (end, section.start_m)):
            if plane == own:
                inner, outer = section.radii_at(own)
                held |= inner < middle < outer
    return _Band(interval, tuple(chain), held)


def _plate_chains(
    bands: list[_Band], sections: Sequence[Section], radii: list[float], tolerance: float
) -> list[list[_Band]]:
    """Return the stacks of free bands that are plates, each from the axis outwards."""

    def span(band: _Band) -> tuple[float, float]:
        return sections[band.sections[0]].start_m, sections[band.sections[-1]].end_m

    def above(a: _Band, b: _Band) -> bool:
        (start_a, end_a), (start_b, end_b) = span(a), span(b)
        overlap = min(end_a, end_b) - max(start_a, start_b)
        return b.interval == a.interval + 1 and overlap > tolerance

    free = [band for band in bands if not band.held]
    while True:
        pairs = [(i, j) for i, a in enumerate(free) for j, b in enumerate(free) if above(a, b)]
        lower, upper = [i for i, _ in pairs], [j for _, j in pairs]
        forks = {i for i in lower if lower.count(i) > 1} | {j for j in upper if upper.count(j) > 1}
        if not forks:
            break
        free = [band for k, band in enumerate(free) if k not in forks]
    labels = grouped(len(free), pairs)
    chains, again = [], []
    for label in np.unique(labels):
        chain = [band for band, own in zip(free, labels, strict=True) if own == label]
        chain.sort(key=lambda band: band.interval)
        height = radii[chain[-1].interval + 1] - radii[chain[0].interval]
        if height > max(end - start for start, end in map(span, chain)):
            chains.append(chain)
        else:
            # a wide rim may spoil what is a plate without it
            own = [b for b in chain if all(_is_flat(sections[k]) for k in b.sections)]
            again += own if len(own) < len(chain) else []
    return chains + (_plate_chains(again, sections, radii, tolerance) if again else [])


def _pieces_without(
    sections: Sequence[Section], bands: list[_Band], chains: list[list[_Band]], radii: list[float]
) -> list[Section]:
    """Return what is left of the sections without the plates, each piece a section."""
    plates = {(band.interval, k) for chain in chains for band in chain for k in band.sections}
    pieces = []
    for k, section in enumerate(sections):
        own = sorted(b.interval for b in bands if k in b.sections)
        if not any((j, k) in plates for j in own):
            pieces.append(section)
            continue
        kept = [j for j in own if (j, k) not in plates]
        starts = [j for j in kept if j - 1 not in kept]
        stops = [j + 1 for j in kept if j + 1 not in kept]
        pieces += [
            replace(
                section,
                inner_radius_m=(radii[low], radii[low]),
                outer_radius_m=(radii[high], radii[high]),
            )
            for low, high in zip(starts, stops, strict=True)
        ]
    return pieces


def _columns(
    pieces: Sequence[Section], sections: Sequence[Section], tolerance: float
) -> list[Column]:
    planes = sorted({z for s in sections for z in (s.start_m, s.end_m)})
    columns = []
    for start, end in pairwise(planes):
        inside = [p for p in pieces if p.start_m <= start and p.end_m >= end]
        inside.sort(key=lambda p: p.radii_at(0.5 * (start + end))[0])
        stack: list[Section] = []
        for piece in inside:
            if stack and not _bonded(stack[-1], piece, (start, end), tolerance):
                columns.append(Column(start_m=start, end_m=end, layers=tuple(stack)))
                stack = []
            stack.append(piece)
        if stack:
            columns.append(Column(start_m=start, end_m=end, layers=tuple(stack)))
    return columns


def _bonded(below: Section, above: Section, planes: tuple[float, float], tolerance: float) -> bool:
    return all(abs(below.radii_at(z)[1] - above.radii_at(z)[0]) <= tolerance for z in planes)


def _contacts(columns: Sequence[Column], tolerance: float) -> list[tuple[int, int]]:
    return [
        (i, j)
        for i, left in enumerate(columns)
        for j, right in enumerate(columns)
        if left.end_m == right.start_m
        and min(left.outer_m(left.end_m), right.outer_m(left.end_m))
        - max(left.inner_m(left.end_m), right.inner_m(left.end_m))
        > tolerance
    ]


def _plate(
    chain: list[_Band],
    sections: Sequence[Section],
    radii: list[float],
    columns: Sequence[Column],
    tolerance: float,
) -> Plate:
    cells: list[Cell] = []
    members: tuple[int, ...] = ()
    for band in chain:
        outer = radii[band.interval + 1]
        if cells and members == band.sections:
            cells[-1] = replace(cells[-1], outer_m=outer)
            continue
        members = band.sections
        slices = tuple(
            Slice(
                start_m=sections[k].start_m, end_m=sections[k].end_m, material=sections[k].material
            )
            for k in members
        )
        cells.append(Cell(inner_m=radii[band.interval], outer_m=outer, slices=slices))
    return Plate(
        cells=tuple(cells),
        inner=_edge_place(columns, cells[0], cells[0].inner_m, Column.outer_m, tolerance),
        outer=_edge_place(columns, cells[-1], cells[-1].outer_m, Column.inner_m, tolerance),
    )


def _edge_place(
    columns: Sequence[Column],
    cell: Cell,
    radius: float,
    surface: Callable[[Column, float], float],
    tolerance: float,
) -> Place | None:
    """Return the column whose surface an edge of a plate is bonded to, and the middle of that."""
    touching = []
    for k, column in enumerate(columns):
        start, end = max(column.start_m, cell.start_m), min(column.end_m, cell.end_m)
        if end - start <= tolerance:
            continue
        if all(abs(surface(column, z) - radius) <= tolerance for z in (start, end)):
            touching.append((start, end, k))
    if not touching:
        return None
    middle = 0.5 * (touching[0][0] + touching[-1][1])
    for start, end, k in touching:
        if start <= middle <= end:
            return Place(k, middle)
    start, end, k = touching[0]
    return Place(k, 0.5 * (start + end))


def _with_plates(column: Column, plates: Sequence[Plate], tolerance: float) -> Column:
    """Return the column with the plates on its surfaces, for the stiffness they lend."""
    outer_plates: tuple[Section, ...] = ()
    inner_plates: tuple[Section, ...] = ()
    middle = 0.5 * (column.start_m + column.end_m)
    for plate in plates:
        share = 0.5 if plate.inner and plate.outer else 1.0
        low, high = plate.cells[0], plate.cells[-1]
        top = low.inner_m + share * (low.outer_m - low.inner_m)
        bottom = high.outer_m - share * (high.outer_m - high.inner_m)
        above = plate.inner is not None and low.start_m < middle < low.end_m
        below = plate.outer is not None and high.start_m < middle < high.end_m
        if above and abs(column.outer_m(middle) - low.inner_m) <= tolerance:
            outer_plates = _as_sections(low, low.inner_m, top)
        if below and abs(column.inner_m(middle) - high.outer_m) <= tolerance:
            inner_plates = _as_sections(high, bottom, high.outer_m)
    return replace(column, outer_plates=outer_plates, inner_plates=inner_plates)


def _as_sections(cell: Cell, inner: float, outer: float) -> tuple[Section, ...]:
    return tuple(
        Section(
            name="plate",
            start_m=s.start_m,
            end_m=s.end_m,
            inner_radius_m=(inner, inner),
            outer_radius_m=(outer, outer),
            material=s.material,
        )
        for s in cell.slices
    )


def _refuse_steep(body: Body) -> None:
    for s in body.sections:
        (inner, inner_end), (outer, outer_end) = s.inner_radius_m, s.outer_radius_m
        length = s.end_m - s.start_m
        rises = (inner_end - inner) / length, (outer_end - outer) / length
        if rises[0] * rises[1] > 0.0 and min(map(abs, rises)) > _STEEPEST:
            raise BeamLevelError(
                f"body '{body.name}': section '{s.name}' is a cone of slope "
                f"{min(map(abs, rises)):.3g} (radius over length); the beam level takes cones up "
                f"to {_STEEPEST:g} and flat webs; choose level harmonic"
            )


def _refuse_pieces(
    body: Body,
    columns: Sequence[Column],
    contacts: Sequence[tuple[int, int]],
    plates: Sequence[Plate],
) -> None:
    webs = [(p.inner.column, p.outer.column) for p in plates if p.inner and p.outer]
    labels = grouped(len(columns), [*contacts, *webs])
    for label, column in zip(labels, columns, strict=True):
        if label != 0:
            names = ", ".join(f"'{layer.name}'" for layer in column.layers)
            raise BeamLevelError(
                f"body '{body.name}': the beam level finds no path for bending from section "
                f"{names} at z = {column.start_m:.6g} to {column.end_m:.6g} m to the rest; parts "
                "must meet end to end or be joined by flat webs with radial faces; choose level "
                "harmonic"
            )
