"""A scene that is followed: edits, errors, sliders, numbers that are written, saved runs."""

from __future__ import annotations

import json
import sys
import threading
import time
import tomllib
from pathlib import Path

import meshio
import numpy as np
import pytest
from watched_scene import SCENE, Told

from solidwhirl.core.errors import SceneError, UserError
from solidwhirl.output.documents import write_results
from solidwhirl.pipeline.run import run_scene
from solidwhirl.reduced_scene import reduce_scene
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.scene_reading.reader import parse_scene, read_scene, with_model
from solidwhirl.watch import scene_file
from solidwhirl.watch.diagram import diagram_of, quick_diagram
from solidwhirl.watch.saved_run import read_run
from solidwhirl.watch.session import Session

sys.path.insert(0, str(Path(__file__).parents[2] / "meshing"))

from mesh_makers import brick

# A flat bar that turns.
BAR = """\
name = "bar"
model = { estimates = "off", modes = 2 }
speeds = { to_rpm = 3000, count = 3 }
campbell = { branches = 4 }

[mesh_bodies.bar]
file = "bar.inp"
length_unit = "m"
material = "steel"
interfaces = [
    { name = "left", group = "left", coupling = "rigid" },
    { name = "right", group = "right", coupling = "rigid" },
]

[[bearings]]
name = "left"
first = "bar.left"
stiffness_n_per_m = 2e7
axial_stiffness_n_per_m = 1e7

[[bearings]]
name = "right"
first = "bar.right"
stiffness_n_per_m = 2e7
"""
STIFFNESS = "bearings.1.stiffness_n_per_m"


def _save(path, text):
    """As editors do: a new file takes the place of the old one."""
    beside = path.with_suffix(".new")
    beside.write_text(text, encoding="utf-8")
    beside.replace(path)


def _speeds(scene, **bearing):
    found = reduce_scene(scene).with_(**bearing).critical_speeds()
    return [f"{c.critical.speed_rad_s * RPM_PER_RAD_S:.1f}" for c in found]


def _whole(message):
    return message["stage"] == "whole"


def test_a_quick_diagram_has_the_critical_speeds_of_the_whole(scene_path):
    reduced = reduce_scene(read_scene(scene_path))
    quick, whole = quick_diagram(reduced), diagram_of(reduced)
    assert len(quick.campbell.speeds_rad_s) < len(whole.campbell.speeds_rad_s) == 21
    first, last = ([c.critical.speed_rad_s for c in d.critical_speeds] for d in (quick, whole))
    assert first == last and len(first) > 1
    assert quick.campbell.frequency_hz[:, -1] == pytest.approx(whole.campbell.frequency_hz[:, -1])


def test_edits_are_followed_and_errors_told_at_their_line(watched, scene_path):
    _, told = watched(scene_path)
    first = told.wait("picture", _whole)
    for speed in _speeds(read_scene(scene_path)):
        assert speed in first["critical_speeds"]
    assert "above rotor" in first["critical_speeds"] or "inside" in first["critical_speeds"]
    assert first["verdict"][0]["good"] is True

    _save(scene_path, SCENE.replace("count = 21", 'count = "many"'))
    (problem,) = told.wait("problems", lambda m: m["problems"])["problems"]
    assert problem["place"] == "7:1" and problem["source"] == 'count = "many"'
    assert problem["text"].startswith("speeds.count: ")

    _save(scene_path, SCENE.replace("1e7\n", "= 1e7\n"))
    (problem,) = told.wait("problems", lambda m: m["problems"])["problems"]
    assert problem["line"] == "30" and "is not valid TOML" in problem["text"]

    softer = SCENE.replace("mass_kg = 8.0", "mass_kg = 9.0")
    _save(scene_path, softer)
    assert told.wait("problems")["problems"] == []
    found = told.wait("picture", _whole)["critical_speeds"]
    for speed in _speeds(parse_scene(tomllib.loads(softer))):
        assert speed in found


def test_a_table_of_a_bearing_in_a_file_of_its_own_is_followed(watched, scene_path):
    table = scene_path.with_name("maker.csv")
    head = "speed_rpm,kxx_n_per_m,kyy_n_per_m,cxx_n_s_per_m,cyy_n_s_per_m\n"
    _save(table, head + "0,1e7,1e7,500,500\n30000,2e7,2e7,500,500\n")
    text = SCENE.replace('"rotor.b"\nstiffness_n_per_m = 1e7', '"rotor.b"\nspeed_law = "maker"')
    _save(scene_path, text + '\n[speed_laws.maker]\nkind = "file"\nfile = "maker.csv"\n')
    _, told = watched(scene_path)
    first = told.wait("picture", _whole)["critical_speeds"]

    _save(table, head + "0,1e7\n")
    (problem,) = told.wait("problems", lambda m: m["problems"])["problems"]
    assert problem["text"].startswith("speed_laws.maker.file: ")

    _save(table, head + "0,3e6,3e6,500,500\n30000,4e6,4e6,500,500\n")
    assert told.wait("problems")["problems"] == []
    found = told.wait("picture", _whole)["critical_speeds"]
    assert found != first
    for speed in _speeds(read_scene(scene_path)):
        assert speed in found


def test_a_file_that_is_gone_is_told_and_taken_up_again(watched, scene_path):
    _, told = watched(scene_path)
    told.wait("picture", _whole)
    scene_path.unlink()
    (problem,) = told.wait("problems", lambda m: m["problems"])["problems"]
    assert "can not be read: No such file" in problem["text"]
    _save(scene_path, SCENE)
    assert told.wait("problems")["problems"] == []
    told.wait("picture", _whole)


def test_sliders_move_the_supports_and_are_written_with_all_else_kept(
    watched, scene_path, monkeypatch
):
    # pictures stay quick on a machine that does other things
    monkeypatch.setattr("solidwhirl.watch.session._SLOW_S", np.inf)
    session, told = watched(scene_path)
    told.wait("picture", _whole)
    session.move({"nonsense": 3.0, STIFFNESS: float("nan")})
    assert told.wait("picture")["positions"] == {}
    for k in range(20):
        session.move({STIFFNESS: 1e7 - k})
    session.move({STIFFNESS: 4e6, "operating.0.to_rpm": 9600.0})
    wanted = {STIFFNESS: 4e6, "operating.0.to_rpm": 9600.0}
    moving = told.wait("picture", lambda m: m["positions"] == wanted)
    assert moving["stage"] == "moving"
    whole = told.wait("picture", lambda m: m["positions"] == wanted and _whole(m))
    for speed in _speeds(read_scene(scene_path), b=4e6):
        assert speed in moving["critical_speeds"] and speed in whole["critical_speeds"]

    session.write("")
    assert told.wait("written") == {
        "kind": "written", "done": True, "text": f"2 numbers written to {scene_path}"
    }  # fmt: skip
    wanted = SCENE.replace(
        '"rotor.b"\nstiffness_n_per_m = 1e7', '"rotor.b"\nstiffness_n_per_m = 4e6'
    )
    assert scene_path.read_text(encoding="utf-8") == wanted.replace("9500", "9600")
    # the watcher takes it for what the file says now
    scene = told.wait("scene")
    assert scene["positions"] == {}
    assert {s["name"]: s["value"] for s in scene["sliders"]}[STIFFNESS] == 4e6
    assert _speeds(read_scene(scene_path))[0] in told.wait("picture", _whole)["critical_speeds"]
    session.write("")
    assert told.wait("written")["text"] == "no slider has moved; nothing to write"


def test_nothing_is_written_over_what_changed_meanwhile(watched, scene_path):
    session, told = watched(scene_path)
    told.wait("picture", _whole)
    broken = SCENE.replace("count = 21", "count = 0")
    _save(scene_path, broken)
    told.wait("problems", lambda m: m["problems"])
    session.move({STIFFNESS: 4e6})
    session.write("")
    found = told.wait("written")
    assert not found["done"] and "has changed meanwhile; nothing was written" in found["text"]
    assert scene_path.read_text(encoding="utf-8") == broken


def test_a_link_and_the_permissions_of_a_file_stay(watched, scene_path, tmp_path):
    link = tmp_path / "link.toml"
    link.symlink_to(scene_path)
    scene_path.chmod(0o640)
    session, told = watched(link)
    told.wait("picture", _whole)
    session.move({STIFFNESS: 4e6})
    session.write("")
    assert told.wait("written")["done"]
    assert link.is_symlink() and "4e6" in scene_path.read_text(encoding="utf-8")
    assert scene_path.stat().st_mode & 0o777 == 0o640


def test_a_file_that_may_not_be_written_or_has_more_names_keeps_that(watched, scene_path, tmp_path):
    second = tmp_path / "second.toml"
    second.hardlink_to(scene_path)
    session, told = watched(scene_path)
    told.wait("picture", _whole)
    session.move({STIFFNESS: 4e6})
    scene_path.chmod(0o440)
    session.write("")
    assert "is read-only; nothing was written" in told.wait("written")["text"]
    scene_path.chmod(0o640)
    session.write("")
    assert told.wait("written")["done"]
    assert second.samefile(scene_path) and "4e6" in second.read_text(encoding="utf-8")


@pytest.mark.parametrize("in_place", [True, False])
@pytest.mark.parametrize("size", [0, 1 << 20])
def test_no_edit_is_lost_while_the_file_is_written(tmp_path, in_place, size):
    """250 saves at random moments around a write, in place or by a file moved there.

    Whatever comes first, the edit stands in the end.
    """
    path, rest = tmp_path / "rotor.toml", b"#" * size
    before, after, edit = (word + rest for word in (b"before\n", b"written\n", b"edit\n"))
    path.write_bytes(before)
    assert scene_file._rewritten(path, before, after) and path.read_bytes() == after
    assert not scene_file._rewritten(path, before, edit) and path.read_bytes() == after
    random, losses = np.random.default_rng(1), 0
    for _ in range(250):
        path.write_bytes(before)
        delay, other = random.uniform(0.0, 1.5e-3), tmp_path / "edited"

        def save(delay=delay, other=other):
            time.sleep(delay)
            if in_place:
                path.write_bytes(edit)
            else:
                other.write_bytes(edit)
                other.replace(path)

        editor = threading.Thread(target=save)
        editor.start()
        time.sleep(5e-4)
        try:
            scene_file._rewritten(path, before, after)
        except UserError as error:
            assert "is open in another program" in str(error)
        editor.join()
        losses += path.read_bytes() != edit
    assert losses == 0


def test_positions_that_can_not_be_are_told_and_the_next_are_shown(watched, scene_path):
    session, told = watched(scene_path)
    told.wait("picture", _whole)
    session.move({"operating.0.to_rpm": 100.0})
    (problem,) = told.wait("refused", lambda m: m["problems"])["problems"]
    assert "to_rpm = 100 is below from_rpm" in problem["text"] and problem["line"] == "32"
    session.move({})
    assert told.wait("refused")["problems"] == []


def test_pictures_that_take_long_follow_when_sliders_rest(watched, scene_path, monkeypatch):
    monkeypatch.setattr("solidwhirl.watch.session._SLOW_S", 0.0)
    session, told = watched(scene_path)
    told.wait("picture", _whole)
    session.move({STIFFNESS: 4e6})
    assert told.wait("picture")["stage"] == "waiting"
    assert told.wait("picture")["stage"] == "whole"


@pytest.mark.solver
def test_beams_come_before_the_bodies_of_the_scene_then_error_bands(watched, tmp_path, root):
    path = tmp_path / "ferraris.toml"
    text = (root / "scenes" / "ferraris.toml").read_text(encoding="utf-8")
    assert 'level = "solid"' in text
    path.write_text(text.replace('level = "solid"', 'level = "harmonic"'), "utf-8")
    _, told = watched(path)
    assert told.wait("picture")["preliminary"]
    found = told.wait("picture", lambda m: not m["preliminary"])
    assert found["stage"] == "waiting" and "error" not in found["critical_speeds"]
    assert "estimated error" in told.wait("picture", _whole)["critical_speeds"]
    assert "analyses (unbalance_response, level_comparison, recovery)" in " ".join(
        told.last("scene")["remarks"]
    )
    # another support needs no beams
    _save(path, path.read_text().replace("[8e6, 0.0]", "[7e6, 0.0]"))
    assert not told.wait("picture")["preliminary"]


# -- saved runs -----------------------------------------------------------------------------------


@pytest.fixture
def run_folder(scene_path, tmp_path):
    """A run with an option of the command line, which its scene has then."""
    results = run_scene(with_model(read_scene(scene_path), level=None, accuracy=0.01))
    return write_results(results, tmp_path / "out", pictures=False)


def test_a_saved_run_moves_its_bodies_and_writes_a_new_scene(
    run_folder, scene_path, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    told = Told()
    session = Session(read_run(run_folder), told)
    session.start()
    assert told.wait("source")["asks_name"]
    scene = told.wait("scene")
    assert [s["label"] for s in scene["sliders"]][:3] == ["stiffness xx", "stiffness yy", "damping"]
    assert "no error bands" in scene["remarks"][0]
    first = told.wait("picture", _whole)["critical_speeds"]
    for speed in _speeds(read_scene(scene_path)):
        assert speed in first
    session.move({STIFFNESS: 4e6})
    moved = told.wait("picture", lambda m: _whole(m) and m["positions"])["critical_speeds"]
    for speed in _speeds(read_scene(scene_path), b=4e6):
        assert speed in moved
    for name, said in {
        "": "a name that ends with .toml", "a/b.toml": "without a folder",
        "..": "a name that ends", "rotor.toml": "is there already; choose another name",
    }.items():  # fmt: skip
        session.write(name)
        found = told.wait("written")
        assert not found["done"] and said in found["text"]
    session.write("softer.toml")
    assert told.wait("written")["done"]
    written = read_scene(tmp_path / "softer.toml")
    text = SCENE.replace('"rotor.b"\nstiffness_n_per_m = 1e7', '"rotor.b"\nstiffness_n_per_m = 4e6')
    wanted = with_model(parse_scene(tomllib.loads(text)), level=None, accuracy=0.01)
    assert written.model_dump() == wanted.model_dump()
    assert session.end()


def test_folders_that_lack_what_is_needed_are_refused(run_folder, tmp_path):
    with pytest.raises(UserError, match=r"scene.json: no such file; run the scene again"):
        read_run(tmp_path)
    scene = json.loads((run_folder / "scene.json").read_text())
    (run_folder / "bodies" / "rotor.h5").rename(run_folder / "body")
    with pytest.raises(UserError, match=r"rotor.h5: is missing; run the scene again"):
        read_run(run_folder)
    scene["bearings"][0]["stiffness_n_per_m"] = 3.0
    (run_folder / "scene.json").write_text(json.dumps(scene))
    with pytest.raises(SceneError, match=r"scene.json is not the scene of results.json"):
        read_run(run_folder)
    for text, said in (
        ("[]", "is no table"),
        ("{", "is not valid JSON"),
        ("[" * 100_000, "nested too deeply"),
        ('{"x": 1' + "0" * 400 + "}", "a number of 401 digits"),
    ):
        (run_folder / "scene.json").write_text(text)
        with pytest.raises(UserError, match=said):
            read_run(run_folder)


@pytest.mark.solver
def test_an_asymmetric_body_is_shown_when_sliders_rest(watched, tmp_path):
    """Its diagrams in two frames take longer, so that none is made while sliders move."""
    points, cells = brick((0.03, 0.02, 0.4), (2, 2, 6), (-0.015, -0.01, 0.0))
    ends = {"left": points[:, 2] < 1e-9, "right": points[:, 2] > 0.4 - 1e-9}
    sets = {name: np.flatnonzero(where) for name, where in ends.items()}
    meshio.Mesh(points, [("hexahedron", cells)], point_sets=sets).write(tmp_path / "bar.inp")
    path = tmp_path / "bar.toml"
    path.write_text(BAR, encoding="utf-8")
    session, told = watched(path)
    assert told.wait("picture")["stage"] == "whole"
    assert "is asymmetric" in told.last("scene")["remarks"][0]
    session.move({"bearings.0.stiffness_n_per_m": 1e7})
    found = told.wait("picture")
    assert found["stage"] == "whole" and found["positions"] and found["chart"] is not None
