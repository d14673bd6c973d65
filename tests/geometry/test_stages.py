"""The stage rule, the table, and stage groups laid out as sections."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from outlines import conforming
from shapes import body, section

from solidwhirl.geometry import (
    MATERIALS,
    TABLE_7,
    Cone,
    GeometryError,
    Web,
    mass_properties,
    stage_group_sections,
    stage_values,
    subdivide,
)

TITANIUM = MATERIALS["titanium"]


def lay(group, start=0.0, direction=1, spacer=0.005, web=None):
    return stage_group_sections(
        TABLE_7[group],
        start_m=start,
        direction=direction,
        material=TITANIUM,
        spacer_thickness_m=spacer,
        web=web,
        prefix="g",
    )


def web_at(stage, thickness, inner, position="centre"):
    return Web(stage=stage, thickness_m=thickness, inner_radius_m=inner, position=position)


def cone_at(stage, shaft_radius, foot, thickness):
    return Cone(
        stage=stage,
        shaft_radius_m=shaft_radius,
        foot_start_m=foot[0],
        foot_end_m=foot[1],
        thickness_m=thickness,
    )


def by_name(sections):
    return {section.name: section for section in sections}


def test_rule_by_hand():
    assert stage_values(2.0, 0.5, 4).tolist() == [2.0, 1.0, 0.5, 0.25]
    assert stage_values(0.1, 1.09, 8)[7] == pytest.approx(0.1828039, rel=1e-6)  # 0.1 * 1.09^7


def test_table_of_the_paper():
    rows = {
        name: (
            group.count,
            group.inner_radius_m,
            group.inner_factor,
            group.outer_radius_m,
            group.outer_factor,
            group.width_m,
            group.width_factor,
            group.second_width_m,
            group.second_width_factor,
        )
        for name, group in TABLE_7.items()
    }
    assert rows == {
        "lp_compressor": (3, 0.46, 0.99, 0.56, 0.96, 0.035, 0.7, 0.029, 0.71),
        "lp_turbine": (4, 0.21, 1.05, 0.216, 1.05, 0.011, 1.3, 0.011, 1.3),
        "hp_compressor": (8, 0.062, 0.922, 0.1, 1.09, 0.059, 0.72, 0.05, 0.72),
        "hp_turbine": (2, 0.052, 1.08, 0.19, 0.99, 0.0122, 1.4, 0.012, 1.42),
    }
    assert all(name == group.name for name, group in TABLE_7.items())
    with pytest.raises(TypeError):
        TABLE_7["fan"] = TABLE_7["hp_turbine"]


def test_last_stages_by_hand():
    """Values worked out with four or five digits on paper."""
    hp = TABLE_7["hp_compressor"]
    assert hp.outer_radii_m[7] == pytest.approx(0.1 * 1.09**7)
    assert hp.inner_radii_m[7] == pytest.approx(0.035113, rel=1e-4)
    assert hp.widths_m[7] == pytest.approx(0.005918, rel=1e-4)
    lp = TABLE_7["lp_compressor"]
    assert lp.inner_radii_m == pytest.approx([0.46, 0.4554, 0.450846])
    assert lp.outer_radii_m == pytest.approx([0.56, 0.5376, 0.516096])
    assert lp.widths_m == pytest.approx([0.035, 0.0245, 0.01715])
    assert lp.second_widths_m[:2] == pytest.approx([0.029, 0.02059])


HP_TURBINE = TABLE_7["hp_turbine"]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: stage_values(0.0, 1.0, 3), "origin is 0.0, must be finite and positive"),
        (lambda: stage_values(1.0, -1.0, 3), "factor is -1.0"),
        (lambda: stage_values(math.nan, 1.0, 3), "origin is nan"),
        (lambda: stage_values(1.0, 1.0, 0), "0 stages asked for"),
        (
            lambda: replace(HP_TURBINE, inner_factor=4.0),
            "'hp_turbine': stage 2 has the inner radius 0.208",
        ),
        (lambda: replace(HP_TURBINE, width_factor=0), "'hp_turbine': stage rule: factor is 0"),
        (lambda: lay("lp_compressor", spacer=0.0), "spacer thickness is 0.0 m, must be finite"),
        (lambda: lay("lp_compressor", direction=2), "direction is 2, must be 1 or -1"),
    ],
)
def test_refused_groups(make, message):
    with pytest.raises(GeometryError, match=message):
        make()


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("group", list(TABLE_7))
def test_every_group_is_one_drum(group, direction):
    """Rings and spacers alone are one body; its length is the sum of the widths."""
    sections = lay(group, start=0.3, direction=direction)
    table = TABLE_7[group]
    assert len(sections) == 2 * table.count - 1
    conforming(subdivide(body(*sections)))
    length = table.widths_m.sum() + table.second_widths_m[:-1].sum()
    places = [z for section in sections for z in (section.start_m, section.end_m)]
    assert max(places) - min(places) == pytest.approx(length, rel=1e-12)
    assert (min(places) if direction == 1 else max(places)) == 0.3
    ring = by_name(sections)["g_stage_1"]
    assert (ring.start_m if direction == 1 else ring.end_m) == 0.3


@pytest.mark.parametrize("group", list(TABLE_7))
def test_reversed_group_is_the_mirror_image(group):
    one, two = (mass_properties(body(*lay(group, direction=d))) for d in (1, -1))
    (*_, place), (*_, mirrored) = one.center_of_gravity_m, two.center_of_gravity_m
    assert (two.mass_kg, mirrored, two.diametral_inertia_kg_m2) == pytest.approx(
        (one.mass_kg, -place, one.diametral_inertia_kg_m2), rel=1e-12
    )


def test_spacer_ends_lie_on_the_rings_they_meet():
    for direction in (1, -1):
        found = by_name(lay("hp_compressor", direction=direction))
        for stage in range(1, 8):
            near, far = found[f"g_stage_{stage}"], found[f"g_stage_{stage + 1}"]
            spacer = found[f"g_spacer_{stage}"]
            inner, outer = (
                radii[::direction] for radii in (spacer.inner_radius_m, spacer.outer_radius_m)
            )
            assert inner == (near.inner_radius_m[0], far.inner_radius_m[0])
            assert np.subtract(outer, inner) == pytest.approx([0.005, 0.005])
            faces = sorted((near.end_m, far.start_m, near.start_m, far.end_m))[1:3]
            assert (spacer.start_m, spacer.end_m) == tuple(faces)


def test_drum_thinner_than_its_spacers_takes_its_own_thickness():
    found = by_name(lay("lp_turbine", spacer=0.02))
    spacer = found["g_spacer_2"]
    assert spacer.inner_radius_m == pytest.approx((0.21 * 1.05, 0.21 * 1.05**2))
    assert spacer.outer_radius_m == pytest.approx((0.216 * 1.05, 0.216 * 1.05**2))


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize(("position", "share"), [("centre", 0.5), ("front", 0.0), ("back", 1.0)])
def test_web_position(direction, position, share):
    """The web's free width is (1 - share) behind it and share before it, seen from stage 1."""
    web = web_at(2, 0.01, 0.05, position)
    found = by_name(lay("lp_compressor", direction=direction, web=web))
    ring, disk = found["g_stage_2"], found["g_web_2"]
    before = disk.start_m - ring.start_m if direction == 1 else ring.end_m - disk.end_m
    assert before == pytest.approx(share * (0.0245 - 0.01), abs=1e-15)
    assert disk.end_m - disk.start_m == pytest.approx(0.01)
    assert disk.inner_radius_m == (0.05, 0.05)
    assert disk.outer_radius_m == ring.inner_radius_m


@pytest.mark.parametrize("direction", [1, -1])
def test_low_pressure_spool_is_one_piece(direction):
    """Shaft, compressor on two webs, turbine on a web and a cone, as one body."""
    turbine = 1.2 * direction
    foot = sorted((turbine + 0.2 * direction, turbine + 0.23 * direction))
    shaft = (
        section("shaft", -0.2, 1.6, 0.03, 0.05)
        if direction == 1
        else section("shaft", -1.6, 0.2, 0.03, 0.05)
    )
    shape = body(
        shaft,
        *(
            replace(part, name=f"c_{part.name}")
            for part in lay(
                "lp_compressor",
                direction=direction,
                web=[web_at(1, 0.035, 0.05), web_at(3, 0.01, 0.05, "back")],
            )
        ),
        *lay(
            "lp_turbine",
            start=turbine,
            direction=direction,
            web=[web_at(2, 0.008, 0.05), cone_at(4, 0.05, foot, 0.002)],
        ),
    )
    found = subdivide(shape)
    conforming(found)
    assert len(found.faces) == len(shape.sections)
    assert len(found.corners) > 20


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("ahead", [True, False])
def test_cone_wall(direction, ahead):
    """Both lines of the wall are parallel and its normal thickness is the one asked for."""
    stage = 1 if ahead else 8
    parts = lay("hp_compressor", direction=direction)
    low, high = min(part.start_m for part in parts), max(part.end_m for part in parts)
    below = ahead == (direction == 1)
    foot = (low - 0.06, low - 0.04) if below else (high + 0.04, high + 0.06)
    sections = lay("hp_compressor", direction=direction, web=cone_at(stage, 0.02, foot, 0.003))
    found = by_name(sections)
    wall, ring = found[f"g_cone_{stage}"], found[f"g_stage_{stage}"]
    length = wall.end_m - wall.start_m
    rise = wall.inner_radius_m[1] - wall.inner_radius_m[0]
    assert wall.outer_radius_m[1] - wall.outer_radius_m[0] == pytest.approx(rise)
    radial = wall.outer_radius_m[0] - wall.inner_radius_m[0]
    assert radial * math.cos(math.atan2(rise, length)) == pytest.approx(0.003)
    assert max(wall.inner_radius_m) == ring.inner_radius_m[0]
    assert min(wall.inner_radius_m) == 0.02
    shaft = section("shaft", min(foot[0], low), max(foot[1], high), 0.0, 0.02)
    conforming(subdivide(body(shaft, *sections)))


@pytest.mark.parametrize(
    ("web", "message"),
    [
        (web_at(4, 0.01, 0.05), "a web is asked for at stage 4"),
        (web_at(0, 0.01, 0.05), "stage 0, there are stages 1 to 3"),
        (web_at(3, 0.02, 0.05), "web at stage 3 is 0.02 m thick, the ring is only 0.01715 m wide"),
        (web_at(1, 0.0, 0.05), "web at stage 1: thickness is 0.0 m"),
        (
            web_at(1, 0.01, 0.46),
            "web at stage 1 starts at r = 0.46 m, which must lie below the ring's inner radius",
        ),
        (cone_at(1, 0.5, (-0.3, -0.2), 0.01), "cone at stage 1 starts at r = 0.5 m"),
        (
            cone_at(1, 0.05, (-0.2, -0.3), 0.01),
            "foot from z = -0.2 m to -0.3 m; the end must lie beyond",
        ),
        (
            cone_at(1, 0.05, (-0.2, 0.0), 0.01),
            "must lie on one side of the ring, clear of z = 0 m to 0.035 m; use a web",
        ),
        (
            cone_at(1, 0.05, (0.2, 0.3), 0.01),
            "at z = 0.035 m, which the spacer to stage 2 occupies",
        ),
        (cone_at(3, 0.05, (-0.2, -0.1), 0.01), "which the spacer to stage 2 occupies"),
        (
            cone_at(1, 0.05, (-0.2, -0.1), 0.03),
            "is 0.126606 m thick in radial direction, the ring's face is only 0.1 m high",
        ),
        (cone_at(1, 0.05, (-0.2, -0.1), -1.0), "cone at stage 1: thickness is -1.0 m"),
    ],
)
def test_refused_connections(web, message):
    with pytest.raises(GeometryError, match=f"stage group 'lp_compressor'.*{message}"):
        lay("lp_compressor", web=web)
