"""Bodies of equal sectors from a mesh file: keys, plan, what is told of the whole."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import meshio
import numpy as np
import pytest

from solidwhirl.core.errors import SceneError
from solidwhirl.cost.work import predict_body_cost
from solidwhirl.geometry import MATERIALS
from solidwhirl.meshing import MeshingError
from solidwhirl.model.effects import make_plan
from solidwhirl.model.interface_documents import interfaces_document
from solidwhirl.model.mesh_bodies import build_mesh_bodies, described, made_mesh, source_document
from solidwhirl.scene_reading.reader import parse_scene

sys.path.insert(0, str(Path(__file__).parents[2] / "meshing"))

from sector_makers import paddles, ring

COUNT = 12
BOX = [[-0.41, -0.41, -0.1], [0.41, 0.41, 0.6]]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A sector of a ring 0.4 <= r <= 1, 0 <= z <= 0.5, its bore a group, and the whole."""
    out = tmp_path_factory.mktemp("ring")
    for name, number in (("sector", 1), ("whole", COUNT)):
        points, cells = ring(COUNT, 2, 2, sectors=number)
        bore = np.flatnonzero(np.hypot(*points[:, :2].T) < 0.401)
        meshio.Mesh(points, [("hexahedron", cells)], point_sets={"BORE": bore}).write(
            out / f"{name}.inp"
        )
    return out


def scene(folder, bearing=None, **changes):
    body = {
        "file": "sector.inp",
        "length_unit": "m",
        "sectors": COUNT,
        "material": "steel",
        "interfaces": [{"name": "bore", "group": "BORE"}],
    } | changes
    data = {
        "name": "ring",
        "speeds": {"list_rpm": [0.0, 3000.0]},
        "mesh_bodies": {"ring": {k: v for k, v in body.items() if v is not None}},
    }
    if body["interfaces"]:
        held = {"name": "b", "first": "ring.bore", "stiffness_n_per_m": 1e8}
        data["bearings"] = [held | (bearing or {})]
    return parse_scene(data, folder / "scene.toml")


SECTORS = {
    0: "sectors: Input should be greater than or equal to 3",
    1: "1 sector is the whole; leave sectors out",
    2: "2 sectors make an asymmetric body",
    10_001: "sectors: Input should be less than or equal to 10000",
    "12": "sectors: Input should be a valid integer",
    12.0: "sectors: Input should be a valid integer",
}


@pytest.mark.parametrize("value", SECTORS)
def test_numbers_of_sectors_that_are_none(folder, value):
    with pytest.raises(SceneError, match=SECTORS[value]) as raised:
        scene(folder, sectors=value)
    assert "mesh_bodies.ring.sectors" in str(raised.value)


def test_without_sectors_the_mesh_is_no_body_of_revolution(folder):
    with pytest.raises(MeshingError, match=r"one of 3 or more equal sectors, say how many"):
        build_mesh_bodies(scene(folder, sectors=None, interfaces=[]))


def test_the_message_of_a_mesh_begins_with_its_key(folder):
    with pytest.raises(MeshingError, match=r"^mesh_bodies\.ring: sectors = 11: no face"):
        build_mesh_bodies(scene(folder, sectors=11))


@pytest.mark.parametrize("file", ["sector.inp", "whole.inp"])
@pytest.mark.parametrize("speed_ratio", [1.0, 0.0])
def test_a_body_tells_of_the_whole(folder, file, speed_ratio):
    asked = scene(folder, file=file, speed_ratio=speed_ratio)
    body = build_mesh_bodies(asked)["ring"]
    # a polygon with 24 sides
    area = 12.0 * np.sin(np.pi / 12.0) * (1.0 - 0.4**2)
    steel = MATERIALS["steel"].density_kg_per_m3
    assert body.volume_m3 == pytest.approx(0.5 * area, rel=1e-12)
    assert body.mass.mass_kg == pytest.approx(0.5 * area * steel, rel=1e-12)
    assert body.mass.center_of_gravity_m == pytest.approx((0.0, 0.0, 0.25), abs=1e-12)
    inertia = np.array(body.mass.inertia_kg_m2)
    assert np.allclose(inertia, np.diag(np.diag(inertia)), rtol=0, atol=0)
    assert inertia[0, 0] == inertia[1, 1]
    # of the polygon: ∫ r² = area R² (2 + cos(2π/24)) / 6 of each of both
    polar = 12.0 * np.sin(np.pi / 12.0) * (1.0 - 0.4**4) * (2.0 + np.cos(np.pi / 12.0)) / 6.0
    assert inertia[2, 2] == pytest.approx(0.5 * polar * steel, rel=1e-12)
    mesh = made_mesh(body)
    assert mesh.sector.count == COUNT
    assert not mesh.sector.mirrored
    assert described(body, mesh) is body
    assert source_document(body)["sectors"] == COUNT
    json.dumps(source_document(body))


@pytest.mark.parametrize(
    ("bearing", "orders", "fields"),
    # displacements of index 1 are complex: two real fields on the sector
    [({}, (1,), 2), ({"axial_stiffness_n_per_m": 1e7}, (1, 0), 3)],
)
def test_the_plan_has_the_orders_of_a_body_of_revolution(folder, bearing, orders, fields):
    asked = scene(folder, bearing=bearing)
    plan = make_plan(asked, {}).bodies["ring"]
    assert (plan.level, plan.shape, plan.orders) == ("solid", "cyclic", orders)
    body = build_mesh_bodies(asked)["ring"]
    cost = predict_body_cost(body, plan, modes=4)
    assert cost.unknowns == 3 * fields * len(made_mesh(body).points)


class _Node:
    name, position_m = "bore", np.array([0.0, 0.0, 0.25])


class _Element:
    interfaces = (_Node(),)


def test_interfaces_are_told_of_the_whole(folder):
    body = build_mesh_bodies(scene(folder))["ring"]
    (told,) = interfaces_document(_Element(), body, made_mesh(body))
    area = 24 * 0.8 * np.sin(np.pi / 24.0) * 0.5
    assert told["area_m2"] == pytest.approx(area, rel=1e-12)
    assert told["mean_position_m"] == pytest.approx([0.0, 0.0, 0.25], abs=1e-12)


@pytest.mark.verify
def test_step_of_the_whole(folder):
    volume = paddles(folder / "paddles.step", 12, sectors=12)
    asked = scene(
        folder,
        file="paddles.step",
        length_unit="mm",
        size_m=0.02,
        smallest_m=0.004,
        interfaces=[{"name": "bore", "box_m": [[-0.2, -0.2, -0.1], [0.2, 0.2, 0.1]]}],
    )
    body = build_mesh_bodies(asked)["ring"]
    assert body.volume_m3 == pytest.approx(volume, rel=1e-6)
    assert body.radius_m == pytest.approx(np.hypot(0.15, 0.01), rel=1e-6)
    told = described(body, made_mesh(body))
    assert told.mass.mass_kg == pytest.approx(
        volume * MATERIALS["steel"].density_kg_per_m3, rel=1e-3
    )
