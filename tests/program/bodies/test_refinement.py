"""Refinement ends: rounds that get no better, small machines, rotors that nothing holds."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from solidwhirl.beams.error import VARIANTS
from solidwhirl.bodies import refinement as dial
from solidwhirl.bodies.contributions import AskedModes, Contributions, error_contributions
from solidwhirl.bodies.reduction import first_discretisation
from solidwhirl.bodies.refinement import Round, rounds_of
from solidwhirl.build import bearing, body, cylinder, scene
from solidwhirl.cache.files import StageStore
from solidwhirl.console.summary import warning_texts
from solidwhirl.core.errors import MemoryShortageError
from solidwhirl.cost import forecast as forecasts
from solidwhirl.cost.engine import seconds_of, stage_works
from solidwhirl.cost.forecast import forecast, refuse_too_large, shortage_of
from solidwhirl.cost.work import predict_cost
from solidwhirl.model.bodies import build_bodies
from solidwhirl.model.effects import make_plan
from solidwhirl.output.documents import results_document
from solidwhirl.pipeline.run import run_scene
from solidwhirl.reduced_scene import reduce_scene
from solidwhirl.rotordyn import modes_at_speed
from solidwhirl.scene.records import ModelSpec

MOST = ModelSpec().rounds
SIZES = [cylinder("a", 0.0, 0.5, 0.03), cylinder("b", 0.5, 1.0, 0.045)]


def free_shaft(to_rpm=3000.0, from_rpm=0.0, support=None, branches=6, **model):
    """A shaft of two sections, free or on a spring at its one interface."""
    held = () if support is None else (bearing("seat", "shaft.seat", stiffness_n_per_m=support),)
    return scene(
        "free",
        model={"level": "harmonic", "accuracy": 2e-3, "compare_coupling": "off", **model},
        speeds_rpm=np.linspace(from_rpm, to_rpm, 3),
        branches=branches,
        bodies={"shaft": body(*SIZES, interfaces={"seat": 0.1})},
        bearings=held,
    )


class Alone:
    """A communicator of one rank."""

    rank = 0

    @staticmethod
    def bcast(value, root):
        return value


def rounds(estimates, looked_at=None, shortage=None, eased=1.0, most=MOST):
    """Bodies and rounds of a judge that always wants more and finds these estimates.

    `eased`: largest multiple of the accuracy that the judge refines for.
    """
    looked_at = looked_at or [6] * len(estimates)

    def judge(reduced, number, multiple):
        found = Round(
            unknowns={"a": number},
            modes={"a": 4},
            estimate=estimates[number - 1],
            parts={},
            refined=("a: mesh",),
            looked_at=looked_at[number - 1],
        )
        return found, {} if multiple > eased else {"a": number + multiple}

    def reduce_one(name, chosen, before):
        assert before is None or before < chosen  # goes on from the last round
        return chosen

    more = {} if shortage is None else {"shortage": shortage}
    return rounds_of({"a": 1}, reduce_one, judge, Alone, most, **more)


def test_rounds_end():
    """The first basis has not all modes below the excitation: its estimate is no smaller for it."""
    bodies, found = rounds([0.1, 0.2, 0.05, 0.1], looked_at=[6, 8, 8, 8])
    assert len(found) == 4
    assert bodies == {"a": 3}
    assert [r.kept for r in found] == [False, False, True, False]
    bodies, found = rounds(list(0.5 ** np.arange(50)))
    assert len(found) == 8
    assert bodies == {"a": 8}
    assert found[-1].stopped == "8 rounds"
    (only,) = rounds([0.3, 0.1], most=1)[1]
    assert only.kept and only.stopped == "one round" and only.refined == ()


@pytest.mark.parametrize("worse", [0.2, np.nan, np.inf])
def test_a_rising_estimate_is_not_followed_by_a_finer_round(worse):
    bodies, found = rounds([0.3, 0.1, worse, 0.0])
    assert [r.estimate for r in found[:2]] == [0.3, 0.1]
    assert len(found) == 3
    assert bodies == {"a": 2}
    assert [r.kept for r in found] == [False, True, False]
    assert [r.stopped for r in found] == ["", "", "the estimate rises"]
    assert found[2].refined == ()


def test_a_round_that_memory_can_not_hold_is_not_begun():
    bodies, found = rounds(
        [0.3, 0.1, 0.05], shortage=lambda todo, reduced: "full" * (todo["a"] > 2)
    )
    assert bodies == {"a": 2}
    assert [r.stopped for r in found] == ["", "full"]
    assert found[-1].kept


def test_a_round_that_runs_out_of_memory_is_given_up():
    """The one before it counts; of the first there is none."""
    held = []

    def reduce_one(name, chosen, before):
        held.append(before)
        if chosen == last:
            raise MemoryShortageError("9 GB are needed")
        return chosen

    def judge(reduced, number, multiple):
        found = Round(
            unknowns={}, modes={}, estimate=0.5**number, parts={}, refined=("a: mesh",), looked_at=6
        )
        return found, {"a": number + 1}

    last = 3
    bodies, found = rounds_of(
        {"a": 1}, reduce_one, judge, Alone, MOST, let_go=lambda result: f"{result} let go"
    )
    assert held == [None, "1 let go", "2 let go"]
    assert bodies == {"a": "2 let go"}
    assert [r.stopped for r in found] == ["", "9 GB are needed"]
    assert [r.kept for r in found] == [False, True]
    assert [r.refined for r in found] == [("a: mesh",), ()]
    assert found[1].lacked_memory
    last = 1
    with pytest.raises(MemoryShortageError):
        rounds_of({"a": 1}, reduce_one, judge, Alone, MOST)


def test_a_round_that_memory_can_not_hold_aims_at_less():
    """Half the accuracy fits; then half and a quarter do not, and the round is good enough."""

    def shortage(todo, reduced):
        return "" if todo["a"] == 3.0 and reduced["a"] == 1 else "full"

    bodies, found = rounds([0.3, 0.1, 0.05], shortage=shortage, eased=4.0)
    assert bodies == {"a": 3.0}
    assert [r.stopped for r in found] == ["", "full"]
    assert [r.refined for r in found] == [("a: mesh",), ()]


@pytest.mark.parametrize(("available", "allowed"), [(1e-3, None), (100.0, 0.2), (100.0, 100.0)])
def test_memory_is_forecast_before_every_round(monkeypatch, available, allowed):
    monkeypatch.setattr(forecasts, "available_memory_gib", lambda: available)
    monkeypatch.setattr(forecasts, "resident_memory_gib", lambda: 0.19)
    asked = free_shaft(**({} if allowed is None else {"memory_gib": allowed}))
    bodies = build_bodies(asked)
    plan = make_plan(asked, bodies, "harmonic")
    said = []
    shortage = shortage_of(asked, plan, bodies, said.append)
    why = shortage({"shaft": first_discretisation(asked, plan, "shaft")}, {})
    if min(available, allowed or available) < 1.0:
        assert why.startswith("the next round would need about ")
        assert why.endswith(" GiB are free")
        assert said == []
    else:
        assert why == ""
        assert said[0].startswith("next round: about ")


def test_a_whole_solid_leaves_its_mesh_a_share_of_the_accuracy(monkeypatch):
    """Its mesh is compared later: a truncation of half the accuracy is too much."""
    asked = free_shaft(level="solid", accuracy=4e-3)
    bodies = build_bodies(asked)
    plan = make_plan(asked, bodies, "solid")
    whole = replace(plan.bodies["shaft"], shape="round")  # as of a STEP file
    plan = replace(plan, bodies={"shaft": whole})
    chosen = first_discretisation(asked, plan, "shaft")
    result = SimpleNamespace(
        body=bodies["shaft"], discretisation=chosen, element=SimpleNamespace(full_dofs=9)
    )

    def refined(error):
        found = Contributions(
            shares={("shaft", "mode_truncation"): np.array([error])},
            speeds_rad_s=np.zeros(1),
            rates=np.array([1j]),
            motions={},
            spin_rad_s={},
        )
        monkeypatch.setattr(dial, "error_contributions", lambda *_: found)
        return dial.next_discretisations(asked, plan, {"shaft": result}, None, 4e-3)[1]

    assert refined(2e-3)["shaft"].modes > chosen.modes
    assert refined(4e-4) == {}


@pytest.mark.parametrize(("level", "others"), [("harmonic", 0), ("beam", len(VARIANTS))])
def test_diagrams_of_other_models_are_forecast(level, others):
    """Beams have a diagram for each variant of their theory; all else is followed by few modes."""
    asked = free_shaft(level=level, compare_coupling="on")
    bodies = build_bodies(asked)
    plan = make_plan(asked, bodies, level)
    found = [
        predict_cost(plan, asked, bodies, modes={"shaft": modes}, estimates=True)
        for modes in (50, 100)
    ]
    spent, drawn = [], []
    for one in found:
        followed = seconds_of(stage_works(plan, one.size, True)["error_estimate"], one.size)
        own = one.bodies["shaft"].seconds.get("error_estimate", 0.0)
        spent.append(one.whole.seconds["error_estimate"] - own - followed)
        drawn.append(one.whole.seconds["campbell"])
    assert spent[1] - spent[0] == pytest.approx(others * (drawn[1] - drawn[0]), abs=1e-9)


def test_a_first_mesh_above_the_memory_of_the_scene_is_refused():
    asked = free_shaft(memory_gib=0.01)
    bodies = build_bodies(asked)
    plan = make_plan(asked, bodies, "harmonic")
    with pytest.raises(ValueError, match=r"0\.01 GiB are available"):
        refuse_too_large(asked, plan, bodies, forecast(asked, plan, bodies))


@pytest.mark.solver
@pytest.mark.parametrize(
    ("support", "from_rpm"),
    [
        (None, 0.0),
        (1e7, 0.0),
        (1e2, 3000.0),
        pytest.param(None, 3000.0, marks=pytest.mark.verify),
        pytest.param(1e7, 3000.0, marks=pytest.mark.verify),
        pytest.param(1e2, 0.0, marks=pytest.mark.verify),
    ],
)
def test_rotors_that_nothing_holds_are_refined_as_others_are(support, from_rpm):
    """Their precession is slow and strains nothing: it has no error that calls for elements."""
    results = run_scene(free_shaft(6000.0, from_rpm, support))
    assert results.estimates.largest <= 2e-3
    assert len(results.rounds) <= 3
    assert sum(results.rounds[-1].unknowns.values()) < 6000


@pytest.mark.solver
@pytest.mark.parametrize("lacking", ["factor", "mesh", "allocation"])
def test_a_run_that_may_not_go_on_has_the_results_of_its_best_round(tmp_path, monkeypatch, lacking):
    """And says why; with more memory a later run goes on from there."""
    import solidwhirl.bodies.reduction as bodies_of
    import solidwhirl.reduction
    import solidwhirl.reduction.solvers.constrained as constrained

    asked = free_shaft(6000.0, support=1e7, accuracy=1e-4)
    begun, made = [], []
    reduce_meshed, mesh_body = bodies_of.reduce_meshed, bodies_of.mesh_body

    def limited(*args):
        begun.append(args)
        if len(begun) > 1 and lacking == "factor":  # MUMPS itself finds that it is not enough
            patched.setattr(constrained, "available_memory_bytes", lambda comm: 2**20)
        if len(begun) > 1 and lacking == "allocation":
            patched.setattr(solidwhirl.reduction, "reduce_body", failing)
        return reduce_meshed(*args)

    def failing(*args):
        raise MemoryError

    def meshed(*args):
        made.append(args)
        return mesh_body(*args)

    def available_gib():
        return 0.01 if lacking == "mesh" and len(made) > 1 else 100.0

    store = StageStore(tmp_path)
    with monkeypatch.context() as patched:
        patched.setattr(bodies_of, "reduce_meshed", limited)
        patched.setattr(bodies_of, "mesh_body", meshed)
        patched.setattr(forecasts, "available_memory_gib", available_gib)
        stopped = run_scene(asked, store=store)
    (only,) = [r for r in stopped.rounds if r.kept]
    assert only.stopped and only.lacked_memory and only.estimate > 1e-4
    document = results_document(stopped)
    assert document["accuracy"]["met"] is False
    assert document["accuracy"]["rounds"][-1]["stopped"] == only.stopped
    line = warning_texts(document)[-1]
    assert "accuracy not met" in line and only.stopped in line
    if lacking == "factor":
        later = run_scene(asked, store=store)
        assert results_document(later)["accuracy"]["met"] is True
        assert later.stages["reduction shaft"] == "kept"


@pytest.mark.solver
@pytest.mark.parametrize("corner_size_m", [5e-3, 1e-3])
def test_rigid_motions_have_no_error_of_strain_on_any_mesh(corner_size_m):
    """K R = 0 and (Kgeo - S) R = 0 in every space, so neither elements nor modes miss anything."""
    results = run_scene(free_shaft(corner_size_m=corner_size_m, size_m=0.02, order=2, modes=5))
    element = results.elements["shaft"]
    rigid = element.rigid_body_modes[:, element.rigid_body_present]
    n = len(rigid)
    for form in element.error_forms:
        blocks = form.gram.reshape(4, n, 4, n)
        for term in (0, 3):
            whole = max(np.abs(blocks[term, :, term]).max(), 1e-300)
            assert np.abs(rigid.T @ blocks[term, :, term] @ rigid).max() <= 1e-14 * whole
    asked = AskedModes(count=6, frequency_max_hz=None)
    found = error_contributions(results.system, (300.0,), asked)
    # forward precession at (Ip / It) Ω of the rigid body, and nothing else, is that slow
    inertia = element.inertia_kg_m2
    slow = np.isclose(np.abs(found.rates), 300.0 * inertia[2, 2] / inertia[0, 0], rtol=1e-3)
    assert slow.sum() == 1
    assert found.total[slow] < 1e-6


@pytest.mark.solver
def test_modes_whose_critical_speed_is_passed_are_refined_too():
    """The diagram shows two branches, the accuracy is asked of every critical speed."""
    results = run_scene(free_shaft(60_000.0, support=1e7, branches=2))
    assert len(results.critical_speeds) > 4
    assert results.estimates.critical_speeds.total.max() <= 2e-3


# -- slender bodies --------------------------------------------------------------------------------

WIRE = [cylinder("s0", 0.0, 7.33e-3, 1.19e-4), cylinder("s1", 7.33e-3, 0.01466, 1.242e-4)]


def wire(**model):
    """A wire on one spring whose ninth critical speed lies in the range."""
    size = {"order": 4, "size_m": 2e-4, "corner_size_m": 2e-4, "compare_coupling": "off"}
    return scene(
        "wire",
        model={"level": "harmonic", **size, **model},
        speeds_rpm=[0.0, 9.9e6],
        branches=4,
        bodies={"wire": body(*WIRE, interfaces={"a": 8.8e-4, "b": 0.01363})},
        bearings=[bearing("a", "wire.a", stiffness_n_per_m=550.0)],
    )


def lowest_modes(system):
    """The modes of a wire at its top speed up to it."""
    top = 9.9e6 * np.pi / 30.0
    found = modes_at_speed(system, top).frequency_hz
    return found[found < top / (2.0 * np.pi)]


@pytest.mark.solver
def test_directions_that_only_fast_modes_need_stay_in_the_basis():
    """The lowest mode bends a thousand times softer: a trace of it is no trace to the tenth."""
    few, more = (
        lowest_modes(reduce_scene(wire(modes=modes, estimates="off")).system) for modes in (28, 50)
    )
    np.testing.assert_allclose(few, more, rtol=5e-6)


@pytest.mark.verify
@pytest.mark.solver
@pytest.mark.parametrize("many", [0, pytest.param(100, marks=pytest.mark.verify)])
def test_static_answers_to_the_spin_stand_for_modes_of_thickness_shear(many):
    """Dozens of bending modes lie below those that warp the sections."""
    results = run_scene(wire(accuracy=3e-5))
    solved = results.bodies["wire"].work.solved["n=1"]
    assert any(text.startswith("static answers to the spin") for text in solved)
    assert results.rounds[-1].modes["wire"] <= 30
    assert results.rounds[-1].parts["mode_truncation"] < 6e-6
    if many:
        hundred = reduce_scene(wire(modes=many, estimates="off"))
        few = lowest_modes(results.system)
        np.testing.assert_allclose(few, lowest_modes(hundred.system), rtol=1e-5)


@pytest.mark.solver
@pytest.mark.parametrize("size_m", [4e-4, pytest.param(1.5e-4, marks=pytest.mark.verify)])
def test_bases_of_slender_bodies_lose_no_mode(size_m):
    """Two more modes far above leave the lowest where they are, and Ritz values do not rise."""

    def lowest(modes):
        model = {"level": "harmonic", "accuracy": 1.5e-5, "modes": modes, "order": 4}
        sizes = {"size_m": size_m, "corner_size_m": size_m, "compare_coupling": "off"}
        shaft = body(cylinder("s", 0.0, 0.0277, 3.2e-4), interfaces={"a": 1.66e-3, "b": 0.0257})
        asked = scene("slender", model=model | sizes, bodies={"wire": shaft})
        return run_scene(asked).elements["wire"].free_frequencies_hz[:6]

    few, more = lowest(7), lowest(9)
    np.testing.assert_allclose(few, more, rtol=1e-6)
    assert np.all(more <= few * (1.0 + 1e-8))
