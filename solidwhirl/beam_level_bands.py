"""Which parts of a meridian are flat plates: rings of sections, stacked along the radius."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

from solidwhirl.geometry import Section


class Band(NamedTuple):
    """An elementary radial interval of flat sections that follow each other along the axis."""

    interval: int
    sections: tuple[int, ...]
    held: bool


def grouped(count: int, pairs: Iterable[tuple[int, int]]) -> list[int]:
    """Return a label per item: the smallest index among those that pairs join it with."""
    label = list(range(count))

    def root(k: int) -> int:
        while label[k] != k:
            label[k] = label[label[k]]
            k = label[k]
        return k

    for first, second in pairs:
        a, b = sorted((root(first), root(second)))
        label[b] = a
    return [root(k) for k in range(count)]


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


def bands_of(sections: Sequence[Section], radii: list[float], tolerance: float) -> list[Band]:
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
) -> Band:
    start, end = sections[chain[0]].start_m, sections[chain[-1]].end_m
    held = False
    for k, section in enumerate(sections):
        if k in flat:
            continue
        for plane, own in ((start, section.end_m), (end, section.start_m)):
            if plane == own:
                inner, outer = section.radii_at(own)
                held |= inner < middle < outer
    return Band(interval, tuple(chain), held)


def plate_chains(
    bands: list[Band], sections: Sequence[Section], radii: list[float], tolerance: float
) -> list[list[Band]]:
    """Return the stacks of free bands that are plates, each from the axis outwards."""

    def span(band: Band) -> tuple[float, float]:
        return sections[band.sections[0]].start_m, sections[band.sections[-1]].end_m

    def above(a: Band, b: Band) -> bool:
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
    for label in sorted(set(labels)):
        chain = [band for band, own in zip(free, labels, strict=True) if own == label]
        chain.sort(key=lambda band: band.interval)
        height = radii[chain[-1].interval + 1] - radii[chain[0].interval]
        if height > max(end - start for start, end in map(span, chain)):
            chains.append(chain)
        else:
            # a wide rim may spoil what is a plate without it
            own = [b for b in chain if all(_is_flat(sections[k]) for k in b.sections)]
            again += own if len(own) < len(chain) else []
    return chains + (plate_chains(again, sections, radii, tolerance) if again else [])


def pieces_without(
    sections: Sequence[Section],
    bands: list[Band],
    chains: list[list[Band]],
    radii: list[float],
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
