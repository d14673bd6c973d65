"""Bearings in files of ROSS 2 and 3."""

from __future__ import annotations

import json

import numpy as np
import pytest

from solidwhirl.bearing_tables import TableFileError, over, read_table, read_tables

# As ROSS 2.3 writes it, shortened; a tag of a rotor's element holds a space.
TWO = """ross_version = "2.3.0"
[parameters]
min_w = 1.0

["ShaftElement_Shaft 0"]
L = 0.1

["BearingElement_Bearing 0"]
cxx = [ 102506.0, 127450.0,]
cyy = [ 102506.0, 127450.0,]
frequency = [ 314.1592653591, 418.8790204788,]
kxx = [ 13798100.0, 29951900.0,]
kxy = [ 1.0, 2.0,]
kyy = [ 13798100.0, 29951900.0,]
kzz = [ 0, 0,]
mxx = [ 1.0, 2.0,]
n = 7
tag = "Bearing 0"

["SqueezeFilmDamper_damper"]
cxx = [ 1.0, 2.0,]
kxx = [ 0.0, 0.0,]
czz = [ 1.0, 2.0,]
frequency = [ 10.0, 20.0,]

["SealElement_Seal 2"]
cxx = [ 3.0,]
kxx = [ 4.0,]
n = 1
"""


def test_version_2(tmp_path):
    path = tmp_path / "rotor.toml"
    path.write_text(TWO)
    found = read_tables(path)
    assert list(found) == ["Bearing 0", "damper", "Seal 2"]
    bearing = read_table(path, "Bearing 0")
    assert bearing.source == "rotor.toml: Bearing 0"
    assert bearing.frequencies_rad_s is None
    np.testing.assert_array_equal(bearing.speeds_rad_s, [314.1592653591, 418.8790204788])
    np.testing.assert_array_equal(
        bearing.stiffness_n_per_m[0, 1, 0], [[29951900.0, 2.0], [0.0, 29951900.0]]
    )
    np.testing.assert_array_equal(bearing.mass_kg[0, 1, 0], np.diag([2.0, 2.0]))
    assert bearing.notes[0].startswith("ROSS 2 looks up the axis it calls frequency at the speed")
    np.testing.assert_array_equal(
        over(bearing, "frequency").frequencies_rad_s, bearing.speeds_rad_s
    )
    # a damper's frequency is that of the motion
    assert found["damper"].speeds_rad_s is None
    assert found["damper"].notes == (
        "coefficients along z are left out; a law of a scene acts on ux and uy",
    )
    assert found["Seal 2"].stiffness_n_per_m.shape == (1, 1, 1, 2, 2)
    with pytest.raises(TableFileError, match="tag: missing; the file has Bearing 0, damper, Seal"):
        read_table(path)
    with pytest.raises(TableFileError, match="no 'Seal 1'; did you mean 'Seal 2'"):
        read_table(path, "Seal 1")


def test_version_3(tmp_path):
    path = tmp_path / "elements.json"
    both = {"kxx": [[1, 2, 3], [4, 5, 6]], "cxx": 7.0, "speed": [10, 20], "frequency": [1, 2, 3]}
    alone = {"kxx": [1, 2, 3], "cxx": [1, 2, 3], "speed": None, "frequency": [1, 2, 3]}
    path.write_text(json.dumps({"SealElement_both": both, "SealElement_alone": alone}))
    table = read_table(path, "both")
    np.testing.assert_array_equal(table.speeds_rad_s, [10, 20])
    np.testing.assert_array_equal(table.stiffness_n_per_m[0, :, :, 1, 1], both["kxx"])
    assert (table.damping_n_s_per_m[..., 0, 0] == 7.0).all()
    assert read_table(path, "alone").speeds_rad_s is None


@pytest.mark.parametrize(
    ("element", "said"),
    [
        ({"frequency": [1, 2], "kxx": [1, 2, 3]}, r"b: kxx has shape \(3,\), the axes 2 of speed"),
        ({"frequency": [2, 1], "kxx": [1, 2]}, "b: speed must be a rising list"),
        ({"kxx": [1, "a"]}, "b: kxx is no list of numbers"),
        ({"kxx": None}, "has no bearing of ROSS"),
        ({"kxx": [float("nan")]}, "b: kxx has entries that are no finite"),
    ],
)
def test_refusals(tmp_path, element, said):
    path = tmp_path / "bad.json"
    path.write_text(json.dumps({"BearingElement_b": {"cxx": 1.0, **element}}))
    with pytest.raises(TableFileError, match=said):
        read_table(path)


@pytest.mark.parametrize("text", ["[", "[1]", "{}"])
def test_files_without_elements(tmp_path, text):
    path = tmp_path / "bad.json"
    path.write_text(text)
    with pytest.raises(TableFileError, match=r"bad.json: (is not valid JSON|holds no|has no bear)"):
        read_table(path)
