"""Lengths below which two coordinates are the same, and a body moved onto that grid."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from solidwhirl.geometry.profile import Body, Interface, Section


@dataclass(frozen=True, kw_only=True, slots=True)
class Scale:
    """Hold a body's size and the two small lengths derived from it."""

    size_m: float  #: Larger of the axial length and the outer radius [m]

    @property
    def tolerance_m(self) -> float:
        """Length [m] below which two places are the same: 1e-9 of the size."""
        return 1e-9 * self.size_m

    @property
    def detail_m(self) -> float:
        """Length [m] below which a feature or a gap is refused as a slip: 1e-6 of the size."""
        return 1e-6 * self.size_m


def axial_range(body: Body) -> tuple[float, float]:
    """Return the first and last axial position [m] of a body's sections."""
    return (
        min(section.start_m for section in body.sections),
        max(section.end_m for section in body.sections),
    )


def radial_range(body: Body) -> tuple[float, float]:
    """Return the smallest inner and the largest outer radius [m] of a body's sections."""
    return (
        min(min(section.inner_radius_m) for section in body.sections),
        max(max(section.outer_radius_m) for section in body.sections),
    )


def scale_of(body: Body) -> Scale:
    """Return the scale of a body."""
    start, end = axial_range(body)
    return Scale(size_m=max(end - start, radial_range(body)[1]))


def snap_body(body: Body, tolerance_m: float) -> Body:
    """Return the body with coordinates that differ by less than the tolerance made equal.

    `tolerance_m`: length [m]. Among near-equal coordinates the one met first wins (sections before
    interfaces, and the axis r = 0 before every other radius). Raises GeometryError if a section or
    interface has no width or thickness left.
    """
    axial = _grid(
        [
            *(z for s in body.sections for z in (s.start_m, s.end_m)),
            *(z for i in body.interfaces for z in (i.start_m, i.end_m)),
        ],
        tolerance_m,
    )
    radial = _grid(
        [
            0.0,
            *(r for s in body.sections for r in (*s.inner_radius_m, *s.outer_radius_m)),
            *(r for i in body.interfaces for r in i.radius_m or ()),
        ],
        tolerance_m,
    )

    def pair(radii: tuple[float, float]) -> tuple[float, float]:
        return _nearest(radii[0], radial), _nearest(radii[1], radial)

    def section(item: Section) -> Section:
        return replace(
            item,
            start_m=_nearest(item.start_m, axial),
            end_m=_nearest(item.end_m, axial),
            inner_radius_m=pair(item.inner_radius_m),
            outer_radius_m=pair(item.outer_radius_m),
        )

    def interface(item: Interface) -> Interface:
        return replace(
            item,
            start_m=_nearest(item.start_m, axial),
            end_m=_nearest(item.end_m, axial),
            radius_m=None if item.radius_m is None else pair(item.radius_m),
        )

    return replace(
        body,
        sections=tuple(section(item) for item in body.sections),
        interfaces=tuple(interface(item) for item in body.interfaces),
    )


def _grid(values: Iterable[float], tolerance_m: float) -> list[float]:
    kept: list[float] = []
    for value in values:
        if all(abs(value - other) > tolerance_m for other in kept):
            kept.append(value)
    return kept


def _nearest(value: float, grid: Sequence[float]) -> float:
    return min(grid, key=lambda other: abs(other - value))
