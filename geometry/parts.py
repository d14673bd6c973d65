"""What symmetry the features of a body leave it, and its drum and stages where that differs.

Sections that carry features are stages, with the sections of other features that they touch; all
others are the drum, which joins them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from solidwhirl.geometry.errors import GeometryError
from solidwhirl.geometry.features import FEWEST, Feature, sector_count
from solidwhirl.geometry.meridian.subdivision import Subdivision, subdivide
from solidwhirl.geometry.profile import Body, Section

#: How a body bends, see `symmetry`.
Symmetry = Literal["round", "cyclic", "staged", "asymmetric"]


@dataclass(frozen=True, kw_only=True)
class PartLayout:
    """Which sections of a body are the drum, and which are stages."""

    drum: tuple[tuple[Section, ...], ...]  #: By piece, which stages join
    stages: tuple[tuple[Section, ...], ...]
    features: tuple[tuple[Feature, ...], ...]  #: By stage
    counts: tuple[int, ...]  #: Sectors, by stage


def symmetry(body: Body) -> Symmetry:
    """Return how a body bends: all that asks whether it has features, sectors or stages asks here.

    "round": of revolution. "cyclic": its features have N >= 3 equal sectors. "staged": those of
    every stage have, each a number of its own, so that stages are joined by a drum. "asymmetric":
    none of these, as with one keyway or two flats; it bends unlike in two planes. Raises
    GeometryError: an invalid body.
    """
    if not body.features:
        return "round"
    if sector_count(body.features) >= FEWEST:
        return "cyclic"
    if min(feature.count for feature in body.features) < FEWEST:
        return "asymmetric"
    stages = _stages(body, _groups(body))
    staged = all(sector_count(features) >= FEWEST for _, features in stages)
    return "staged" if staged else "asymmetric"


def layout_of(body: Body) -> PartLayout:
    """Return the drum and the stages of a body whose symmetry is "staged".

    Raises GeometryError: the body has fillets.
    """
    if body.fillet_radius_m:
        raise GeometryError(
            f"fillet_radius_m is {body.fillet_radius_m:g}; a body whose stages have different "
            "counts is joined of parts, without fillets: leave it out"
        )
    groups = _groups(body)
    stages = _stages(body, groups)
    carrying = {feature.section for feature in body.features}
    return PartLayout(
        drum=tuple(own for own in groups if own[0].name not in carrying),
        stages=tuple(own for own, _ in stages),
        features=tuple(features for _, features in stages),
        counts=tuple(sector_count(features) for _, features in stages),
    )


def _groups(body: Body) -> list[tuple[Section, ...]]:
    """Sections that touch and all carry features, or all carry none."""
    subdivision = subdivide(replace(body, interfaces=(), rigid_disks=()))
    names = subdivision.section_names
    carrying = {feature.section for feature in body.features}
    group = {name: {name} for name in names}
    for first, second in _neighbours(subdivision):
        a, b = names[first], names[second]
        if (a in carrying) == (b in carrying) and group[a] is not group[b]:
            both = group[a] | group[b]
            group.update(dict.fromkeys(both, both))
    by_name = {section.name: section for section in body.sections}
    pieces = {id(own): own for own in group.values()}.values()
    return [tuple(by_name[n] for n in names if n in own) for own in pieces]


def _stages(
    body: Body, groups: list[tuple[Section, ...]]
) -> list[tuple[tuple[Section, ...], tuple[Feature, ...]]]:
    """Groups of sections that carry features, with these."""
    found = []
    for own in groups:
        names = {section.name for section in own}
        features = tuple(f for f in body.features if f.section in names)
        if features:
            found.append((own, features))
    return found


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
