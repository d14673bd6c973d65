"""Python use: scenes built in Python, the script in docs, what objects print."""

from __future__ import annotations

import contextlib
import io
import os
import re
import runpy
import tomllib
from pathlib import Path

import numpy as np
import pytest

from solidwhirl.build import beam, bearing, body, cylinder, disk, scene, unbalance, with_changes
from solidwhirl.core.errors import SceneError
from solidwhirl.scene_reading.reader import parse_scene, read_scene, scene_hash

ROOT = Path(__file__).resolve().parents[2]
PAGE, SCRIPT = ROOT / "docs" / "python.md", ROOT / "docs" / "twin_rotor.py"
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)


@pytest.fixture(scope="module")
def twin(tmp_path_factory):
    """Names and output of the script, run once as a reader runs it."""
    here, told = Path.cwd(), io.StringIO()
    os.chdir(tmp_path_factory.mktemp("twin"))
    try:
        with contextlib.redirect_stdout(told):
            names = runpy.run_path(str(SCRIPT))
        names["picture"] = Path("twin_rotor.png").read_bytes()
    finally:
        os.chdir(here)
    return names, told.getvalue()


def small(**changes):
    return scene(
        "small",
        beams={
            "rotor": beam(
                np.linspace(0.0, 0.6, 4),
                0.02,
                {"a": 0.0, "b": 0.6},
                disks=[disk("wheel", mass_kg=12, polar=0.12, diametral=0.065, at_m=0.2)],
            )
        },
        bearings=[bearing(n, f"rotor.{n}", stiffness_n_per_m=5e7) for n in ("a", "b")],
        **changes,
    )


def test_a_built_scene_is_that_of_the_file():
    """All of laval.toml, written in Python: the same content, so the same hash."""
    file = tomllib.loads((ROOT / "scenes" / "laval.toml").read_text(encoding="utf-8"))
    built = scene(
        "laval",
        title=file["title"],
        notes=file["notes"],
        materials=file["materials"],
        bodies={
            "rotor": body(
                cylinder("shaft", 0.0, 1.0, 0.01),
                interfaces={"left": 0.0, "middle": 0.5, "right": 1.0},
                material="light_steel",
                rigid_disks=[
                    disk("disk", mass_kg=5.0, polar=0.05, diametral=0.026, interface="middle")
                ],
            )
        },
        bearings=[bearing(n, f"rotor.{n}", rigid=("ux", "uy")) for n in ("left", "right")],
        speeds_rpm=np.linspace(0, 6000, 13),
        branches=4,
    )
    del file["speeds"]
    file["speeds"] = {"list_rpm": list(np.linspace(0, 6000, 13))}
    assert scene_hash(built) == scene_hash(parse_scene(file))


def test_numbers_of_numpy_are_taken():
    built = small(
        speeds_rpm=np.arange(0, 3000, 1000),
        branches=np.int64(3),
        analyses=[
            {
                "kind": "unbalance_response",
                "unbalances": [unbalance("rotor.a", np.float64(1e-4))],
                "observe": ["rotor.a"],
                "to_rpm": np.float32(100.0),
                "count": np.int64(5),
            }
        ],
    )
    assert built.speeds.list_rpm == (0.0, 1000.0, 2000.0)
    assert built.campbell.branches == 3
    assert built.analyses[0].count == 5
    found = bearing("k", "rotor.a", stiffness_n_per_m=np.array([[1.0, 2.0], [3.0, 4.0]]))
    assert found["stiffness_n_per_m"] == [[1.0, 2.0], [3.0, 4.0]]


def test_faults_are_those_of_a_file_and_all_at_once():
    with pytest.raises(SceneError) as caught:
        scene(
            "wrong",
            beams={"rotor": beam([0.0, 0.6], -0.02, {"a": 0.0}, material="cheese")},
            bearings=[bearing("a", "rotor.a", stifness=1.0)],
        )
    text = str(caught.value)
    assert "beams.rotor.outer_radius_m[0]" in text
    assert "bearings[0].stifness: unknown key; did you mean 'stiffness" in text


def test_changes_make_a_new_scene():
    first = small(speeds_rpm=[0.0, 1000.0])
    changed = with_changes(
        first,
        {
            "bearings.b.stiffness_n_per_m": [1e6, 2e6],
            "beams.rotor.disks.wheel.mass_kg": 14,
            "beams.rotor.interfaces.b": 0.4,
            "model.accuracy": 0.01,  # a table that the scene does not have
        },
    )
    assert changed.bearings[1].stiffness_n_per_m == ((1e6, 0.0), (0.0, 2e6))
    assert changed.beams["rotor"].disks[0].mass_kg == 14
    assert changed.beams["rotor"].interfaces["b"] == 0.4
    assert changed.model.accuracy == 0.01
    assert first.bearings[1].stiffness_n_per_m[0][0] == 5e7
    for found in (first, read_scene(ROOT / "scenes" / "casing.toml")):
        assert scene_hash(with_changes(found, {})) == scene_hash(found)
    # brackets, by name or by the number that messages have, and dots mean the same
    wanted = scene_hash(with_changes(first, {"bearings.b.stiffness_n_per_m": 3e6}))
    for place in ("bearings[b].stiffness_n_per_m", "bearings[1].stiffness_n_per_m"):
        assert scene_hash(with_changes(first, {place: 3e6})) == wanted != scene_hash(first)
    for place, said in {
        "bearings.c.name": r"'bearings\.c\.name': .* has no entry \[c\]; allowed are .*a, b",
        "bearings[c].name": r"has no entry \[c\]; .*allowed are a, b",
        "beams[rotor].material": r"\[rotor\] needs a list",
        "bearings[b.name": "is no place; allowed are keys",
    }.items():
        with pytest.raises(ValueError, match=said):
            with_changes(first, {place: "d"})
    with pytest.raises(SceneError, match=r"beams\.rotor\.mas: unknown key"):
        with_changes(first, {"beams.rotor.mas": 1.0})


def test_a_scene_shows_itself():
    shown = repr(small(speeds_rpm=[0.0, 1000.0], title="A <small> one"))
    assert shown == str(small(speeds_rpm=[0.0, 1000.0], title="A <small> one"))
    assert shown.splitlines() == [
        "Scene 'small': A <small> one",
        "  bodies: rotor (speed ratio 1)",
        "  bearings: a, b",
        "  speeds: 2 from 0 to 1000 rpm",
        "  model: level auto, accuracy 0.001",
    ]
    html = small(title="A <small> one")._repr_html_()
    assert "A &lt;small&gt; one" in html
    assert html.count("<tr>") == html.count("</tr>") == 4
    shown = repr(read_scene(ROOT / "scenes" / "uhbr_engine.toml"))
    assert len(shown.splitlines()) <= 8
    assert len(shown) < 1200


@pytest.mark.solver
def test_the_script_says_what_the_page_shows(twin):
    names, told = twin
    fences = FENCE.findall(PAGE.read_text(encoding="utf-8"))
    assert told in [text for kind, text in fences if kind == "text"]
    script = SCRIPT.read_text(encoding="utf-8")
    cells = [c.strip() + "\n" for c in re.split(r"^# %%.*\n", script, flags=re.MULTILINE)]
    shown = [text for kind, text in fences if kind == "py"]
    assert len(shown) >= 3
    assert not [text for text in shown if text not in cells]
    # single-term Ritz of the source 166.59 and 190.93 Hz; solid disks are stiffer by up to 3 %
    lowest = names["results"].at_rest.frequency_hz[:2]
    np.testing.assert_allclose(lowest, [166.59, 190.93], rtol=0.03)
    assert names["picture"].startswith(b"\x89PNG")
    assert len(names["axes"].lines) > 8


@pytest.mark.solver
def test_the_script_is_the_scene_of_the_repository(twin):
    """Data of scenes/ferraris.toml, where the same numbers are written as decimals."""
    built, file = twin[0]["twin"], read_scene(ROOT / "scenes" / "ferraris.toml")
    for name, other in file.bodies.items():
        for own, theirs in zip(built.bodies[name].sections, other.sections, strict=True):
            for key in ("start_m", "end_m", "inner_radius_m", "outer_radius_m"):
                np.testing.assert_allclose(getattr(own, key), getattr(theirs, key), atol=1e-15)
        assert [i.name for i in built.bodies[name].interfaces] == [i.name for i in other.interfaces]
    by_name = {b.name: b for b in built.bearings}
    assert {b.name: b for b in file.bearings} == by_name


@pytest.mark.solver
def test_results_show_themselves(twin):
    results = twin[0]["results"]
    shown, html = repr(results), results._repr_html_()
    assert "array(" not in shown
    assert len(shown.splitlines()) <= 14
    for found in results.critical_speeds:
        rpm = f"{found.critical.speed_rad_s * 30 / np.pi:.1f}"
        assert rpm in shown
        assert f"<td>{rpm}</td>" in html
    assert f"largest error estimate: {100 * results.estimates.largest:.2g} %" in shown
    for part in (*results.bodies.values(), results.estimates, *results.analyses.values()):
        assert "array(" not in repr(part)
        assert len(repr(part)) < 800
    assert repr(results.estimates).startswith("Estimates: at most")
