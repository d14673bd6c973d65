"""Tables over the load at the loads of a static analysis: lever rule, redundant rotor, refusals."""

from __future__ import annotations

import copy

import numpy as np
import pytest
import scipy.optimize

from solidwhirl.bearing_tables import at_load, read_table
from solidwhirl.build import beam
from solidwhirl.core.errors import SceneError
from solidwhirl.model.effects import make_plan
from solidwhirl.pipeline.cached_stages import engine_part
from solidwhirl.pipeline.run import run_scene
from solidwhirl.rotordyn import AnalysisError
from solidwhirl.rotordyn.assembly.bearing_notes import coefficients_at_speed
from solidwhirl.scene_checks.interface_motions import motions_acted_on
from solidwhirl.scene_reading.reader import parse_scene

G, RHO, MODULUS, NU, RADIUS = 9.80665, 7800.0, 2e11, 0.3, 0.02
STEEL = {"youngs_modulus_pa": MODULUS, "poissons_ratio": NU, "density_kg_per_m3": RHO}
LINE = RHO * np.pi * RADIUS**2 * G
RPM, LOADS = (1000.0, 3000.0, 9000.0), (1.0, 60.0, 250.0)
DISK = {"name": "d", "at_m": 0.2, "mass_kg": 12.0, "polar_inertia_kg_m2": 0.1,
        "diametral_inertia_kg_m2": 0.06}  # fmt: skip
OILY = {"kind": "file", "file": "film.csv", "load_from": "static"}


def film(load, rpm):
    """Stiffness of a film that is stiffer under load, and turns the journal aside."""
    turned = 40.0 * rpm * np.sqrt(load)
    return np.array([[4e4 * load + 50.0 * rpm, turned], [-1.3 * turned, 9e4 * load]])


def written(folder):
    """The film as a file of its maker."""
    heads = [f"k{e} [N/m]" for e in ("xx", "xy", "yx", "yy")] + ["cxx [N·s/m]", "cyy [N·s/m]"]
    rows = [",".join(["load [N]", "speed [rpm]", *heads])]
    for load in LOADS:
        for rpm in RPM:
            values = [*film(load, rpm).ravel().tolist(), 3.0 * load, 5.0 * load]
            rows.append(",".join(f"{v!r}" for v in (load, rpm, *values)))
    (folder / "film.csv").write_text("\n".join(rows))


def scene(folder, places, law=OILY, **changes):
    written(folder)
    stations = sorted({0.0, 0.2, 0.4, 0.6, *places.values()})
    shaft = beam(stations, RADIUS, places, material="own")
    data = {
        "name": "oily",
        "materials": {"own": STEEL},
        "beams": {"s": shaft | {"disks": [DISK]}},
        "bearings": [{"name": n, "first": f"s.{n}", "speed_law": "film"} for n in places],
        "speed_laws": {"film": law},
        "speeds": {"list_rpm": [0.0, 5000.0]},
        "analyses": [{"kind": "static", "speeds_rpm": [3000.0]}],
    }
    return copy.deepcopy(data | changes)


def test_loads_of_two_bearings_are_those_of_the_lever(tmp_path):
    """Every bearing has the table at its own load, with given forces and weight along x."""
    force = {"at": "s.a", "force_n": [5.0, 0.0, 0.0]}
    asked = {"kind": "static", "gravity_m_per_s2": [G, 0, 0], "forces": [force]}
    data = scene(tmp_path, {"a": 0.0, "b": 0.6}, analyses=[asked])
    parsed = parse_scene(data, tmp_path / "s.toml")
    (effect,) = (e for e in make_plan(parsed, {}).effects if e.name == "static_loads")
    assert "of 'static', at each of their speeds: a, b" in effect.why
    results = run_scene(parsed)
    entry = results.analyses["static"]
    weight = 0.5 * LINE * 0.6
    wanted = {"a": weight + 8.0 * G + 5.0, "b": weight + 4.0 * G}
    table = read_table(tmp_path / "film.csv")
    for bearing in results.system.system.bearings:
        own = entry.document["law_loads"][bearing.name]
        np.testing.assert_allclose(own["load_n"], wanted[bearing.name], rtol=1e-9)
        np.testing.assert_allclose(own["speed_of_its_rotor_rpm"], RPM)
        law, at = bearing.speed_law, at_load(table, wanted[bearing.name])
        np.testing.assert_allclose(law.stiffness_n_per_m, at.stiffness_n_per_m[0, :, 0], rtol=1e-8)
        np.testing.assert_allclose(law.damping_n_s_per_m, at.damping_n_s_per_m[0, :, 0], rtol=1e-8)
    (shown,) = (b for b in entry.blocks() if "read at" in getattr(b, "title", ""))
    assert [row[2] for row in shown.rows] == ["1000 to 9000"] * 2
    # the loads are part of what the engine's numbers depend on
    lighter = parse_scene(data | {"analyses": [asked | {"forces": []}]}, tmp_path / "s.toml")
    assert engine_part(lighter) != engine_part(parsed)


def beam_matrices(stations):
    """Stiffness on (u, slope) at the stations and weight on them, of thick beams by hand."""
    area, second = np.pi * RADIUS**2, 0.25 * np.pi * RADIUS**4
    shear = 6.0 * (1.0 + NU) / (7.0 + 6.0 * NU) * area * MODULUS / (2.0 * (1.0 + NU))
    size = 2 * len(stations)
    stiffness, weight = np.zeros((size, size)), np.zeros(size)
    for k, long in enumerate(np.diff(stations)):
        soft = 12.0 * MODULUS * second / (shear * long**2)
        own = np.array([
            [12.0, 6 * long, -12.0, 6 * long],
            [6 * long, (4 + soft) * long**2, -6 * long, (2 - soft) * long**2],
            [-12.0, -6 * long, 12.0, -6 * long],
            [6 * long, (2 - soft) * long**2, -6 * long, (4 + soft) * long**2],
        ])  # fmt: skip
        at = slice(2 * k, 2 * k + 4)
        stiffness[at, at] += MODULUS * second / ((1 + soft) * long**3) * own
        weight[at] += LINE * long / 2 * np.array([1.0, long / 6, 1.0, -long / 6])
    return stiffness, weight


def test_three_bearings_share_the_load_as_their_films_do(tmp_path):
    """The loads are the root that Newton's method finds with beams written out by hand."""
    places = {"a": 0.0, "m": 0.3, "b": 0.6}
    parsed = parse_scene(scene(tmp_path, places), tmp_path / "s.toml")
    entry = run_scene(parsed).analyses["static"]
    stations = [0.0, 0.2, 0.3, 0.4, 0.6]
    bending, weight = beam_matrices(stations)
    size, seats = weight.size, [2 * stations.index(z) for z in places.values()]
    weight[2] += 12.0 * G

    def film_between(load, rpm):
        high = int(np.clip(np.searchsorted(LOADS, load), 1, 2))
        share = (load - LOADS[high - 1]) / (LOADS[high] - LOADS[high - 1])
        return (1 - share) * film(LOADS[high - 1], rpm) + share * film(LOADS[high], rpm)

    def loads_with(loads, rpm):
        """Loads by equilibrium in both planes with the films of given loads."""
        whole = np.kron(np.eye(2), bending)
        films = [film_between(load, rpm) for load in loads]
        for at, own in zip(seats, films, strict=True):
            whole[np.ix_([at, at + size], [at, at + size])] += own
        moved = np.linalg.solve(whole, np.concatenate((np.zeros(size), -weight)))
        forces = [own @ moved[[at, at + size]] for at, own in zip(seats, films, strict=True)]
        return np.linalg.norm(forces, axis=1)

    for k, rpm in enumerate(RPM):
        root = scipy.optimize.root(
            lambda w, rpm=rpm: loads_with(w, rpm) - w, [40.0, 80.0, 40.0], tol=1e-13
        )
        found = [entry.document["law_loads"][n]["load_n"][k] for n in places]
        # loads in and out agree to 1e-9 of the largest, with which the loads shrink by 0.16
        np.testing.assert_allclose(found, root.x, rtol=1e-8, atol=1e-8 * max(root.x))
    assert np.ptp([entry.document["law_loads"]["m"]["load_n"]]) > 1.0  # they do depend on it
    (state,) = entry.document["speeds"]
    own = [state["bearings"][n]["load_n"] for n in places]
    at_speed = [entry.document["law_loads"][n]["load_n"][1] for n in places]
    np.testing.assert_allclose(own, at_speed, rtol=1e-8, atol=1e-8 * max(own))


TWO = {"a": 0.0, "b": 0.6}
CASES = {
    "no analysis": (
        {"analyses": []}, "load_from: no static analysis 'static'", SceneError),
    "another kind": (
        {"law": OILY | {"load_from": "modes"}}, "load_from: no static analysis", SceneError),
    "both": ({"law": OILY | {"load_n": 50.0}}, "give one of the two", SceneError),
    "nothing carries": (
        {"places": {"a": 0.0}}, "no bearing carries the weight of 's' along y", SceneError),
    "beyond the table": (
        {"analyses": [{"kind": "static", "gravity_m_per_s2": [0, -5 * G, 0]}]},
        "bearing 'a': its static load is 536.", AnalysisError),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_what_does_not_fit_is_refused(case, tmp_path):
    changes, said, kind = CASES[case]
    data = scene(tmp_path, **{"places": TWO} | changes)
    with pytest.raises(kind) as caught:
        run_scene(parse_scene(data, tmp_path / "s.toml"))
    assert said in str(caught.value)


def test_tables_that_hold_tilts_ask_for_them(tmp_path):
    """As a table over the frequency does; all tables of a law are of one size."""
    whole, across = (
        {
            "kind": "frequency_table",
            "speed_rpm": [0.0, 9000.0],
            "stiffness_n_per_m": 2 * [np.diag(entries).tolist()],
            "damping_n_s_per_m": 2 * [np.diag(entries).tolist()],
        }
        for entries in ([1e6, 1e6, 1e3, 1e3], [1e6, 1e6])
    )
    over_load = {"kind": "load_table", "load_n": [0.0, 500.0], "tables": [whole, whole]}
    scenes = [parse_scene(scene(tmp_path, TWO, speed_laws={"film": w})) for w in (whole, over_load)]
    of_table, of_load_table = (motions_acted_on(one) for one in scenes)
    assert of_load_table == of_table and [m for m, _ in of_table["s.a"]] == ["rx", "ry"]
    # notes of bearings look at what acts on (ux, uy)
    run, same = map(run_scene, scenes)
    assert same.at_rest.frequency_hz == pytest.approx(run.at_rest.frequency_hz, rel=1e-9)
    of_both = [
        coefficients_at_speed(r.system, r.system.system.bearings[0], 500.0) for r in (run, same)
    ]
    np.testing.assert_allclose(*of_both, rtol=1e-12)
    with pytest.raises(SceneError, match="or size of matrices"):
        parse_scene(
            scene(tmp_path, TWO, speed_laws={"film": over_load | {"tables": [whole, across]}})
        )


def test_one_static_analysis_loads_all_tables(tmp_path):
    laws = {"film": OILY, "other": OILY | {"load_from": "tilted"}}
    analyses = [{"kind": "static"}, {"kind": "static", "name": "tilted"}]
    data = scene(tmp_path, TWO, speed_laws=laws, analyses=analyses)
    with pytest.raises(SceneError, match="all tables are read at those of one static analysis"):
        parse_scene(data, tmp_path / "s.toml")
    written(tmp_path)
    text = (tmp_path / "film.csv").read_text().splitlines()
    one = [line.partition(",")[2] for line in text if line.startswith(("load", "1.0"))]
    (tmp_path / "plain.csv").write_text("\n".join(one))
    data = scene(tmp_path, TWO, law=OILY | {"file": "plain.csv"})
    with pytest.raises(SceneError, match="load_from: the table has no column of loads"):
        parse_scene(data, tmp_path / "s.toml")
