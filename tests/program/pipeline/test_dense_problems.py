"""What a run assembles and solves of its bodies and its engine is counted, and done once."""

from __future__ import annotations

import pytest

from solidwhirl.cache.codec import Seen, fingerprint
from solidwhirl.core.stages import silent
from solidwhirl.output import documents
from solidwhirl.output.documents import write_into
from solidwhirl.pipeline.cached_stages import StageCache, open_store
from solidwhirl.pipeline.run import run_scene
from solidwhirl.rotordyn import Superelement, read_superelement
from solidwhirl.scene_reading.reader import parse_scene, scene_hash

OPERATING = [{"shaft": "rotor", "from_rpm": 9000.0, "to_rpm": 10000.0}]

_NAME = f"{Superelement.__module__}.{Superelement.__qualname__}"
WITHOUT_ORIGIN = Seen(left_out={_NAME: frozenset({"provenance"})})


@pytest.fixture(scope="module")
def lightly_damped(small_scene):
    def data(stiffness, **more):
        found = small_scene(
            rpm=[1500.0 * k for k in range(21)],
            bearing={"stiffness_n_per_m": stiffness, "damping_n_s_per_m": 50.0},
            model={"estimates": "on", "level": "harmonic"},
        )
        return found | more

    return data


def solved(results, stage):
    found = results.dense_problems.get(stage, {})
    return found.get("eigenproblems", 0), found.get("factorisations", 0)


def test_a_bearing_edit_solves_the_engine_alone(lightly_damped, tmp_path, monkeypatch):
    """And no more of it than before; again the same computes nothing at all."""
    store = open_store(tmp_path)
    first = run_scene(parse_scene(lightly_damped(1e7)), store=store)
    edited = run_scene(parse_scene(lightly_damped(1.02e7)), store=store)
    again = run_scene(parse_scene(lightly_damped(1.02e7)), store=store)
    assert first.body_problems["reduction"]["matrices"] > 0
    assert not edited.body_problems
    assert {edited.stages[name] for name in ("mesh rotor", "reduction rotor")} == {"kept"}
    assert not again.body_problems and "computed" not in again.stages.values()
    for stage in ("campbell", "critical_speeds", "error_estimate"):
        assert solved(again, stage) == (0, 0)
    for stage in ("campbell", "critical_speeds", "error_estimate"):
        before, after = solved(first, stage), solved(edited, stage)
        assert after[0] <= before[0] and before[0] > 0
    _writes_bodies_once(first, edited, StageCache(store=store, progress=silent), monkeypatch)
    # one whole eigenproblem for each speed; what judged the refinement is the engine that is
    # reported, and has its modes at rest and at the top speed
    speeds, found = 21, len(first.critical_speeds)
    assert solved(first, "campbell")[0] <= speeds - 2
    # errors at the speeds of the diagram have its modes; two compared models: at five speeds, and
    # one for each critical speed that is followed; a search would take a dozen more
    assert [pair.part for pair in first.estimates.comparisons] == ["interface_coupling"]
    assert solved(first, "error_estimate")[0] <= found + 2 * (5 + found) + 6


def _writes_bodies_once(first, edited, stage_cache, monkeypatch):
    """Files of bodies that another scene wrote are taken over, with the scene that they are of."""
    folders = [stage_cache.store.folder / name for name in ("first", "edited")]
    asked = {"pictures": False, "page": False, "stage_cache": stage_cache}
    for results, folder in zip((first, edited), folders, strict=True):
        folder.mkdir()
        write_into(results, folder, **asked)
        monkeypatch.setattr(documents, "write_superelement", None)  # not called again
    scenes = []
    for folder in folders:
        element = read_superelement(folder / "bodies" / "rotor.h5")
        assert fingerprint(element, WITHOUT_ORIGIN) == fingerprint(
            first.elements["rotor"], WITHOUT_ORIGIN
        )
        scenes.append(element.provenance["scene_sha256"])
    assert scenes == [scene_hash(results.scene) for results in (first, edited)]


def test_critical_speeds_are_searched_once(lightly_damped):
    """Margins up to the same speed ask for what is known; spectra are few, roots are refined."""
    margins = {
        "kind": "separation_margins", "operating": OPERATING, "search_factor": 3.0,
    }  # fmt: skip
    results = run_scene(parse_scene(lightly_damped(1e7, analyses=[margins])))
    whole, alone = solved(results, "critical_speeds")
    assert len(results.critical_speeds) >= 2
    assert whole <= 12 and alone >= len(results.critical_speeds)
    assert solved(results, "analysis separation_margins") == (0, 0)
