"""Compressor and turbine stage groups of the parametrised engine, as sections of a body."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

import numpy as np

from solidwhirl.geometry.errors import GeometryError
from solidwhirl.geometry.features import Blade
from solidwhirl.geometry.materials import Material
from solidwhirl.geometry.profile import Section
from solidwhirl.rotordyn.core.arrays import FloatArray

__all__ = [
    "TABLE_7",
    "Cone",
    "StageBlades",
    "StageGroup",
    "Web",
    "stage_group_blades",
    "stage_group_sections",
    "stage_values",
]

# Of the stagger with which the width of a ring still tells a chord (84 deg).
_LEAST_COSINE = 0.1


@dataclass(frozen=True, kw_only=True, slots=True)
class Web:
    """Describe a radial disk of constant thickness from the shaft to a stage's ring."""

    stage: int  #: Stage that the web carries, counted from 1
    thickness_m: float  #: Axial thickness [m], at most the ring's width
    #: Radius [m] where the web starts: the shaft's outer radius, below the ring's inner radius
    inner_radius_m: float
    #: Middle of the ring, or flush with its face towards stage 1 ("front") or away from it
    position: Literal["centre", "front", "back"] = "centre"


@dataclass(frozen=True, kw_only=True, slots=True)
class Cone:
    """Describe a conical shell from a foot ring on the shaft to the radial face of a stage's ring.

    The shell's inner line runs from the shaft's surface, at the foot's face that looks to the ring,
    to the ring's inner radius, at the ring's face that looks to the foot. The foot is as high as
    the shell is in radial direction, so both ends are bonded over the whole wall. Only a face
    without a spacer can be met: the front of the first stage and the back of the last one.
    """

    stage: int  #: Stage that the cone carries, counted from 1
    #: Outer radius [m] of the shaft under the foot, below the ring's inner radius
    shaft_radius_m: float
    #: Axial range [m] of the foot on the shaft, all of it on one side of the ring
    foot_start_m: float
    foot_end_m: float
    thickness_m: float  #: Wall thickness [m] normal to the cone


@dataclass(frozen=True, kw_only=True, slots=True)
class StageBlades:
    """Describe the blades of a stage group by those of stage 1 and ratios from stage to stage.

    The source of `TABLE_7` says nothing of blades: all of this is the user's, and that lengths
    follow the rule of the other dimensions is an assumption.
    """

    count: tuple[int, ...]  #: One for all stages, or one for each
    length_m: float  #: From the ring's outer radius to the tip, of stage 1
    length_factor: float = 1.0  #: Ratio of consecutive stages [-]
    #: Root and tip, of stage 1
    thickness_m: tuple[float, float]
    thickness_factor: float = 1.0
    #: Root and tip, of stage 1; None: as wide as the ring where the stagger is that of the root
    chord_m: tuple[float, float] | None = None
    chord_factor: float | None = None  #: None: that of the rings' widths
    stagger_deg: tuple[float, float] = (0.0, 0.0)  #: Root and tip, of all stages


@dataclass(frozen=True, kw_only=True, slots=True)
class _Layout:
    """Hold the axial places [m] of a group's rings, in stage order, and what names them."""

    group: StageGroup
    starts_m: tuple[float, ...]
    ends_m: tuple[float, ...]
    direction: Literal[1, -1]
    material: Material
    prefix: str

    def ring(self, stage: int) -> Section:
        """Return the ring of a stage, counted from 1."""
        inner = float(self.group.inner_radii_m[stage - 1])
        outer = float(self.group.outer_radii_m[stage - 1])
        return self.section(
            f"stage_{stage}", self.starts_m[stage - 1], self.ends_m[stage - 1], inner, outer
        )

    def section(
        self, name: str, start_m: float, end_m: float, inner_m: float, outer_m: float
    ) -> Section:
        """Return a section of constant radii."""
        return self.tapered(name, (start_m, end_m), (inner_m, inner_m), (outer_m, outer_m))

    def tapered(
        self,
        name: str,
        ends_m: tuple[float, float],
        inner_m: tuple[float, float],
        outer_m: tuple[float, float],
    ) -> Section:
        """Return a section between two axial places, given in any order."""
        order = 1 if ends_m[0] < ends_m[1] else -1
        return Section(
            name=f"{self.prefix}_{name}",
            start_m=min(ends_m),
            end_m=max(ends_m),
            inner_radius_m=(inner_m[::order][0], inner_m[::order][1]),
            outer_radius_m=(outer_m[::order][0], outer_m[::order][1]),
            material=self.material,
        )


def stage_group_sections(
    group: StageGroup,
    *,
    start_m: float,
    direction: Literal[1, -1],
    material: Material,
    spacer_thickness_m: float,
    web: Web | Cone | Sequence[Web | Cone] | None,
    prefix: str,
) -> tuple[Section, ...]:
    """Return a stage group as rings, spacers between them, and webs or cones to the shaft.

    Parameters
    ----------
    group
        Dimensions, for example from `TABLE_7` (see there for the assumed meaning of its rows).
    start_m
        Axial position [m] of the front face of stage 1.
    direction
        1: the stages follow towards larger z; -1: towards smaller z.
    spacer_thickness_m
        Radial thickness [m] of the spacers. A spacer's inner line runs from the inner radius of one
        ring to that of the next; at a ring thinner than this it takes the ring's thickness.
    web
        Connections to the shaft. The shaft itself is not part of the result.
    prefix
        Names are `<prefix>_stage_1`, `<prefix>_spacer_1`, `<prefix>_web_1`, `<prefix>_cone_1` and
        `<prefix>_foot_1`, with the number of the stage.

    Returns
    -------
    tuple of Section
        Rings and spacers in stage order, then the connections.

    Raises
    ------
    GeometryError
        If a thickness is not positive, or a web or cone does not fit its ring.
    """
    if direction not in (1, -1):
        raise GeometryError(
            f"stage group '{group.name}': direction is {direction}, must be 1 or -1"
        )
    _require_positive(group, "spacer thickness", spacer_thickness_m)
    layout = _layout(group, start_m, direction, material, prefix)
    sections: list[Section] = []
    for stage in range(1, group.count + 1):
        sections.append(layout.ring(stage))
        if stage < group.count:
            sections.append(_spacer(layout, stage, spacer_thickness_m))
    connections = () if web is None else (web,) if isinstance(web, Web | Cone) else tuple(web)
    for item in connections:
        if not 1 <= item.stage <= group.count:
            raise GeometryError(
                f"stage group '{group.name}': a {type(item).__name__.lower()} is asked for at "
                f"stage {item.stage}, there are stages 1 to {group.count}"
            )
        sections += [_web(layout, item)] if isinstance(item, Web) else _cone(layout, item)
    return tuple(sections)


def stage_group_blades(
    group: StageGroup, blades: StageBlades, *, material: Material, prefix: str
) -> tuple[Blade, ...]:
    """Return the blades of a stage group, a row `<prefix>_blades_<stage>` on every ring.

    `prefix`: that of the sections. Raises GeometryError if there is not one count for each stage,
    or a dimension is not positive.
    """
    counts = blades.count * (group.count if len(blades.count) == 1 else 1)
    if len(counts) != group.count:
        raise GeometryError(
            f"stage group '{group.name}': {len(counts)} counts of blades, there are "
            f"{group.count} stages; give one count for all, or one for each"
        )
    cosine = math.cos(math.radians(blades.stagger_deg[0]))
    if blades.chord_m is None and cosine < _LEAST_COSINE:
        raise GeometryError(
            f"stage group '{group.name}': with a stagger of {blades.stagger_deg[0]:g} deg at the "
            "root the chord can not follow from the width of the ring; give chord_m"
        )
    chord = blades.chord_m or (group.width_m / cosine,) * 2
    factor = group.width_factor if blades.chord_factor is None else blades.chord_factor
    rows = []
    for stage, count in enumerate(counts, start=1):
        chords, thicknesses, lengths = (
            tuple(float(stage_values(first, ratio, stage)[-1]) for first in values)
            for values, ratio in (
                (chord, factor),
                (blades.thickness_m, blades.thickness_factor),
                ((blades.length_m,), blades.length_factor),
            )
        )
        rows.append(
            Blade(
                name=f"{prefix}_blades_{stage}",
                on=f"{prefix}_stage_{stage}",
                count=count,
                length_m=lengths[0],
                chord_m=(chords[0], chords[1]),
                thickness_m=(thicknesses[0], thicknesses[1]),
                stagger_deg=blades.stagger_deg,
                material=material,
            )
        )
    return tuple(rows)


def _layout(
    group: StageGroup, start_m: float, direction: Literal[1, -1], material: Material, prefix: str
) -> _Layout:
    """Place ring after spacer after ring, starting with the front face of stage 1."""
    starts, ends = [], []
    front = start_m
    for width, spacer in zip(group.widths_m, group.second_widths_m, strict=True):
        back = front + direction * float(width)
        starts.append(min(front, back))
        ends.append(max(front, back))
        front = back + direction * float(spacer)
    return _Layout(
        group=group,
        starts_m=tuple(starts),
        ends_m=tuple(ends),
        direction=direction,
        material=material,
        prefix=prefix,
    )


def _spacer(layout: _Layout, stage: int, thickness_m: float) -> Section:
    rings = (layout.ring(stage), layout.ring(stage + 1))
    inner = tuple(ring.inner_radius_m[0] for ring in rings)
    outer = tuple(
        min(ring.inner_radius_m[0] + thickness_m, ring.outer_radius_m[0]) for ring in rings
    )
    near, far = rings if layout.direction > 0 else rings[::-1]
    ends = (near.end_m, far.start_m)[:: layout.direction]
    return layout.tapered(
        f"spacer_{stage}", (ends[0], ends[1]), (inner[0], inner[1]), (outer[0], outer[1])
    )


def _web(layout: _Layout, web: Web) -> Section:
    ring = layout.ring(web.stage)
    where = f"web at stage {web.stage}"
    _require_positive(layout.group, f"{where}: thickness", web.thickness_m)
    width = ring.end_m - ring.start_m
    # Equal widths may differ by round-off, which subdivision snaps away.
    if web.thickness_m > width * (1.0 + 1e-12):
        raise GeometryError(
            f"stage group '{layout.group.name}': {where} is {web.thickness_m:.6g} m thick, the "
            f"ring is only {width:.6g} m wide"
        )
    _require_below(layout.group, where, web.inner_radius_m, ring)
    if web.position == "centre":
        start = 0.5 * (ring.start_m + ring.end_m - web.thickness_m)
    elif (web.position == "front") == (layout.direction > 0):
        start = ring.start_m
    else:
        start = ring.end_m - web.thickness_m
    return layout.section(
        f"web_{web.stage}",
        start,
        start + web.thickness_m,
        web.inner_radius_m,
        ring.inner_radius_m[0],
    )


def _cone(layout: _Layout, cone: Cone) -> list[Section]:
    ring = layout.ring(cone.stage)
    where = f"cone at stage {cone.stage}"
    _require_positive(layout.group, f"{where}: thickness", cone.thickness_m)
    _require_below(layout.group, where, cone.shaft_radius_m, ring)
    foot, face = _cone_ends(layout, cone, ring)
    inner, outer = ring.inner_radius_m[0], ring.outer_radius_m[0]
    slope = (inner - cone.shaft_radius_m) / (face - foot)
    height = cone.thickness_m * math.hypot(1.0, slope)
    if height > outer - inner:
        raise GeometryError(
            f"stage group '{layout.group.name}': {where} is {height:.6g} m thick in radial "
            f"direction, the ring's face is only {outer - inner:.6g} m high; make it thinner or "
            "less steep"
        )
    shaft = cone.shaft_radius_m
    return [
        layout.section(
            f"foot_{cone.stage}", cone.foot_start_m, cone.foot_end_m, shaft, shaft + height
        ),
        layout.tapered(
            f"cone_{cone.stage}", (foot, face), (shaft, inner), (shaft + height, inner + height)
        ),
    ]


def _cone_ends(layout: _Layout, cone: Cone, ring: Section) -> tuple[float, float]:
    """Return the axial places [m] where a cone leaves its foot and where it meets the ring."""
    group = layout.group
    if cone.foot_end_m <= cone.foot_start_m:
        raise GeometryError(
            f"stage group '{group.name}': cone at stage {cone.stage} has a foot from "
            f"z = {cone.foot_start_m:.6g} m to {cone.foot_end_m:.6g} m; the end must lie beyond "
            "the start"
        )
    if cone.foot_end_m < ring.start_m:
        foot, face, ahead = cone.foot_end_m, ring.start_m, -1
    elif cone.foot_start_m > ring.end_m:
        foot, face, ahead = cone.foot_start_m, ring.end_m, 1
    else:
        raise GeometryError(
            f"stage group '{group.name}': cone at stage {cone.stage} has a foot from "
            f"z = {cone.foot_start_m:.6g} m to {cone.foot_end_m:.6g} m, which must lie on one side "
            f"of the ring, clear of z = {ring.start_m:.6g} m to {ring.end_m:.6g} m; use a web there"
        )
    neighbour = cone.stage + ahead * layout.direction
    if 1 <= neighbour <= group.count:
        raise GeometryError(
            f"stage group '{group.name}': cone at stage {cone.stage} would meet the ring's face at "
            f"z = {face:.6g} m, which the spacer to stage {neighbour} occupies; use stage 1 from "
            "its front, the last stage from its back, or a web"
        )
    return foot, face


def _require_positive(group: StageGroup, label: str, value: float) -> None:
    if not (math.isfinite(value) and value > 0.0):
        raise GeometryError(
            f"stage group '{group.name}': {label} is {value} m, must be finite and positive"
        )


def _require_below(group: StageGroup, where: str, radius_m: float, ring: Section) -> None:
    if not 0.0 <= radius_m < ring.inner_radius_m[0]:
        raise GeometryError(
            f"stage group '{group.name}': {where} starts at r = {radius_m:.6g} m, which must lie "
            f"below the ring's inner radius {ring.inner_radius_m[0]:.6g} m"
        )


def stage_values(origin: float, factor: float, count: int) -> FloatArray:
    """Return a dimension of consecutive stages: value = origin * factor**(stage - 1).

    `origin`: value of stage 1, in any unit. `factor`: ratio of consecutive stages [-]. Returned:
    (count,) in the unit of `origin`, read-only. Raises GeometryError if origin or factor is not
    finite and positive, or there is no stage.

    Rule of Appendix C of Müller and Hennings, rotor dynamics of an ultra-high bypass ratio engine.
    """
    for label, value in (("origin", origin), ("factor", factor)):
        if not (math.isfinite(value) and value > 0.0):
            raise GeometryError(f"stage rule: {label} is {value}, must be finite and positive")
    if count < 1:
        raise GeometryError(f"stage rule: {count} stages asked for, needs at least one")
    values: FloatArray = origin * factor ** np.arange(count, dtype=np.float64)
    values.setflags(write=False)
    return values


@dataclass(frozen=True, kw_only=True, slots=True)
class StageGroup:
    """Hold the first stage's dimensions of a group and their ratios from stage to stage.

    Raises GeometryError if a value is not finite and positive, or a ring's inner radius reaches its
    outer one.
    """

    name: str
    count: int
    #: Values of stage 1 [m]. `width_m` is the axial width of the disk or drum ring; for
    #: `second_width_m` see `TABLE_7`.
    inner_radius_m: float
    #: Ratio of consecutive stages [-]
    inner_factor: float
    outer_radius_m: float
    outer_factor: float
    width_m: float
    width_factor: float
    second_width_m: float
    second_width_factor: float

    def __post_init__(self) -> None:
        try:
            inner, outer = self.inner_radii_m, self.outer_radii_m
            _ = self.widths_m, self.second_widths_m
        except GeometryError as error:
            raise GeometryError(f"stage group '{self.name}': {error}") from None
        for stage, (low, high) in enumerate(zip(inner, outer, strict=True), start=1):
            if low >= high:
                raise GeometryError(
                    f"stage group '{self.name}': stage {stage} has the inner radius {low:.6g} m, "
                    f"which must be below its outer radius {high:.6g} m"
                )

    @property
    def inner_radii_m(self) -> FloatArray:
        """Inner radius of every stage, (count,) [m]."""
        return stage_values(self.inner_radius_m, self.inner_factor, self.count)

    @property
    def outer_radii_m(self) -> FloatArray:
        """Outer radius of every stage, (count,) [m]."""
        return stage_values(self.outer_radius_m, self.outer_factor, self.count)

    @property
    def widths_m(self) -> FloatArray:
        """Axial width of every stage's ring, (count,) [m]."""
        return stage_values(self.width_m, self.width_factor, self.count)

    @property
    def second_widths_m(self) -> FloatArray:
        """Second width of every stage, (count,) [m]; the last one is not used by the layout."""
        return stage_values(self.second_width_m, self.second_width_factor, self.count)


# Number of stages, then value of stage 1 and factor of inner and outer radius and both widths.
_ROWS = (
    ("lp_compressor", 3, 0.46, 0.99, 0.56, 0.96, 0.035, 0.7, 0.029, 0.71),
    ("lp_turbine", 4, 0.21, 1.05, 0.216, 1.05, 0.011, 1.3, 0.011, 1.3),
    ("hp_compressor", 8, 0.062, 0.922, 0.1, 1.09, 0.059, 0.72, 0.05, 0.72),
    ("hp_turbine", 2, 0.052, 1.08, 0.19, 0.99, 0.0122, 1.4, 0.012, 1.42),
)
TABLE_7: Mapping[str, StageGroup] = MappingProxyType(
    {
        str(row[0]): StageGroup(**dict(zip(StageGroup.__slots__, row, strict=True)))  # type: ignore[arg-type]
        for row in _ROWS
    }
)
"""Table 7 of Müller and Hennings: the four stage groups of the engine (read-only).

The table has two rows of widths per group and does not say what the second one is. ASSUMPTION of
this program: the first row is the axial width of the stage's disk or drum ring, the second row the
axial width of the spacer behind it, between stage k and stage k + 1; the last stage has no spacer.
"""
