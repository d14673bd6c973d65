"""A wrong scene file ends in one message with file, key, finding and what is allowed."""

from __future__ import annotations

import math
import re

import pytest
from typer.testing import CliRunner

from solidwhirl.cli import app
from solidwhirl.errors import SceneError
from solidwhirl.scene_file import parse_scene, read_scene, scene_hash

# what is replaced by what, and what the message must say
WRONG = {
    "missing key": (
        "start_m = 0.0, end_m = 0.4,",
        "end_m = 0.4,",
        ["bodies.inner.sections[0].start_m: missing"],
    ),
    "unknown key": (
        "outer_radius_m = 0.02 }",
        "outer_radius_m = 0.02, outer_raduis_m = 0.03 }",
        ["bodies.inner.sections[0].outer_raduis_m: unknown key", "did you mean 'outer_radius_m'?"],
    ),
    "unknown table": (
        "[campbell]",
        "[campbel]",
        ["campbel: unknown key", "did you mean 'campbell'?"],
    ),
    "nothing like it": (
        "branches = 6",
        "colour = 6",
        ["campbell.colour: unknown key", "allowed are branches, frequency_max_hz"],
    ),
    "wrong unit": (
        "stiffness_n_per_m = 1e10",
        "stiffness_n_per_mm = 1e7",
        ["bearings[0].stiffness_n_per_mm: unknown key", "did you mean 'stiffness_n_per_m'?"],
    ),
    "text for a number": (
        "end_m = 0.4,",
        'end_m = "0.4",',
        ["bodies.inner.sections[0].end_m", "valid number", "found '0.4'"],
    ),
    "true for a number": (
        "end_m = 0.4,",
        "end_m = true,",
        ["bodies.inner.sections[0].end_m", "valid number", "found True"],
    ),
    "fraction for a count": (
        "count = 21",
        "count = 20.5",
        ["speeds.count", "valid integer", "found 20.5"],
    ),
    "text for a list": (
        "stiffness_n_per_m = [8e6, 0.0]",
        'stiffness_n_per_m = "soft"',
        ["bearings[3].stiffness_n_per_m", "valid array", "found 'soft'"],
    ),
    "three values for a matrix": (
        "[8e6, 0.0]",
        "[8e6, 0.0, 0.0]",
        ["bearings[3].stiffness_n_per_m", "at most 2 items", "found [8000000.0, 0.0, 0.0]"],
    ),
    "negative radius": (
        "outer_radius_m = 0.02 }",
        "outer_radius_m = -0.02 }",
        ["bodies.inner.sections[0].outer_radius_m", "greater than or equal to 0", "found -0.02"],
    ),
    "negative speed": (
        "to_rpm = 20000",
        "to_rpm = -20000",
        ["speeds.to_rpm", "greater than or equal to 0", "found -20000"],
    ),
    "a list for a number": (
        "end_m = 0.4,",
        "end_m = [0.4, 0.5],",
        ["sections[0].end_m", "one number is allowed here, found [0.4, 0.5]"],
    ),
    "nan": ("end_m = 0.4,", "end_m = nan,", ["sections[0].end_m", "finite number", "found nan"]),
    "inf": ("end_m = 0.4,", "end_m = inf,", ["sections[0].end_m", "finite number", "found inf"]),
    "too large": (
        "1e10",
        "1e300",
        [
            "bearings[0].stiffness_n_per_m",
            "less than or equal to 1000000000000000000000000000000",
            "found 1e+300",
        ],
    ),
    "kind of interface": (
        'kind = "section", at_m = 0.0',
        'kind = "ring", at_m = 0.0',
        ["interfaces[0].kind", "'section', 'outer', 'inner', 'face' or 'slab'", "found 'ring'"],
    ),
    "place of interface": (
        'kind = "section", at_m = 0.0',
        'kind = "section", start_m = 0.0, end_m = 0.1',
        ["interfaces[0]", "needs at_m, not start_m and end_m"],
    ),
    "unknown material": (
        'material = "steel"',
        'material = "steal"',
        ["bodies.inner", "'shaft'", "unknown material 'steal'", "nickel_alloy, steel, titanium"],
    ),
    "no material": (
        'material = "steel"',
        "",
        ["bodies.inner", "'shaft'", "no material"],
    ),
    "crossing radii": (
        "inner_radius_m = 0.02,",
        "inner_radius_m = 0.2,",
        ["bodies.inner", "'disk'", "crossing radii", "0.2 m exceeds the outer radius 0.15 m"],
    ),
    "negative width": (
        "end_m = 0.14833333333333333",
        "end_m = 0.1",
        ["bodies.inner", "'disk'", "negative width", "ends at z = 0.1 m"],
    ),
    "gap": (
        "inner_radius_m = 0.02,",
        "inner_radius_m = 0.021,",
        ["bodies.inner", "2 pieces", "gap between 'shaft' and 'disk'", "0.001 m wide"],
    ),
    "overlap": (
        "inner_radius_m = 0.02,",
        "inner_radius_m = 0.019,",
        ["bodies.inner", "'shaft' and 'disk' overlap by 3e-05 m^2"],  # 1 mm x 30 mm
    ),
    "interface outside": (
        'name = "B", kind = "section", at_m = 0.4',
        'name = "B", kind = "section", at_m = 0.5',
        ["bodies.inner", "interface 'B'", "z = 0.5 m lies outside", "reaches from z = 0 m to 0.4"],
    ),
    "two interfaces of a name": (
        '{ name = "A",',
        '{ name = "C", kind = "section", at_m = 0.1 },\n{ name = "A",',
        ["bodies.inner", "two interfaces are called 'C'"],
    ),
    "two interfaces of a surface": (
        '{ name = "A",',
        '{ name = "twin", kind = "section", at_m = 0.4 },\n{ name = "A",',
        ["bodies.inner", "interfaces 'twin' and 'B' are the same surface", "keep one"],
    ),
    "interface inside a rigid one": (
        '{ name = "A",',
        '{ name = "held", kind = "slab", start_m = 0.2, end_m = 0.3, coupling = "rigid" },\n'
        '{ name = "A",',
        ["bodies.inner", "interface 'C' lies inside the rigid interface 'held'"],
    ),
    "more tetrahedra than memory": (
        "[model]",
        '[model]\nlevel = "solid"\ncorner_size_m = 1e-6',
        ["bodies.inner: level solid", "GiB", "What fits: level = 'harmonic'"],
    ),
    "unknown interface": (
        'first = "inner.B"',
        'first = "inner.X"',
        [
            "bearings[1].first: no interface 'inner.X'",
            "allowed are inner.A, inner.disk, inner.C, inner.B",
        ],
    ),
    "unknown second end": (
        'second = "outer.C"',
        'second = "outer.B"',
        ["bearings[2].second: no interface 'outer.B'", "did you mean", "outer.D, ground"],
    ),
    "ground as first end": (
        'first = "inner.B"',
        'first = "ground"',
        ["bearings[1].first: no interface 'ground'", "bearings[1].second", "ends must differ"],
    ),
    "same ends": (
        'second = "outer.C"',
        'second = "inner.C"',
        ["bearings[2].second: 'inner.C' is the first end too"],
    ),
    "two bearings of a name": (
        'name = "kxx"',
        'name = "A"',
        ["bearings[3].name: 'A' is the name of bearings[0] too"],
    ),
    "rigid and elastic": (
        "stiffness_n_per_m = [8e6, 0.0]",
        'stiffness_n_per_m = [8e6, 0.0]\nrigid = ["ux", "uy"]',
        ["bearings[3].rigid: ux is rigid and stiffness_n_per_m acts on it"],
    ),
    "softening alone": (
        "[campbell]",
        '[effects]\nspin_softening = "off"\n[campbell]',
        ["effects: stress_stiffening is 'auto' and spin_softening 'off'", "cancel", "neither"],
    ),
    "stiffening alone": (
        "[campbell]",
        '[effects]\nstress_stiffening = false\nspin_softening = "on"\n[campbell]',
        ["effects: stress_stiffening is 'off' and spin_softening 'on'", "cancel", "neither"],
    ),
    "speeds reversed": (
        "from_rpm = 0",
        "from_rpm = 30000",
        ["speeds: to_rpm = 20000 is below from_rpm = 30000"],
    ),
    "one speed of a range": ("count = 21", "count = 1", ["speeds: count = 1 allows one speed"]),
    "list and range": (
        "count = 21",
        "list_rpm = [0, 1000]",
        ["speeds: list_rpm stands alone, found from_rpm, to_rpm beside it"],
    ),
    "list falls": (
        "from_rpm = 0\nto_rpm = 20000\ncount = 21",
        "list_rpm = [1000, 0]",
        ["speeds: list_rpm must be increasing"],
    ),
    "branches and limit": (
        "branches = 6",
        "branches = 6\nfrequency_max_hz = 500",
        ["campbell: give branches or frequency_max_hz, not both"],
    ),
    "sizes reversed": (
        "[model]",
        "[model]\nsize_m = 1e-3\ncorner_size_m = 1e-2",
        ["model: corner_size_m = 0.01 is above size_m = 0.001"],
    ),
    "order of tetrahedra": (
        "[model]",
        '[model]\nlevel = "solid"\norder = 4',
        ["model: order = 4 with level 'solid'", "order 2 only"],
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_entry_is_refused_before_meshing(invoke, ferraris, case, changed, refusal):
    old, new, said = WRONG[case]
    done, written = invoke(changed(ferraris, old, new))
    message = refusal(done, "bad.toml")
    for text in said:
        assert text in message, (text, message)
    assert "mesh " not in message, "found out only while meshing"
    assert not written


def test_right_file_is_accepted(ferraris, tmp_path):
    """What the cases above start from has no fault of its own."""
    path = tmp_path / "good.toml"
    path.write_text(ferraris, encoding="utf-8")
    done = CliRunner().invoke(app, ["plan", str(path)])
    assert done.exit_code == 0, done.stderr
    assert "stress_stiffening" in done.stdout


def test_all_problems_at_once(invoke, ferraris, changed, refusal):
    text = changed(ferraris, '"inner.A"', '"A"')
    text = changed(text, '"inner.B"', '"inner.X"')
    text = changed(text, '"outer.D"', '"outr.D"')
    done, _ = invoke(text)
    lines = refusal(done, "bad.toml").strip().splitlines()
    keys = [re.search(r"bad\.toml:\d+:\d+: (\S+):", line).group(1) for line in lines]
    assert keys == ["bearings[0].first", "bearings[1].first", "bearings[4].first"]
    assert "did you mean 'outer.D'?" in lines[2]
    text = changed(changed(ferraris, "count = 21", "count = 0"), "[model]", "[model]\norder = 9")
    lines = refusal(invoke(text)[0], "bad.toml").strip().splitlines()
    keys = [re.search(r"bad\.toml:\d+:\d+: (\S+):", line).group(1) for line in lines]
    assert keys == ["speeds.count", "model.order"]


def test_bearing_without_any_interface_to_hold(small_scene):
    data = small_scene()
    data["bodies"]["rotor"]["interfaces"] = []
    with pytest.raises(SceneError, match=r"bearings\[0\].first.*no body has an interface"):
        parse_scene(data)


@pytest.mark.parametrize(
    "bearing",
    [
        {"stiffness_n_per_m": [[1e7, 1e5], [-1e5, 1e7]], "rigid": ["ux"]},  # row and column
        {"stiffness_n_per_m": [[0.0, 1e5], [0.0, 1e7]], "rigid": ["ux"]},  # row only
        {"stiffness_n_per_m": [[0.0, 0.0], [1e5, 1e7]], "rigid": ["ux"]},  # column only
        {"stiffness_n_per_m": 0.0, "damping_n_s_per_m": 10.0, "rigid": ["uy"]},
        {"axial_stiffness_n_per_m": 1.0, "rigid": ["uz"]},
        {"tilt_damping_n_m_s_per_rad": [0.0, 1.0], "rigid": ["ry"]},
        {"torsion_stiffness_n_m_per_rad": 1.0, "rigid": ["rz"]},
    ],
)
def test_rigid_motion_that_a_spring_acts_on(small_scene, bearing):
    with pytest.raises(SceneError, match=rf"bearings\[0\].rigid: {bearing['rigid'][0]} is rigid"):
        parse_scene(small_scene(bearing=bearing))


@pytest.mark.parametrize(
    "bearing",
    [
        {"stiffness_n_per_m": [0.0, 1e7], "rigid": ["ux"]},
        {"tilt_stiffness_n_m_per_rad": [0.0, 1e3], "rigid": ["rx", "uz", "rz"]},
    ],
)
def test_rigid_motion_beside_the_springs(small_scene, bearing):
    assert parse_scene(small_scene(bearing=bearing)).bearings[0].rigid == tuple(bearing["rigid"])


@pytest.mark.solver
def test_speed_beyond_linear_prestress(invoke, ferraris, changed, refusal):
    """500 000 rpm, far beyond linear theory: refused with the speed that is allowed."""
    done, written = invoke(changed(ferraris, "to_rpm = 20000", "to_rpm = 500000"), "--quiet")
    message = refusal(done, "bad.toml")
    found = re.search(r"at 500000 rpm the hoop strain is .* that is to (\d+) rpm", message)
    assert found
    # In the middle of a thin solid disk the hoop strain is (1 - nu)(3 + nu)/8 rho a^2 W^2/E
    # (Timoshenko and Goodier, Theory of Elasticity, section 32). The disk is a fifth as thick as
    # its radius and sits on a shaft, which is worth a few per cent.
    mean = (1.0 - 0.3) * (3.0 + 0.3) / 8.0 * 7800.0 * 0.15**2 / 2e11
    assert float(found.group(1)) == pytest.approx(math.sqrt(0.05 / mean) * 30.0 / math.pi, rel=0.05)
    assert not written


def test_readable_forms_of_the_same(small_scene):
    """One number for both ends and for k·I, a pair for a diagonal, true for on."""
    short = small_scene(effects={"tilt": True, "torsion": False})
    long = small_scene(effects={"tilt": "on", "torsion": "off"})
    for section in long["bodies"]["rotor"]["sections"]:
        section["outer_radius_m"] = [section["outer_radius_m"]] * 2
    long["bearings"][0]["stiffness_n_per_m"] = [10_000_000, 1e7]
    long["bearings"][1]["stiffness_n_per_m"] = [[1e7, 0], [0, 1e7]]
    assert parse_scene(short) == parse_scene(long)
    assert scene_hash(parse_scene(short)) == scene_hash(parse_scene(long))
    other = small_scene(bearing={"stiffness_n_per_m": 1.000001e7})
    assert scene_hash(parse_scene(other)) != scene_hash(parse_scene(short))


def test_path_is_part_of_the_error(tmp_path):
    path = tmp_path / "x.toml"
    path.write_text("colour = 1", encoding="utf-8")
    with pytest.raises(SceneError) as caught:
        read_scene(path)
    assert caught.value.path == str(path)
    assert len(caught.value.problems) == 2  # name is missing, colour is unknown
    assert str(caught.value).count(str(path)) == 2
