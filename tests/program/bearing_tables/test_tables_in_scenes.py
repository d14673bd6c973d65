"""Laws from files in scenes: the same as the table written out, in other axes, at a load."""

from __future__ import annotations

import json

import numpy as np
import pytest
from engine_parts import RIGID

from solidwhirl.bearing_tables import (
    TableFileError,
    as_table_law,
    at_load,
    over,
    read_table,
    turned,
)
from solidwhirl.scene_reading.reader import SceneError, parse_scene, scene_hash

HEAD = "speed_rpm,kxx_n_per_m,kxy_n_per_m,kyx_n_per_m,kyy_n_per_m,cxx_n_s_per_m\n"
PADS = HEAD + "9000,1e8,2e7,-3e7,4e8,5e5\n3000,2e8,3e7,-4e7,5e8,6e5\n"
LAW = {
    "kind": "table",
    "speed_rpm": [3000, 9000],
    "stiffness_n_per_m": [[[2e8, 3e7], [-4e7, 5e8]], [[1e8, 2e7], [-3e7, 4e8]]],
    "damping_n_s_per_m": [6e5, 5e5],
}


def scene_data(law):
    ends = [{"name": e, "first": f"R.{e}", "speed_law": "pads"} for e in "ab"]
    bodies = {"rigid_bodies": {"R": {**RIGID, "speed_ratio": 1.0}}}
    return {"name": "s", **bodies, "bearings": ends, "speed_laws": {"pads": law}}


def read(folder, text=PADS, name="pads.csv", **keys):
    folder.mkdir(exist_ok=True)
    (folder / name).write_text(text)
    return parse_scene(scene_data({"kind": "file", "file": name, **keys}), folder / "s.toml")


def test_file_is_the_table_it_holds(tmp_path):
    """Same records and hash wherever the file lies; another hash with another number in it."""
    written = parse_scene(scene_data(LAW))
    found = read(tmp_path / "one")
    assert found.speed_laws == written.speed_laws
    assert scene_hash(found) == scene_hash(written) == scene_hash(read(tmp_path / "two"))
    assert scene_hash(read(tmp_path, PADS.replace("4e8", "4.1e8"))) != scene_hash(written)
    assert read(tmp_path, interpolation="linear").speed_laws["pads"].interpolation == "linear"
    assert parse_scene(json.loads(found.model_dump_json())).speed_laws == written.speed_laws


def test_axes_of_the_maker(tmp_path):
    """Vertical x: K'xx = Kyy, K'xy = -Kyx; any angle leaves what the film does to the motion."""
    law = read(tmp_path, turned_deg=90).speed_laws["pads"]
    assert law.stiffness_n_per_m[0] == ((5e8, 4e7), (-3e7, 2e8))
    table = read_table(tmp_path / "pads.csv")
    for angle in (30.0, -117.0, 180.0):
        way = np.radians(angle)
        turn = np.array([[np.cos(way), -np.sin(way)], [np.sin(way), np.cos(way)]])
        found = turned(table, angle)
        motion = np.array([0.3, -0.7])
        force = table.stiffness_n_per_m[0, 1, 0] @ motion
        np.testing.assert_allclose(
            found.stiffness_n_per_m[0, 1, 0] @ (turn @ motion), turn @ force, rtol=1e-12
        )
        ours = found.stiffness_n_per_m
        skew = ours[..., 0, 1] - ours[..., 1, 0]
        np.testing.assert_allclose(skew, [[[7e7], [5e7]]], rtol=1e-12)


def test_maker_who_looks_from_the_other_end(tmp_path):
    """The film of a shaft that turns from y to x is that of ours with y reversed."""
    law = read(tmp_path, maker_spin="y_to_x").speed_laws["pads"]
    assert law.stiffness_n_per_m[0] == ((2e8, -3e7), (4e7, 5e8))
    # a maker with vertical x and y to the other side: x' = y, y' = x
    law = read(tmp_path, maker_spin="y_to_x", turned_deg=90).speed_laws["pads"]
    assert law.stiffness_n_per_m[0] == ((5e8, -4e7), (3e7, 2e8))


def test_load(tmp_path):
    lines = [f"{f},{s},{f * s}e3,{s}" for f in (100, 300) for s in (1000, 2000)]
    text = "load_n,speed_rpm,kxx_n_per_m,cxx_n_s_per_m\n" + "\n".join(lines)
    law = read(tmp_path, text, load_n=150).speed_laws["pads"]
    assert [m[0][0] for m in law.stiffness_n_per_m] == pytest.approx([1.5e8, 3e8])
    table = read_table(tmp_path / "pads.csv")
    for load, row in ((100.0, 0), (300.0, 1)):
        found = at_load(table, load).stiffness_n_per_m
        np.testing.assert_array_equal(found[0], table.stiffness_n_per_m[row])
    for load, said in (
        (99.9, "found 99.9; the table has 2 loads from 100 to 300 N"),
        (None, "mis"),
    ):
        with pytest.raises(TableFileError, match=f"load_n: {said}"):
            at_load(table, load)


def test_one_axis_of_frequency_is_never_taken_silently(tmp_path):
    text = PADS.replace("speed_rpm", "frequency [rpm]")
    with pytest.raises(
        SceneError, match=r"pads\.file: .*axis: missing; the table is over frequency"
    ):
        read(tmp_path, text)
    assert read(tmp_path, text, axis="speed").speed_laws == parse_scene(scene_data(LAW)).speed_laws
    table = over(read_table(tmp_path / "pads.csv"), "frequency")
    law = as_table_law(table)
    assert law["frequency_hz"] == [50.0, 150.0]
    # the coefficients hold at all speeds
    assert law["speed_rpm"] == [0.0, 9000.0]
    assert law["stiffness_n_per_m"] == [LAW["stiffness_n_per_m"]] * 2


def test_speed_frequency_and_mass(tmp_path):
    lines = [f"{s},{f},{s}e3,{f},2,1,-1,3" for f in (10, 40) for s in (1000, 2000)]
    head = "rpm,Frequency [Hz],kxx_n_per_m,cxx_n_s_per_m,mxx_kg,mxy_kg,myx_kg,myy_kg\n"
    (tmp_path / "seal.csv").write_text(head + "\n".join(lines))
    law = as_table_law(read_table(tmp_path / "seal.csv"))
    assert (law["speed_rpm"], law["frequency_hz"]) == ([1000.0, 2000.0], [10.0, 40.0])
    assert law["added_mass_kg"] == [[[[2.0, 1.0], [-1.0, 3.0]]] * 2] * 2
    assert [[m[0][0] for m in row] for row in law["stiffness_n_per_m"]] == [[1e6] * 2, [2e6] * 2]
    assert [[m[0][0] for m in row] for row in law["damping_n_s_per_m"]] == [[10.0, 40.0]] * 2


@pytest.mark.parametrize(
    ("keys", "text", "said"),
    [
        ({"tag": "b"}, PADS, "pads.csv: tag: no 'b'; allowed are none"),
        ({"load_n": 3.0}, PADS, "pads.csv: load_n: the table has no column of loads"),
        (
            {},
            PADS.split("3000")[0],
            "has no two speeds; a law is over the speed, give one value in",
        ),
        ({}, PADS.replace("3000", "9000.0000000001"), "one speed beside the highest"),
        (
            {"axis": "speed"},
            HEAD.replace("speed_rpm,", "") + "1,2,3,4,5\n",
            "axis: the table is not",
        ),
    ],
)
def test_refusals(tmp_path, keys, text, said):
    with pytest.raises(SceneError) as error:
        read(tmp_path, text, **keys)
    assert "s.toml: speed_laws.pads.file: " in str(error.value)
    assert said in str(error.value)
