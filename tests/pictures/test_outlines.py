"""Outlines have the volume of their bodies, and tell where surfaces are."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from solidwhirl.bodies import build_bodies
from solidwhirl.geometry import mass_properties
from solidwhirl.pictures.outlines import (
    _of_profile,
    outlines_of,
)


def _volume(area):
    """Of the solid that an area makes around the axis: Pappus, 2π times the moment of area."""
    z, r = np.vstack((area, area[:1])).T
    cross = z[:-1] * r[1:] - z[1:] * r[:-1]
    return abs(2.0 * np.pi * ((r[:-1] + r[1:]) * cross).sum() / 6.0)


def test_outlines_have_the_mass_of_the_bodies(twin):
    for outline in outlines_of(twin):
        density = 7800.0
        body = build_bodies(twin.scene)[outline.body]
        mass = mass_properties(body).mass_kg
        density = body.sections[0].material.density_kg_per_m3
        # the scene's bodies are of one material; sums of exact moments, so rounding only
        assert density * sum(map(_volume, outline.areas)) == pytest.approx(mass, rel=1e-12)


def test_fillets_belong_to_the_outline(twin):
    body = dataclasses.replace(build_bodies(twin.scene)["inner"], fillet_radius_m=0.005)
    areas, lines = _of_profile(body)
    volume = sum(map(_volume, areas))
    mass = mass_properties(body).mass_kg
    # arcs are drawn with 11 chords of 8°: their area is right to (8°)²/6 = 0.3 % of the fillet's
    fillets = mass / body.sections[0].material.density_kg_per_m3 - sum(map(_volume, areas[:2]))
    assert volume - sum(map(_volume, areas[:2])) == pytest.approx(fillets, rel=0.05)
    assert fillets > 0.0
    assert any(len(line) > 2 for line in lines)


def test_radii_at_a_place(twin, geared):
    inner, outer = outlines_of(twin)
    assert inner.radii_at(0.05) == pytest.approx((0.0, 0.02))
    assert inner.radii_at(0.13) == pytest.approx((0.0, 0.15))
    assert outer.radii_at(0.3) == pytest.approx((0.03, 0.035))
    assert outer.radii_at(0.1) is None
    fast = next(o for o in outlines_of(geared) if o.body == "fast")
    assert fast.radii_at(1.0) == pytest.approx((0.01, 0.02))


def test_disks_have_the_radius_of_their_inertia(laval, geared):
    """A uniform thin disk has Ip = m r²/2."""
    (rotor,) = outlines_of(laval)
    (disk,) = rotor.disks
    assert disk.axial_m == 0.5
    assert 0.5 * 5.0 * disk.radius_m**2 == pytest.approx(0.05)
    slow = outlines_of(geared)[[o.body for o in outlines_of(geared)].index("slow")]
    assert slow.disks[0].radius_m == pytest.approx(0.1)


def test_rigid_bodies_have_interfaces_only(geared):
    casing = next(o for o in outlines_of(geared) if o.body == "casing")
    assert casing.areas == () and casing.lines == ()
    assert casing.interfaces == {"front": 0.1, "middle": 0.55, "rear": 1.1}
