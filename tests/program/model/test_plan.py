"""What the plan decides, and that a run assembles and solves just that."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from solidwhirl.build import cylinder, disk
from solidwhirl.model.bodies import build_bodies
from solidwhirl.model.effects import make_plan
from solidwhirl.output.documents import results_document
from solidwhirl.pipeline.run import run_scene
from solidwhirl.scene_reading.reader import parse_scene

ROTATION = ("gyroscopic", "stress_stiffening", "spin_softening")
MATRICES = {"stiffness", "mass", "component_mass", "axisymmetric_stiffness", *ROTATION}
DISK = disk("hub", mass_kg=1.0, polar=0.02, diametral=0.01)
TILTING = {"tilt_stiffness_n_m_per_rad": 1e4}
AXIAL = {"axial_stiffness_n_per_m": 1e6}
TORSION = {"torsion_stiffness_n_m_per_rad": 1e5}
DAMPED = {"damping_n_s_per_m": 200.0}


@pytest.fixture(scope="session")
def planned(small_scene):
    """Function: the plan of the small scene with changes."""

    def plan(**changes):
        scene = parse_scene(small_scene(**changes))
        return make_plan(scene, build_bodies(scene))

    return plan


def states(plan):
    return {effect.name: effect.on for effect in plan.effects}


def why(plan, name):
    return next(effect.why for effect in plan.effects if effect.name == name)


# -- decisions ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "changes", [{"rpm": None}, {"rpm": (0.0,)}, {"body": {"speed_ratio": 0.0}}]
)
def test_at_rest_nothing_of_rotation_is_computed(planned, changes):
    plan = planned(**changes)
    for name in ROTATION:
        assert not plan.on(name)
        assert "nothing turns" in why(plan, name)
    own = plan.bodies["rotor"]
    assert (own.matrices, own.factorisations, own.eigenproblems) == (3, 1, 1)
    assert own.maximum_speed_rad_s == 0.0


@pytest.mark.parametrize("ratio", [1.0, -0.5])
def test_turning_bodies_get_all_of_rotation(planned, ratio):
    plan = planned(body={"speed_ratio": ratio})
    assert all(plan.on(name) for name in ROTATION)
    top = abs(ratio) * 30000.0 * np.pi / 30.0
    assert plan.bodies["rotor"].maximum_speed_rad_s == pytest.approx(top, rel=1e-15)
    np.testing.assert_allclose(plan.speeds_rad_s, np.array([0, 500, 1000]) * np.pi, rtol=1e-15)


def test_lateral_scene_has_neither_damping_nor_order_0_nor_tilt(planned):
    plan = planned()
    for name in ("bearing_damping", "axial", "torsion", "tilt"):
        assert not plan.on(name)
        assert why(plan, name).startswith("no")
    assert not plan.on("nodal_diameter_modes") and not plan.on("internal_damping")
    assert all(effect.why for effect in plan.effects)
    own = plan.bodies["rotor"]
    assert own.level == "harmonic"
    assert own.orders == (1,)
    assert own.components == ("ux", "uy")


@pytest.mark.parametrize(
    ("bearing", "name", "orders", "components"),
    [
        (AXIAL, "axial", (1, 0), ("ux", "uy", "uz", "rz")),
        ({"axial_damping_n_s_per_m": 5.0}, "axial", (1, 0), ("ux", "uy", "uz", "rz")),
        ({"rigid": ["uz"]}, "axial", (1, 0), ("ux", "uy", "uz", "rz")),
        (TORSION, "torsion", (1, 0), ("ux", "uy", "uz", "rz")),
        ({"torsion_damping_n_m_s_per_rad": 5.0}, "torsion", (1, 0), ("ux", "uy", "uz", "rz")),
        ({"rigid": ["rz"]}, "torsion", (1, 0), ("ux", "uy", "uz", "rz")),
        (TILTING, "tilt", (1,), ("ux", "uy", "rx", "ry")),
        ({"tilt_damping_n_m_s_per_rad": [0, 5.0]}, "tilt", (1,), ("ux", "uy", "rx", "ry")),
        ({"rigid": ["ry"]}, "tilt", (1,), ("ux", "uy", "rx", "ry")),
        (DAMPED, "bearing_damping", (1,), ("ux", "uy")),
    ],
)
def test_bearings_call_for_effects(planned, bearing, name, orders, components):
    plan = planned(bearing=bearing)
    assert plan.on(name)
    assert "left" in why(plan, name), "the bearing is named"
    assert plan.bodies["rotor"].orders == orders
    assert plan.bodies["rotor"].components == components
    assert states(plan)["bearing_damping"] == any("damping" in key for key in bearing)
    if name in ("axial", "torsion"):
        (other,) = {"axial", "torsion"} - {name}
        assert plan.on(other)
        assert why(plan, other).startswith(f"free beside {name}: nothing acts on it")
    for other in {"axial", "torsion", "tilt"} - {name} if orders == (1,) else {"tilt"}:
        assert not plan.on(other)


@pytest.mark.parametrize("name", ["tilt", "axial", "torsion", "bearing_damping"])
@pytest.mark.parametrize(("asked", "on"), [("on", True), ("off", False), (True, True)])
def test_explicit_on_and_off_win(planned, name, asked, on):
    """Switched on where nothing calls for it, and off where something does."""
    needed = {"tilt": TILTING, "axial": AXIAL, "torsion": TORSION, "bearing_damping": DAMPED}[name]
    for bearing in ({}, needed):
        plan = planned(bearing=bearing, effects={name: asked})
        assert plan.on(name) is on
    if not on:
        assert why(plan, name).startswith("the scene says off, though")
        assert "left" in why(plan, name)
        assert plan.bodies["rotor"].orders == (1,)


@pytest.mark.parametrize(
    ("rpm", "effects", "on"),
    [
        ((0.0,), {"gyroscopic": "on"}, {"gyroscopic"}),
        ((0.0, 9e3), {"gyroscopic": "off"}, {"stress_stiffening", "spin_softening"}),
        ((0.0,), {"stress_stiffening": "on"}, {"stress_stiffening", "spin_softening"}),
        ((0.0, 9e3), {"stress_stiffening": "off", "spin_softening": "off"}, {"gyroscopic"}),
    ],
)
def test_explicit_rotation_effects(planned, rpm, effects, on):
    plan = planned(rpm=rpm, effects=effects)
    assert {name for name in ROTATION if plan.on(name)} == on
    for name in effects:
        assert "the scene says" in why(plan, name)


def test_accuracy_chooses_the_order(planned):
    for accuracy, degree in ((0.05, 2), (1e-3, 3), (5e-5, 4)):
        model = {"accuracy": accuracy}
        assert planned(model=model).bodies["rotor"].resolution.degree == degree
    assert planned(model={"order": 4}).bodies["rotor"].resolution.degree == 4


def test_finer_accuracy_means_smaller_corners_and_error(planned):
    """The rule: error proportional to (corner size)^1.0889 at one element order."""
    coarse, fine = (planned(model={"accuracy": a}).bodies["rotor"].resolution for a in (4e-3, 1e-3))
    assert fine.expected_error == pytest.approx(1e-3, rel=1e-9)
    assert coarse.expected_error == pytest.approx(4e-3, rel=1e-9)
    ratio = coarse.size.corner_size_m / fine.size.corner_size_m
    assert ratio == pytest.approx(4.0 ** (1 / 1.0889), rel=1e-9)


@pytest.mark.parametrize(
    ("model", "size_m", "corner_size_m"),
    [
        ({"size_m": 5e-3, "corner_size_m": 1e-3}, 5e-3, 1e-3),
        ({"corner_size_m": 2e-3}, 0.1, 2e-3),
        ({"size_m": 1e-3}, 1e-3, 1e-3),  # finer than the rule's corners: nothing is coarser
    ],
)
def test_sizes_of_the_scene_win(planned, model, size_m, corner_size_m):
    size = planned(model=model).bodies["rotor"].resolution.size
    assert size.size_m == pytest.approx(size_m, rel=1e-12)
    assert size.corner_size_m == pytest.approx(corner_size_m, rel=1e-12)


# -- kept by the run ------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def counted(small_scene):
    """Function: run the small scene with changes, each once; results and what was really done."""
    import solidwhirl.reduction.basis.fixed_interface_modes as held_modes
    import solidwhirl.reduction.body.reduce as reduce
    import solidwhirl.reduction.operators.compat as compat
    import solidwhirl.reduction.operators.prestress as prestress
    import solidwhirl.reduction.operators.solver_choice as solvers
    import solidwhirl.rotordyn.modes.eigen as eigen
    import solidwhirl.rotordyn.modes.split_spectrum as split_spectrum

    patch = pytest.MonkeyPatch()
    done, known = Counter(), {}

    def count(module, name, label):
        original = getattr(module, name)

        def counting(*args, **kwargs):
            done[label] += 1
            return original(*args, **kwargs)

        patch.setattr(module, name, counting)

    count(compat, "assemble_matrix", "matrices")
    count(held_modes, "factorise", "factorisations")
    count(solvers, "factorise", "factorisations")
    count(prestress, "prepared_solver", "prestress")
    for name in ("eigenpairs", "slepc_pairs"):
        count(held_modes, name, "eigenproblems")
    for name in ("solve_general", "solve_gyroscopic", "solve_standing"):
        count(eigen, name, name)
    for name in ("_conservative", "_damped"):
        count(split_spectrum, name, name)

    checks = reduce.order_checks

    def uncounted(*args):
        """The checks are an item of the plan by themselves."""
        before = done.copy()
        found = checks(*args)
        done.clear()
        done.update(before)
        return found

    patch.setattr(reduce, "order_checks", uncounted)

    def run(**changes):
        key = repr(changes)
        if key not in known:
            done.clear()
            results = run_scene(parse_scene(small_scene(**changes)))
            known[key] = results, results_document(results), dict(done)
        return known[key]

    yield run
    patch.undo()


SOLID = {
    "model": {"level": "solid", "accuracy": 0.1, "size_m": 0.1, "corner_size_m": 0.1},
    "body": {"sections": [cylinder("shaft", 0.0, 0.4, 0.06)]},
}
SCENES = {
    "lateral": {},
    "at rest": {"rpm": None},
    "slow": {"rpm": (0.0, 10.0)},
    "damped": {"bearing": DAMPED},
    "axial": {"bearing": AXIAL},
    "axial at rest": {"bearing": AXIAL, "rpm": None},
    "all motions": {"bearing": {**AXIAL, **TORSION, **TILTING}},
    "rigid disk": {"body": {"rigid_disks": [{**DISK, "interface": "left"}]}},
    "no gyroscopic": {"effects": {"gyroscopic": "off"}},
    "no prestress": {"effects": {"stress_stiffening": "off", "spin_softening": "off"}},
    "prestress at rest": {"rpm": None, "effects": {"stress_stiffening": "on"}},
    "solid": SOLID,
    "solid at rest": SOLID | {"rpm": None},
}


@pytest.mark.solver
@pytest.mark.parametrize("case", SCENES)
def test_run_keeps_to_the_plan(counted, case):
    """Matrices as many as planned, factorisations and eigenproblems at most so many."""
    results, document, done = counted(**SCENES[case])
    own = results.plan.bodies["rotor"]
    entry = document["bodies"]["rotor"]
    assembled = [name for block in entry["assembled"].values() for name in block]
    solved = [name for block in entry["solved"].values() for name in block]
    assert done["matrices"] == own.matrices
    # counted by the run too, where those of its checks are in it
    counts = document["body_problems"]["reduction"]
    assert counts["matrices"] == own.matrices
    assert counts["eigenproblems"] == done["eigenproblems"]
    assert counts["factorisations"] >= done["factorisations"]
    assert done["factorisations"] <= own.factorisations
    assert done["eigenproblems"] <= own.eigenproblems
    # the ledger tells the truth; a static solution for the prestress is one factorisation
    assert sum(name in MATRICES for name in assembled) == done["matrices"]
    assert set(assembled) - MATRICES <= {"prestress"}
    prestress = assembled.count("prestress")
    assert prestress == done.get("prestress", 0)
    factorised = sum(name.startswith("factorisation") for name in solved)
    assert factorised + prestress == done["factorisations"]
    assert sum(name.startswith("fixed-interface modes") for name in solved) == done["eigenproblems"]
    assert list(entry["assembled"]) == [f"n={n}" for n in own.orders]
    # fast enough for the prestress to matter all that is planned is done; slow, modes once
    reached = {"lateral": (3, 2), "slow": (2, 1)}.get(case)
    assert reached in (None, (done["factorisations"], done["eigenproblems"]))
    if case == "lateral":
        assert (own.factorisations, own.eigenproblems) == (3, 2)


@pytest.mark.solver
def test_at_rest_nothing_of_rotation_is_assembled(counted):
    results, document, done = counted(rpm=None)
    assert document["bodies"]["rotor"]["assembled"] == {
        "n=1": ["stiffness", "mass", "component_mass"]
    }
    assert "prestress" not in done
    element = results.bodies["rotor"].element
    assert not element.gyroscopic.any()
    assert not results.system.gyroscopic.any()
    assert not results.system.centrifugal_stiffness.any()
    assert done["solve_standing"] > 0
    assert "solve_gyroscopic" not in done
    assert "solve_general" not in done


@pytest.mark.solver
def test_undamped_takes_the_hermitian_path_and_damped_the_general_one(counted):
    results, _, done = counted()
    assert results.system.is_conservative
    # the small scene is the same in all directions, so it is solved at half size
    assert done["_conservative"] > 0
    assert not {"_damped", "solve_general"} & set(done)
    assert np.all(results.campbell.log_decrement == 0.0)
    results, _, done = counted(bearing=DAMPED)
    assert not results.system.is_conservative
    assert done["_damped"] > 0
    assert not {"_conservative", "solve_gyroscopic"} & set(done)
    assert np.all(results.campbell.log_decrement > 0.0)


@pytest.mark.solver
def test_gyroscopic_switched_off_holds_for_rigid_disks_too(counted):
    """Without gyroscopic forces the lateral pairs of an isotropic rotor stay pairs at speed."""
    disks = {"rigid_disks": [{**DISK, "interface": "left"}]}
    off, _, _ = counted(body=disks, effects={"gyroscopic": "off"})
    assert not off.bodies["rotor"].element.gyroscopic.any()
    pairs = off.campbell.frequency_hz
    np.testing.assert_allclose(pairs[0::2], pairs[1::2], rtol=1e-9)
    on, _, _ = counted(body=disks)
    last = on.campbell.frequency_hz[:, -1]  # lowest of both whirls: they begin as one pair
    forward, backward = (last[on.campbell.whirl[:, -1] == w].min() for w in ("forward", "backward"))
    assert forward / backward - 1.0 > 0.01


@pytest.mark.solver
def test_interface_that_is_the_union_of_two_others_is_refused(counted, small_scene):
    """Its mean motion follows from theirs: held by its own coordinate it gave 5 x the frequency."""
    from solidwhirl.reduction import ReductionError

    interfaces = small_scene()["bodies"]["rotor"]["interfaces"]
    parts = [("front", 0.2, 0.3), ("back", 0.3, 0.39)]
    for name, start, end in parts:
        interfaces.append({"name": name, "kind": "outer", "start_m": start, "end_m": end})
    plain, _, _ = counted(bearing=TILTING)
    more, _, _ = counted(bearing=TILTING, body={"interfaces": interfaces})
    # more interfaces change nothing but the basis, which is good to 1e-4 with three modes
    np.testing.assert_allclose(
        more.at_rest.frequency_hz[:4], plain.at_rest.frequency_hz[:4], rtol=1e-3
    )
    interfaces.append({"name": "both", "kind": "outer", "start_m": 0.2, "end_m": 0.39})
    with pytest.raises(ReductionError, match=r"'rotor' can not move as a rigid one.*union of two"):
        counted(bearing=TILTING, body={"interfaces": interfaces})


@pytest.mark.solver
def test_order_0_adds_its_modes_and_leaves_the_lateral_ones(counted):
    """Axial and torsional rigid modes: sqrt(k/m) and sqrt(k/Ip) of the body on soft springs."""
    soft = {"axial_stiffness_n_per_m": 1e4, "torsion_stiffness_n_m_per_rad": 100.0}
    plain, _, _ = counted()
    more, document, _ = counted(bearing=soft)
    assert list(document["bodies"]["rotor"]["assembled"]) == ["n=1", "n=0"]
    entry = document["bodies"]["rotor"]
    axial = np.sqrt(1e4 / entry["mass_kg"]) / (2 * np.pi)
    torsion = np.sqrt(100.0 / entry["polar_inertia_kg_m2"]) / (2 * np.pi)
    found = more.at_rest.frequency_hz
    # the body gives way by k/k_body: 1e4 N/m against 1e9, 100 against 1e5 N m/rad
    assert np.abs(found / axial - 1.0).min() < 1e-4
    assert np.abs(found / torsion - 1.0).min() < 1e-3
    for frequency in plain.at_rest.frequency_hz[:4]:
        assert np.abs(found / frequency - 1.0).min() < 1e-9
    # the inertia of a disk counts although nothing but the disk acts on its interface
    wheel = disk("wheel", mass_kg=5.0, polar=0.4, diametral=0.25, interface="right")
    results, document, _ = counted(bearing=soft, body={"rigid_disks": [wheel]})
    entry = document["bodies"]["rotor"]
    assert entry["polar_inertia_kg_m2"] > 0.4
    for stiffness, inertia in ((1e4, entry["mass_kg"]), (100.0, entry["polar_inertia_kg_m2"])):
        expected = np.sqrt(stiffness / inertia) / (2 * np.pi)
        assert np.abs(results.at_rest.frequency_hz / expected - 1.0).min() < 1e-3
