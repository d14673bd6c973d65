"""Sections, interfaces and bodies for tests, from their dimensions in metres."""

from __future__ import annotations

import dataclasses

from solidwhirl.geometry import MATERIALS, Blade, Body, Interface, Section

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


def bladed_disk(count=12, stagger_deg=30.0, joint=None):
    """Disk 0.03 to 0.1 m, 0.012 m wide, held at its bore, with plates 0.05 m long.

    `joint`: radius of a joint between a hub and the rim that carries the blades.
    """
    radii = [0.03, 0.1] if joint is None else [0.03, joint, 0.1]
    names = ["disk"] if joint is None else ["hub", "rim"]
    blades = Blade(
        name="blades", on=names[-1], count=count, length_m=0.05, chord_m=(0.02, 0.02),
        thickness_m=(0.004, 0.004), stagger_deg=(stagger_deg, stagger_deg), material=STEEL,
    )  # fmt: skip
    rings = [
        section(name, -0.006, 0.006, inner, outer)
        for name, inner, outer in zip(names, radii[:-1], radii[1:], strict=True)
    ]
    bore = interface("bore", "inner", -0.006, 0.006, coupling="rigid")
    return dataclasses.replace(body(*rings, interfaces=(bore,)), features=(blades,))
