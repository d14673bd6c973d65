"""Sections, interfaces and bodies for tests, from their dimensions in metres."""

from __future__ import annotations

from solidwhirl.geometry import MATERIALS, Body, Interface, Section

STEEL = MATERIALS["steel"]


def section(name, start, end, inner, outer, material=STEEL):
    """A section of steel; radii as one number or as (start, end)."""
    pair = lambda r: r if isinstance(r, tuple) else (r, r)  # noqa: E731
    return Section(
        name=name,
        start_m=start,
        end_m=end,
        inner_radius_m=pair(inner),
        outer_radius_m=pair(outer),
        material=material,
    )


def interface(name, kind, start, end=None, radius=None, coupling="distributing"):
    return Interface(
        name=name,
        kind=kind,
        coupling=coupling,
        start_m=start,
        end_m=start if end is None else end,
        radius_m=radius,
    )


def plane(name, z, coupling="distributing", kind="section"):
    return interface(name, kind, z, coupling=coupling)


def body(*sections, interfaces=(), fillet=0.0, disks=(), name="rotor"):
    return Body(
        name=name,
        sections=sections,
        interfaces=tuple(interfaces),
        rigid_disks=tuple(disks),
        fillet_radius_m=fillet,
    )


def shaft_and_disk(**options):
    """Reference rotor: steel shaft 0.4 m long, disk 0.03 m wide centred at z = 0.16 m."""
    parts = section("shaft", 0.0, 0.4, 0.0, 0.02), section("disk", 0.145, 0.175, 0.02, 0.15)
    return body(*parts, **options)
