"""The body of revolution as an engineer draws it: sections in the meridian half-plane (z, r).

The axis of rotation is z. What is said here is checked value by value; whether the sections
fit together is found by `solidwhirl.geometry.meridian.subdivision.subdivide`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, get_args

from solidwhirl.geometry.errors import GeometryError, require_finite, require_name
from solidwhirl.geometry.features import Feature
from solidwhirl.geometry.joints import Joint
from solidwhirl.geometry.materials import Material

InterfaceKind = Literal["section", "outer", "inner", "face", "slab"]
Coupling = Literal["distributing", "rigid"]


@dataclass(frozen=True, kw_only=True, slots=True)
class Section:
    """Describe a trapezoid of the meridian with radial ends and linearly varying radii.

    Raises GeometryError for a value that is not finite, a negative width or radius, crossing radii,
    no thickness.
    """

    name: str
    #: Axial position of the two radial ends [m], start < end
    start_m: float
    end_m: float
    #: Radii at start and end [m]. Inner and outer may meet at one end (a triangle), not at both.
    inner_radius_m: tuple[float, float]
    outer_radius_m: tuple[float, float]
    material: Material

    def __post_init__(self) -> None:
        require_name("section", self.name)
        where = f"section '{self.name}'"
        for label, radii in (("inner", self.inner_radius_m), ("outer", self.outer_radius_m)):
            if len(radii) != 2:
                raise GeometryError(
                    f"{where}: {label} radius has {len(radii)} values, needs two (start and end)"
                )
        require_finite(where, self.start_m, self.end_m, *self.inner_radius_m, *self.outer_radius_m)
        if self.end_m <= self.start_m:
            raise GeometryError(
                f"{where}: negative width, it starts at z = {self.start_m:.9g} m and ends at "
                f"z = {self.end_m:.9g} m; the end must lie beyond the start"
            )
        self._check_radii(where)

    def _check_radii(self, where: str) -> None:
        ends = (self.start_m, self.end_m)
        for z, inner, outer in zip(ends, self.inner_radius_m, self.outer_radius_m, strict=True):
            if min(inner, outer) < 0.0:
                raise GeometryError(
                    f"{where}: negative radius {min(inner, outer):.9g} m at z = {z:.9g} m"
                )
            if inner > outer:
                raise GeometryError(
                    f"{where}: crossing radii at z = {z:.9g} m, the inner radius {inner:.9g} m "
                    f"exceeds the outer radius {outer:.9g} m"
                )
        if tuple(self.inner_radius_m) == tuple(self.outer_radius_m):
            raise GeometryError(
                f"{where}: no thickness from z = {self.start_m:.9g} m to {self.end_m:.9g} m; inner "
                "and outer radius may meet at one end only"
            )

    def radii_at(self, z_m: float) -> tuple[float, float]:
        """Return inner and outer radius [m] at an axial position, exact at the two ends.

        `z_m`: axial position [m] within the section. Result: inner and outer radius [m]. Raises
        GeometryError if the position lies outside the section.
        """
        if not self.start_m <= z_m <= self.end_m:
            raise GeometryError(
                f"section '{self.name}' reaches from z = {self.start_m:.9g} to {self.end_m:.9g} m; "
                f"z = {z_m:.9g} m lies outside"
            )
        if z_m == self.end_m:
            return self.inner_radius_m[1], self.outer_radius_m[1]
        share = (z_m - self.start_m) / (self.end_m - self.start_m)
        (inner_0, inner_1), (outer_0, outer_1) = self.inner_radius_m, self.outer_radius_m
        return inner_0 + share * (inner_1 - inner_0), outer_0 + share * (outer_1 - outer_0)


@dataclass(frozen=True, kw_only=True, slots=True)
class Interface:
    """Name a part of the body where bearings, gears or other bodies attach.

    Raises GeometryError for an unknown word, a value that is not finite, or a range that does not
    fit the kind.
    """

    name: str
    #: "section": every curve of the material cross-section in the plane z = `start_m`, inside the
    #: body or on its outline; where the cross-section jumps in that plane, the union of both sides.
    #: "face": the part of the outline that lies in the plane z = `start_m`. "outer" and "inner":
    #: the part of the outline between `start_m` and `end_m` whose outward normal points away from
    #: the axis (n_r > 0) or towards it (n_r < 0). "slab": all curves of the piece of the body
    #: between the planes `start_m` and `end_m`, both cross-sections included; rigidly coupled it
    #: moves as one piece, as the cross-sections of a beam under a clamped hub do.
    kind: InterfaceKind
    coupling: Coupling
    #: Axial range [m]; equal for "section" and "face", start < end otherwise
    start_m: float
    end_m: float
    #: Radial range [m] the interface is limited to; everything when None
    radius_m: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        require_name("interface", self.name)
        where = f"interface '{self.name}'"
        for label, value, allowed in (
            ("kind", self.kind, get_args(InterfaceKind)),
            ("coupling", self.coupling, get_args(Coupling)),
        ):
            if value not in allowed:
                raise GeometryError(f"{where}: {label} is '{value}', allowed: {', '.join(allowed)}")
        require_finite(where, self.start_m, self.end_m)
        span = f"z = {self.start_m:.9g} m to {self.end_m:.9g} m"
        if self.kind in ("section", "face") and self.start_m != self.end_m:
            raise GeometryError(
                f"{where}: {span} given for the kind '{self.kind}', which lies in one plane; "
                "start and end must be equal"
            )
        if self.kind in ("outer", "inner", "slab") and self.end_m <= self.start_m:
            raise GeometryError(
                f"{where}: {span} given for the kind '{self.kind}'; the end must lie beyond the "
                "start"
            )
        if self.radius_m is not None:
            _check_radial_range(where, self.radius_m)

    @property
    def planes_m(self) -> tuple[float, ...]:
        """Planes z [m] in which the interface cuts the material."""
        if self.kind == "section":
            return (self.start_m,)
        return (self.start_m, self.end_m) if self.kind == "slab" else ()

    @property
    def position_m(self) -> tuple[float, float, float]:
        """Position (x, y, z) [m] of the master node: on the axis, in the middle of the range."""
        return 0.0, 0.0, 0.5 * (self.start_m + self.end_m)


@dataclass(frozen=True, kw_only=True, slots=True)
class RigidDisk:
    """Lump a rigid disk on the master node of an interface.

    Raises GeometryError if a value is not finite or the inertia cannot belong to a body.
    """

    name: str  #: Unique among the rigid disks of its body
    interface: str  #: Name of the interface that carries the disk
    mass_kg: float  #: Mass [kg], not negative
    #: Moments of inertia [kg m^2] about the disk's centre of gravity, not negative and polar <= 2
    #: diametral (to 1 %), as for every mass distribution
    polar_inertia_kg_m2: float
    diametral_inertia_kg_m2: float
    offset_m: float = 0.0  #: Axial distance [m] of the centre of gravity from the master node

    def __post_init__(self) -> None:
        require_name("rigid disk", self.name)
        where = f"rigid disk '{self.name}'"
        values = (self.mass_kg, self.polar_inertia_kg_m2, self.diametral_inertia_kg_m2)
        require_finite(where, *values, self.offset_m)
        if min(values) < 0.0:
            raise GeometryError(
                f"{where}: mass {self.mass_kg} kg, polar inertia {self.polar_inertia_kg_m2} and "
                f"diametral inertia {self.diametral_inertia_kg_m2} kg m^2 must not be negative"
            )
        # One per cent leaves room for a thin disk (polar = 2 diametral) given with three digits.
        if self.polar_inertia_kg_m2 > 2.02 * self.diametral_inertia_kg_m2:
            raise GeometryError(
                f"{where}: polar inertia {self.polar_inertia_kg_m2} kg m^2 exceeds twice the "
                f"diametral inertia {self.diametral_inertia_kg_m2} kg m^2; no body is that flat"
            )


@dataclass(frozen=True, kw_only=True, slots=True)
class Body:
    """Collect the sections, features, interfaces and lumped disks of one body.

    Raises GeometryError for no section, a duplicate name, a disk on an unknown interface, a feature
    of an unknown section, a bad fillet radius.
    """

    name: str
    sections: tuple[Section, ...]  #: At least one; names unique
    interfaces: tuple[Interface, ...] = ()
    #: Each refers to an interface of this body; names unique
    rigid_disks: tuple[RigidDisk, ...] = ()
    #: Radius [m] of the fillet at every re-entrant corner of the outline; 0 for sharp corners
    fillet_radius_m: float = 0.0
    #: Blades, holes, ... around the circumference; names unique, and those of no section
    features: tuple[Feature, ...] = ()
    #: Faces along which sections are parted; all others that touch are bonded
    joints: tuple[Joint, ...] = ()

    def __post_init__(self) -> None:
        require_name("body", self.name)
        where = f"body '{self.name}'"
        if not self.sections:
            raise GeometryError(f"{where} has no section, needs at least one")
        _require_unique(where, "section", (section.name for section in self.sections))
        _require_unique(where, "interface", (interface.name for interface in self.interfaces))
        _require_unique(where, "rigid disk", (disk.name for disk in self.rigid_disks))
        known = [interface.name for interface in self.interfaces]
        for disk in self.rigid_disks:
            if disk.interface not in known:
                raise GeometryError(
                    f"{where}: rigid disk '{disk.name}' sits on the interface '{disk.interface}', "
                    f"which does not exist; known: {', '.join(known) or 'none'}"
                )
        self._check_features(where)
        for joint in self.joints:
            joint.refuse_untold()
        if not (math.isfinite(self.fillet_radius_m) and self.fillet_radius_m >= 0.0):
            raise GeometryError(
                f"{where}: fillet radius is {self.fillet_radius_m} m, must be finite and not "
                "negative"
            )

    def _check_features(self, where: str) -> None:
        _require_unique(where, "feature", (feature.name for feature in self.features))
        known = [section.name for section in self.sections]
        for feature in self.features:
            place = f"{where}: {feature.kind} '{feature.name}'"
            if feature.name in known:
                raise GeometryError(f"{place}: a section has this name, choose another")
            if feature.section not in known:
                raise GeometryError(
                    f"{place}: there is no section '{feature.section}'; known: {', '.join(known)}"
                )


def _require_unique(where: str, what: str, names: Iterable[str]) -> None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise GeometryError(f"{where}: two {what}s are called '{name}', names must be unique")
        seen.add(name)


def _check_radial_range(where: str, radius_m: tuple[float, float]) -> None:
    if len(radius_m) != 2:
        raise GeometryError(f"{where}: radial range has {len(radius_m)} values, needs two")
    require_finite(where, *radius_m)
    if radius_m[0] < 0.0 or radius_m[1] <= radius_m[0]:
        raise GeometryError(
            f"{where}: radial range {radius_m[0]:.9g} m to {radius_m[1]:.9g} m; it must start at "
            "0 or above and end beyond its start"
        )
