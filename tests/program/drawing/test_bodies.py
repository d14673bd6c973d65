"""Outlines have the volume of their bodies, and tell where surfaces are."""

from __future__ import annotations

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from engine_runs import beam_scene
from still_surface import still_surface

from solidwhirl.drawing.bodies import areas_of_surface, silhouettes_of
from solidwhirl.geometry import mass_properties
from solidwhirl.model.bodies import build_bodies
from solidwhirl.pipeline.run import run_scene


def _volume(area):
    """Of the solid that an area makes around the axis: Pappus, 2π times the moment of area."""
    z, r = np.vstack((area, area[:1])).T
    cross = z[:-1] * r[1:] - z[1:] * r[:-1]
    return abs(2.0 * np.pi * ((r[:-1] + r[1:]) * cross).sum() / 6.0)


def test_outlines_have_the_mass_of_the_bodies(twin):
    for outline in silhouettes_of(twin):
        body = build_bodies(twin.scene)[outline.name]
        mass = mass_properties(body).mass_kg
        density = body.sections[0].material.density_kg_per_m3
        # the scene's bodies are of one material; sums of exact moments, so rounding only
        assert density * sum(map(_volume, outline.areas_m)) == pytest.approx(mass, rel=1e-12)


def test_fillets_belong_to_the_outline(twin):
    spec = twin.scene.bodies["inner"].model_copy(update={"fillet_radius_m": 0.005})
    bodies = {**twin.scene.bodies, "inner": spec}
    slow = twin.scene.speeds.model_copy(update={"to_rpm": 100.0, "count": 2})
    scene = beam_scene("ferraris", analyses=(), bodies=bodies, speeds=slow)
    found = silhouettes_of(run_scene(scene))[0]
    body = build_bodies(scene)["inner"]
    sections = sum(map(_volume, found.areas_m[: len(body.sections)]))
    density = body.sections[0].material.density_kg_per_m3
    fillets = mass_properties(body).mass_kg / density - sections
    # arcs are drawn with 11 chords of 8°: their area is right to (8°)²/6 = 0.3 % of the fillet's
    drawn = sum(map(_volume, found.areas_m[len(body.sections) :]))
    assert drawn == pytest.approx(fillets, rel=0.05)
    assert fillets > 0.0
    assert any(len(line) > 2 for line in found.lines_m)
    assert found.labels[-1] == f"inner: fillet, {found.materials[-1]}"


def test_radii_at_a_place(twin, geared):
    inner, outer = silhouettes_of(twin)
    assert inner.radii_at(0.05) == pytest.approx((0.0, 0.02))
    assert inner.radii_at(0.13) == pytest.approx((0.0, 0.15))
    assert outer.radii_at(0.3) == pytest.approx((0.03, 0.035))
    assert outer.radii_at(0.1) is None
    fast = next(b for b in silhouettes_of(geared) if b.name == "fast")
    assert fast.radii_at(1.0) == pytest.approx((0.01, 0.02))


def test_disks_have_the_radius_of_their_inertia(laval, geared):
    """A uniform thin disk has Ip = m r²/2."""
    (rotor,) = silhouettes_of(laval)
    (disk,) = rotor.disks
    assert disk.at_m == 0.5
    assert 0.5 * 5.0 * disk.radius_m**2 == pytest.approx(0.05)
    slow = next(b for b in silhouettes_of(geared) if b.name == "slow")
    assert slow.disks[0].radius_m == pytest.approx(0.1)


def test_rigid_bodies_have_nodes_only(geared):
    casing = next(b for b in silhouettes_of(geared) if b.name == "casing")
    assert (casing.kind, casing.areas_m, casing.lines_m) == ("none", (), ())
    assert {n: z for n, (z, _) in casing.nodes_m.items()} == {
        "front": 0.1,
        "middle": 0.55,
        "rear": 1.1,
    }


def _meridian(*loops):
    """A body whose surface is that of a meridian with some closed or open outlines."""
    edges, count = [], 0
    for loop, closed in loops:
        ring = [*range(count, count + len(loop)), *([count] if closed else [])]
        edges += pairwise(ring)
        count += len(loop)
    points = np.concatenate([np.array(loop, dtype=float) for loop, _ in loops])
    return points, np.array(edges)


def test_a_mesh_of_a_meridian_is_cut_with_its_cavity():
    """A drum of radius 0.2 with a ring-shaped cavity: the volume of what is left."""
    box = [(0, 0), (0, 0.2), (1, 0.2), (1, 0)]
    hole = [(0.4, 0.05), (0.6, 0.05), (0.6, 0.1), (0.4, 0.1)]
    points, edges = _meridian((box, False), (hole, True))
    surface = still_surface(points, edges)
    (area,) = areas_of_surface(SimpleNamespace(surface=surface))[1]
    expected = np.pi * (0.2**2 - 0.2 * (0.1**2 - 0.05**2))
    assert _volume(area) == pytest.approx(expected)
