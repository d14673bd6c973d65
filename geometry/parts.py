"""What symmetry the features of a body leave it, and its drum and stages where that differs.

Sections that carry features are stages, with the sections of other features that they touch; all
others are the drum, which joins them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from solidwhirl.geometry.errors import GeometryError
from solidwhirl.geometry.features import FEWEST, Feature, sector_count
from solidwhirl.geometry.meridian.subdivision import Subdivision, subdivide
from solidwhirl.geometry.profile import Body, Interface, Section
from solidwhirl.rotordyn.core.arrays import FloatArray

#: Beginning of the names of the joints between drum and stages.
JOINT = "joint of parts "
# Radial range of an interface on a cylinder, over its radius.
_THIN = 1e-6
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
    none of these, as with one keyway or two flats. Raises
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


def part_bodies(body: Body, layout: PartLayout) -> list[Body]:
    """Return pieces of the drum, then stages, as bodies with their joints and own interfaces.

    Interfaces whose names begin with `JOINT` are joints, of one name on both sides. Raises
    GeometryError: an interface of the body on both drum and stage.
    """
    whole = subdivide(body)
    parts_of = [*layout.drum, *layout.stages]
    part_of = {s.name: k for k, sections in enumerate(parts_of) for s in sections}
    beside = faces_beside(whole)
    parts = {
        curve: sorted({part_of[whole.section_names[whole.faces[k].section]] for k in faces})
        for curve, faces in beside.items()
    }
    interfaces: list[list[Interface]] = [[] for _ in parts_of]
    for interface in body.interfaces:
        own = sorted({p for c in whole.interfaces[interface.name] for p in parts[c]})
        if len(own) > 1:
            raise GeometryError(
                f"interface {interface.name!r} touches a section that carries features and one "
                "that does not; stages of different counts are joined there, so it has to keep to "
                "one of them"
            )
        interfaces[own[0]].append(interface)
    for number, curve in enumerate(c for c, own in parts.items() if len(own) > 1):
        ends = whole.points[[whole.curves[curve].start, whole.curves[curve].end]]
        for k in parts[curve]:
            mine = [f for f in beside[curve] if part_of[_section(whole, f)] == k]
            interfaces[k].append(_joint(number, ends, _lies_inside(whole, mine[0], ends)))
    features: Sequence[tuple[Feature, ...]] = [*[()] * len(layout.drum), *layout.features]
    return [
        Body(name=body.name, sections=parts_of[k], interfaces=tuple(own), features=features[k])
        for k, own in enumerate(interfaces)
    ]


def _section(subdivision: Subdivision, face: int) -> str:
    return subdivision.section_names[subdivision.faces[face].section]


def _lies_inside(subdivision: Subdivision, face: int, ends: FloatArray) -> bool:
    """Whether a face lies nearer to the axis than an edge of it."""
    curves = [subdivision.curves[c] for c, _ in subdivision.faces[face].loop]
    centre = subdivision.points[[c.start for c in curves]].mean(axis=0)
    (z0, r0), (z1, r1) = ends
    if z0 == z1:
        return False
    return bool(centre[1] < r0 + (r1 - r0) * (centre[0] - z0) / (z1 - z0))


def _joint(number: int, ends: FloatArray, is_outer: bool) -> Interface:
    """Interface on an edge between parts; rigid ones have their ends graded, as joints need it."""
    z, r = np.sort(ends, axis=0).T
    plane = z[0] == z[1]
    span = (float(r[0]), float(r[1])) if r[0] < r[1] else (r[0] * (1 - _THIN), r[1] * (1 + _THIN))
    return Interface(
        name=f"{JOINT}{number}",
        kind="face" if plane else ("outer" if is_outer else "inner"),
        coupling="rigid",
        start_m=float(z[0]),
        end_m=float(z[1]),
        radius_m=span,
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
