"""A geared train in all that a run tells: torsion by its name, and not excited by unbalance."""

from __future__ import annotations

import json

import numpy as np
import pytest
import scipy.linalg as la

from solidwhirl.build import beam, bearing, disk, scene
from solidwhirl.datasets.results import datasets
from solidwhirl.output.documents import results_document, write_results
from solidwhirl.page.modes.criticals import critical_speed_tables
from solidwhirl.page.run.masses import properties_table
from solidwhirl.pipeline.run import run_scene
from solidwhirl.pipeline.verdict_text import answers

# Holzer's model: motor, a soft coupling, then wheel, pinion and driven disk
SHEAR = 2.1e11 / 2.6
POLAR = {"motor": 9.0, "wheel": 3.0, "pinion": 0.02, "driven": 0.1}
COUPLING = 2e5


def _wheel(name, at_m, mass_kg):
    polar = POLAR[name]
    return disk(name=name, at_m=at_m, mass_kg=mass_kg, polar=polar, diametral=0.6 * polar)


def _train():
    bodies = {
        "motor": beam(
            [0.0, 0.6], 0.06, {"left": 0.0, "motor": 0.1, "right": 0.6},
            disks=[_wheel("motor", 0.1, 200.0)], material="light",
        ),
        "slow": beam(
            [0.0, 0.6], 0.06, {"left": 0.0, "wheel": 0.1, "right": 0.6},
            disks=[_wheel("wheel", 0.1, 80.0)], material="light",
        ),
        "fast": beam(
            [0.0, 0.6], 0.05, {"left": 0.0, "pinion": 0.1, "driven": 0.5, "right": 0.6},
            disks=[_wheel("pinion", 0.1, 8.0), _wheel("driven", 0.5, 20.0)], material="light",
            speed_ratio=-4.0,
        ),
    }  # fmt: skip
    gear = {
        "name": "gear", "first": "slow.wheel", "second": "fast.pinion", "ratio": -4.0,
        "mesh_stiffness_n_per_m": 5e8, "base_radius_first_m": 0.24, "line_of_action_deg": 70.0,
    }  # fmt: skip
    held = [
        bearing(f"{body}_{end}", f"{body}.{end}", stiffness_n_per_m=1e8, damping_n_s_per_m=1e4)
        for body in bodies
        for end in ("left", "right")
    ]
    held.append(
        bearing("coupling", "motor.left", "slow.left", stiffness_n_per_m=1e6,
                torsion_stiffness_n_m_per_rad=COUPLING)
    )  # fmt: skip
    return scene(
        "train",
        beams=bodies,
        bearings=held,
        gears=[gear],
        materials={"light": {"density_kg_per_m3": 100.0, "youngs_modulus_pa": 2.1e11,
                            "poissons_ratio": 0.3}},
        speeds_rpm=[0.0, 4000.0],
        branches=10,
        model={"level": "beam", "estimates": "off"},
        operating=[{"shaft": "slow", "from_rpm": 2350.0, "to_rpm": 2370.0}],
        analyses=[{"kind": "separation_margins"}],
    )  # fmt: skip


def _chain(springs, polar):
    stiffness = np.zeros((len(polar), len(polar)))
    for k, spring in enumerate(springs):
        stiffness[k : k + 2, k : k + 2] += spring * np.array([[1.0, -1.0], [-1.0, 1.0]])
    squared = la.eigvalsh(stiffness, np.diag(polar))
    return np.sqrt(squared[1:]) / (2.0 * np.pi)


def _holzer_hz():
    """Torsion of the train without any lateral motion, seen from the slow shaft."""
    slow, fast = (SHEAR * np.pi * r**4 / 2.0 for r in (0.06, 0.05))
    coupling = 1.0 / (1.0 / COUPLING + 2 * 0.1 / slow)
    springs = (coupling, 5e8 * 0.24**2, 16.0 * fast / 0.4)
    factors = np.array([1.0, 1.0, 16.0, 16.0])
    return _chain(springs, factors * [*POLAR.values()])


@pytest.fixture(scope="module")
def run():
    results = run_scene(_train())
    return results, results_document(results)


def test_torsion_is_named_where_holzer_has_it(run):
    _, document = run
    rest = document["modes_at_rest"]
    kinds = np.array(rest["kind"])
    torsional = np.array(rest["frequency_hz"])[kinds == "torsional"]
    # lateral motion of the seats of the wheels gives the teeth some more way
    assert torsional[torsional > 1.0][0] == pytest.approx(_holzer_hz()[0], rel=0.03)
    shares = np.array([*rest["shares"].values()])
    np.testing.assert_allclose(shares.sum(axis=0), 1.0, rtol=1e-12)
    for branch, whirl in zip(
        document["campbell"]["kind"], document["campbell"]["whirl"], strict=True
    ):
        for kind, word in zip(branch, whirl, strict=True):
            whirls = word in ("forward", "backward", "mixed", "straight")
            assert (kind in ("lateral", "coupled")) == whirls


def test_headlines_are_of_lateral_motion(run):
    _, document = run
    (torsional,) = (c for c in document["critical_speeds"]
                    if c["kind"] == "torsional" and c["shafts"] == ["fast"])  # fmt: skip
    assert torsional["frequency_hz"] == pytest.approx(_holzer_hz()[0], rel=0.03)
    assert not torsional["excited"] and torsional["excited_by"] == []
    assert torsional["exciters"] == ["torque"]
    first = document["verdict"]["at_operating"][0]["first_forward"]
    assert first["frequency_hz"] > 1.05 * torsional["frequency_hz"]
    said = " ".join(a.text for a in answers(document))
    assert f"{torsional['speed_rpm']:.0f} rpm" not in said


def test_what_is_not_excited_is_folded_with_the_reason(run):
    results, document = run
    every = document["critical_speeds"]
    tables = critical_speed_tables(document, results.scene.speed_ratios())
    shown, folded = tables[:2]
    count = sum(c["excited"] for c in every)
    assert len(shown.rows) == count and not shown.folded
    rest = sum(not c["excited"] and not c["critically_damped"] for c in every)
    assert len(folded.rows) == rest and f"({rest})" in folded.folded
    assert any("torsional: unbalance excites lateral motion" in row for row in folded.rows)
    assert all(row[-1] for row in folded.rows)


def test_free_frequencies_of_bodies_are_lateral_ones(run, tmp_path):
    results, document = run
    folder = write_results(results, tmp_path / "out", pictures=False)
    side = json.loads((folder / "bodies" / "fast.json").read_text(encoding="utf-8"))
    spring = SHEAR * np.pi * 0.05**4 / 2.0 / 0.4
    (torsion,) = _chain([spring], [POLAR["pinion"], POLAR["driven"]])
    # a third of the inertia of the shaft is 0.7 % of that of the pinion
    assert side["free_torsional_frequency_hz"][0] == pytest.approx(torsion, rel=0.01)
    lateral = side["free_lateral_frequency_hz"]
    assert document["bodies"]["fast"]["free_frequencies_hz"] == lateral
    assert not np.isclose(lateral, torsion, rtol=0.01).any()
    np.testing.assert_allclose(lateral[::2], lateral[1::2], rtol=1e-9)  # pairs
    row = next(r for r in properties_table(document["bodies"]).rows if r[0] == "fast")
    assert f"{side['free_torsional_frequency_hz'][0]:.2f}" not in row[-1]


def test_datasets_hold_kinds_and_shares(run):
    tree = datasets(run[0])
    critical = tree["critical_speeds"]
    assert set(critical["kind"].values) >= {"lateral", "torsional"}
    torsional = critical["share"].sel(family="torsional").values
    assert ((torsional > 0.9) == (critical["kind"].values == "torsional")).all()
    assert set(tree["campbell"]["share"].dims) == {"branch", "speed_rpm", "family"}


def test_torsion_within_the_operating_range_is_no_pass(run):
    """Where the speed of a shaft is its torsional natural frequency, for a torque on it."""
    inside = run[0].analyses["separation_margins"]
    assert inside.headline.startswith("FAIL")
    row = next(m for m in inside.document["margins"] if m["kind"] == "torsional")
    assert row["exciters"] == ["torque"] and row["position"] == "inside"
