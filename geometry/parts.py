"""Drum and stages of a body whose features have no common sector.

Sections that carry features are stages, with the sections of other features that they touch; all
others are the drum, which joins them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from solidwhirl.geometry.errors import GeometryError
from solidwhirl.geometry.features import FEWEST, Feature
from solidwhirl.geometry.meridian.subdivision import Subdivision, subdivide
from solidwhirl.geometry.profile import Body, Section


@dataclass(frozen=True, kw_only=True)
class PartLayout:
    """Which sections of a body are the drum, and which are stages."""

    drum: tuple[tuple[Section, ...], ...]  #: By piece, which stages join
    stages: tuple[tuple[Section, ...], ...]
    features: tuple[tuple[Feature, ...], ...]  #: By stage
    counts: tuple[int, ...]  #: Sectors, by stage


def has_stages(body: Body) -> bool:
    """Whether the features of a body have no common sector, so that its stages are joined."""
    return bool(body.features) and math.gcd(*(f.count for f in body.features)) < FEWEST


def layout_of(body: Body) -> PartLayout:
    """Return the drum and the stages of a body.

    Raises GeometryError: features of one stage have no common sector, nothing is left for the drum,
    or the body has fillets.
    """
    if body.fillet_radius_m:
        raise GeometryError(
            f"fillet_radius_m is {body.fillet_radius_m:g}; a body whose stages have different "
            "counts is joined of parts, without fillets: leave it out"
        )
    subdivision = subdivide(replace(body, interfaces=(), rigid_disks=()))
    names = subdivision.section_names
    carried = {name: [f for f in body.features if f.section == name] for name in names}
    group = {name: {name} for name in names}
    for first, second in _neighbours(subdivision):
        a, b = names[first], names[second]
        if bool(carried[a]) == bool(carried[b]) and group[a] is not group[b]:
            both = group[a] | group[b]
            group.update(dict.fromkeys(both, both))
    pieces = list({id(own): own for own in group.values()}.values())
    stages = [own for own in pieces if carried[next(iter(own))]]
    features, counts = [], []
    for own in stages:
        found = tuple(f for f in body.features if f.section in own)
        count = math.gcd(*(f.count for f in found))
        if count < FEWEST:
            listed = ", ".join(f"{f.kind} '{f.name}' {f.count}" for f in found)
            raise GeometryError(
                f"features of sections that touch have counts without a common divisor of {FEWEST} "
                f"or more: {listed}; put a section without features between them"
            )
        features.append(found)
        counts.append(count)
    by_name = {section.name: section for section in body.sections}
    drum = [own for own in pieces if not carried[next(iter(own))]]
    if not drum:
        raise GeometryError("no section is without features; stages need a drum to be joined by")
    return PartLayout(
        drum=tuple(tuple(by_name[n] for n in names if n in own) for own in drum),
        stages=tuple(tuple(by_name[n] for n in names if n in own) for own in stages),
        features=tuple(features),
        counts=tuple(counts),
    )


def _neighbours(subdivision: Subdivision) -> list[tuple[int, int]]:
    """Pairs of sections on both sides of a curve."""
    beside = faces_beside(subdivision)
    pairs = [[subdivision.faces[k].section for k in faces] for faces in beside.values()]
    return [(p[0], p[1]) for p in pairs if len(p) == 2 and p[0] != p[1]]


def faces_beside(subdivision: Subdivision) -> dict[int, list[int]]:
    """Faces beside every curve."""
    beside: dict[int, list[int]] = {}
    for k, face in enumerate(subdivision.faces):
        for curve, _ in face.loop:
            beside.setdefault(curve, []).append(k)
    return beside
