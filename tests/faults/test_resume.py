"""Runs that go on from what was kept: the same numbers, and only what changed is done again."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest
from of_the_run import OF_THE_RUN

from solidwhirl.scene_reading.reader import parse_scene

pytestmark = pytest.mark.solver

# What two runs of one scene may differ in.
OWN = OF_THE_RUN | {"scene"}


@pytest.fixture(scope="module")
def data(scene_path):
    """Content of the scene with two bodies."""
    return tomllib.loads(scene_path("two_bodies").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def run(data):
    """Function: run the scene, changed, with a store; its results and notes."""
    from solidwhirl.pipeline.cached_stages import open_store
    from solidwhirl.pipeline.run import run_scene

    def start(folder, opened=open_store, **changes):
        notes = []
        store = opened(folder)
        results = run_scene(parse_scene({**data, **changes}), progress=notes.append, store=store)
        return results, [str(note) for note in notes], store

    return start


@pytest.fixture(scope="module")
def first(run, tmp_path_factory):
    """A first run, and the folder of its stages."""
    folder = tmp_path_factory.mktemp("kept")
    return run(folder)[0], folder


@pytest.fixture
def folder(first, tmp_path):
    """A copy of the stages of the first run."""
    for path in first[1].iterdir():
        (tmp_path / path.name).write_bytes(path.read_bytes())
    return tmp_path


def document(results):
    from solidwhirl.output.documents import results_document

    found = results_document(results)
    return {key: value for key, value in found.items() if key not in OWN}


def computed(results):
    return {name for name, origin in results.stages.items() if origin == "computed"}


def test_store_changes_no_number(first, run, data):
    """With and without a store, to the last bit."""
    from solidwhirl.pipeline.run import run_scene

    results = run_scene(parse_scene(data))
    assert results.stages == {}
    assert document(results) == document(first[0])


def test_second_run_keeps_everything(first, run, folder):
    results, notes, _ = run(folder)
    assert set(first[0].stages.values()) == {"computed"}
    # the refinement tells where its rounds ended: they are not judged again
    rounds = {s for s in first[0].stages if s.startswith("judgement") or s.endswith(" (2)")}
    assert results.stages.keys() == first[0].stages.keys() - rounds
    assert set(results.stages.values()) == {"kept"}
    assert document(results) == document(first[0])
    assert not [n for n in notes if n.startswith(("mesh", "reduce"))]
    for name, body in results.bodies.items():
        before = first[0].bodies[name]
        for key in ("mass", "stiffness", "gyroscopic", "recovery_modes"):
            own, other = getattr(body.element, key), getattr(before.element, key)
            assert own.tobytes() == other.tobytes()
            assert own.strides == other.strides
        assert body.element.provenance == before.element.provenance
        assert body.mesh.points.tobytes() == before.mesh.points.tobytes()


def test_files_of_kept_analyses(first, run, folder, tmp_path):
    """Data files come from the store; a picture is drawn once, and then does too."""
    results, _, _ = run(folder)
    outcome, before = (r.analyses["unbalance_response"] for r in (results, first[0]))
    assert list(outcome.files) == list(before.files)
    model, other = (r.analyses["state_space"] for r in (results, first[0]))
    for name in ("state_space.npz", "state_space.h5", "state_space.mat"):
        model.files[name](tmp_path / "one")
        other.files[name](tmp_path / "two")
        assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()
    count = len(list(folder.glob("*.stage")))
    outcome.files["unbalance_response.png"](tmp_path / "a.png")
    assert len(list(folder.glob("*.stage"))) == count + 1
    again, _, _ = run(folder)
    again.analyses["unbalance_response"].files["unbalance_response.png"](tmp_path / "b.png")
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    assert (tmp_path / "a.png").read_bytes()[:4] == b"\x89PNG"


ENGINE = {"Campbell diagram", "critical speeds", "error estimates"}
BOTH = {"analysis unbalance_response", "analysis state_space"}


def test_changed_bearing_keeps_meshes_and_reductions(first, run, folder, data):
    bearings = [dict(b) for b in data["bearings"]]
    bearings[0]["stiffness_n_per_m"] *= 1.0 + 1e-6
    results, _, _ = run(folder, bearings=bearings)
    again = {"judgement of round 1", "refinement", "stability"}
    assert computed(results) - again == ENGINE | BOTH
    begun = results.rounds[0]
    assert begun.from_other and begun.kept and not begun.refined
    assert begun.estimate == pytest.approx(first[0].rounds[-1].estimate, rel=1e-4)
    # the scene of a kept body is that of this run
    hashes = {r.bodies["inner"].element.provenance["scene_sha256"] for r in (results, first[0])}
    assert len(hashes) == 2
    # the same again is the same, and the first scene what it was
    same, _, _ = run(folder, bearings=bearings)
    assert set(same.stages.values()) == {"kept"}
    assert document(same) == document(results)
    assert document(run(folder)[0]) == document(first[0])


def test_supports_that_need_more_refine_further(first, run, folder, data):
    """The estimate at other supports decides whether the meshes and bases will do."""
    bearings = [
        {**b, "stiffness_n_per_m": 300.0 * b["stiffness_n_per_m"]} for b in data["bearings"]
    ]
    results, _, _ = run(folder, bearings=bearings)
    assert results.rounds[0].from_other and len(results.rounds) > 1
    fresh, _, _ = run(folder / "other", bearings=bearings)
    asked = data["model"]["accuracy"]
    assert max(r.rounds[-1].estimate for r in (results, fresh)) < asked
    pairs = zip(results.critical_speeds, fresh.critical_speeds, strict=True)
    for one, other in pairs:
        assert one.critical.speed_rad_s == pytest.approx(other.critical.speed_rad_s, rel=2 * asked)


def test_changed_words_and_analyses_keep_the_engine(first, run, folder, data):
    results, _, _ = run(folder, title="Another title", notes=["a note"])
    assert computed(results) == set()
    more = {"kind": "stability", "to_rpm": 20000.0, "from_rpm": 1000.0, "count": 3}
    results, _, _ = run(folder, analyses=[*data["analyses"], more])
    assert computed(results) == {"analysis stability"}
    analyses = document(results)["analyses"]
    analyses.pop("stability")
    assert analyses == document(first[0])["analyses"]


def test_changed_body_keeps_the_other(run, folder, data):
    bodies = {name: dict(body) for name, body in data["bodies"].items()}
    outer = dict(bodies["outer"]["sections"][0], outer_radius_m=0.041)
    bodies["outer"] |= {"sections": [outer]}
    results, _, _ = run(folder, bodies=bodies)
    assert results.stages["mesh inner"] == results.stages["reduction inner"] == "kept"
    assert computed(results) >= {"mesh outer", "reduction outer", *ENGINE}


@pytest.mark.verify
def test_other_models_do_not_meet(run, folder, data):
    """A coarser accuracy is another mesh; nothing of the finer one is taken for it."""
    model = {**data["model"], "accuracy": 0.04}
    results, _, _ = run(folder, model=model)
    fresh, _, _ = run(folder / "other", model=model)
    assert document(results) == document(fresh)
    assert computed(results) >= {"reduction inner", "reduction outer"}


def test_lost_judgement_is_made_again(first, run, folder):
    """It needs the solvers' view of the bodies, which can't be kept: they are reduced again."""
    lost = [p for p in folder.glob("*.stage") if b'.Round"' in p.read_bytes()]
    assert len(lost) == len(first[0].rounds) + 2 > 3  # and the refinement, for both its keys
    for path in lost:
        path.unlink()
    results, notes, _ = run(folder)
    judged = {f"judgement of round {k + 1}" for k in range(len(first[0].rounds))}
    assert computed(results) == {"refinement"} | judged
    assert any("again, for where its error arises" in note for note in notes)
    assert document(results) == document(first[0])


@pytest.mark.verify
def test_damaged_entries_are_computed_again(first, run, folder):
    chance = np.random.default_rng(1)
    paths = sorted(folder.glob("*.stage"))
    for path in paths:
        content = bytearray(path.read_bytes())
        content[chance.integers(len(content))] ^= 1 << chance.integers(8)
        path.write_bytes(content)
    results, notes, _ = run(folder)
    assert len([n for n in notes if "is damaged" in n]) == len(paths)
    assert len(paths) == len(first[0].stages) + 1  # the refinement, for both its keys
    assert set(results.stages.values()) == {"computed"}
    assert document(results) == document(first[0])
    assert sorted(folder.glob("*.stage")) == paths


@pytest.mark.verify
def test_store_that_can_not_be_written(first, run, tmp_path):
    (tmp_path / "file").write_text("", encoding="utf-8")
    results, notes, _ = run(tmp_path / "file")
    assert len([n for n in notes if "is not kept" in n]) >= len(first[0].stages)
    assert document(results) == document(first[0])


def test_fresh_store_computes_and_keeps(first, run, folder):
    from solidwhirl.pipeline.cached_stages import open_fresh_store

    times = {p.name: p.stat().st_mtime_ns for p in folder.glob("*.stage")}
    results, _, store = run(folder, open_fresh_store)
    assert set(results.stages.values()) == {"computed"}
    assert document(results) == document(first[0])
    store.prune(room_bytes=0)
    after = {p.name: p.stat().st_mtime_ns for p in folder.glob("*.stage")}
    assert all(after[name] > times[name] for name in after)
    assert len(after) == len(first[0].stages) + 1  # the refinement, for both its keys


def test_beams_and_the_choice_of_the_level_are_kept(scene_path, tmp_path):
    from solidwhirl.pipeline.cached_stages import open_store
    from solidwhirl.pipeline.run import run_scene

    data = tomllib.loads(scene_path("one_body").read_text(encoding="utf-8"))
    scene = parse_scene({**data, "model": {"accuracy": 0.1, "level": "auto"}})
    first, again = (run_scene(scene, store=open_store(tmp_path)) for _ in range(2))
    assert first.stages.keys() >= {"choice of the level", "beams"}
    # beams were made for the choice, and taken from there
    assert {s for s, origin in first.stages.items() if origin == "kept"} == {"beams"}
    assert set(again.stages.values()) == {"kept"}
    assert document(again) == document(first)
