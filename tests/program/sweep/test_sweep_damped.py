"""A sweep over bearings with much damping: every mode is one track, whatever comes and goes."""

from __future__ import annotations

import numpy as np
import pytest
from engine_parts import rigid_rotor

from solidwhirl.batch.rows import row_of_document
from solidwhirl.build import beam, bearing
from solidwhirl.output.documents import results_document
from solidwhirl.pipeline.run import run_scene
from solidwhirl.rotordyn.campbell.branch_numbers import modal_assurance
from solidwhirl.scene_reading.reader import parse_scene
from solidwhirl.sweep.analysis import SweepPictureSettings, analyse_sweep
from solidwhirl.sweep.bands import LEVELS, campbell_bands
from solidwhirl.sweep.design import sweep_designs
from solidwhirl.sweep.matching import match_curves
from solidwhirl.sweep.records import BatchCase
from solidwhirl.sweep.tracks import critical_tracks, quantities

RPM = 30.0 / np.pi
MASS, LENGTH, RADIUS, TOP_RPM = 40.0, 0.8, 0.03, 12000.0
STIFFNESS, DAMPING = (5e7, 1.3e8), (2e3, 8e3, 3e4, 1.2e5, 5e5)
OPERATING_RPM = (7000.0, 8000.0)


def scene(stiffness, damping):
    """A disk in the middle of a light shaft: lateral and conical motion do not couple."""
    light = {"density_kg_per_m3": 1.0, "youngs_modulus_pa": 2.1e11, "poissons_ratio": 0.3}
    disk = {"name": "disk", "at_m": LENGTH / 2, "mass_kg": MASS}
    disk |= {"polar_inertia_kg_m2": 0.5, "diametral_inertia_kg_m2": 0.3}
    places = {"left": 0.0, "disk": LENGTH / 2, "right": LENGTH}
    stations = [0.0, 0.2, 0.4, 0.6, LENGTH]
    film = {"stiffness_n_per_m": stiffness, "damping_n_s_per_m": damping}
    low, high = OPERATING_RPM
    operating = [{"shaft": "rotor", "from_rpm": low, "to_rpm": high}]
    return {
        "name": "films",
        "materials": {"light": light},
        "speeds": {"from_rpm": 0.0, "to_rpm": TOP_RPM, "count": 3},
        "campbell": {"branches": 8},
        "model": {"estimates": "off"},
        "beams": {"rotor": beam(stations, RADIUS, places, material="light", disks=[disk])},
        "bearings": [bearing(end, f"rotor.{end}", **film) for end in ("left", "right")],
        "analyses": [
            {"kind": "separation_margins", "operating": operating},
            {"kind": "stability", "to_rpm": TOP_RPM, "count": 3},
        ],
    }


def films(stiffness, damping):
    """The disk beside the middle of a stiffer shaft; films differ in x and y."""
    data = scene([stiffness, 2.2 * stiffness], [damping, 1.5 * damping])
    rotor = data["beams"]["rotor"]
    rotor |= {"outer_radius_m": [0.045], "stations_m": [0.0, 0.2, 0.3, 0.6, LENGTH]}
    rotor["interfaces"]["disk"] = rotor["disks"][0]["at_m"] = 0.3
    data["speeds"]["to_rpm"] = 20000.0
    return data | {"analyses": []}


def row_of(number, values, data):
    """The row of a case that is run here."""
    case = BatchCase(
        name=f"{data['name']}-{number:04d}", scene_path=None, values=values, data=data, digest=""
    )
    document = results_document(run_scene(parse_scene(data, "test")))
    return row_of_document(case, document, 0.0, 1)


def table(make, stiffness, damping):
    pairs = [(k, c) for k in stiffness for c in damping]
    names = ("stiffness_n_per_m", "damping_n_s_per_m")
    return [row_of(n, dict(zip(names, p, strict=True)), make(*p)) for n, p in enumerate(pairs)]


def lateral_root(stiffness, damping):
    """Least damped root of m s² + (1/k + 1/(2 (kb + cb s)))^-1 = 0, rad/s.

    k is that of a simply supported Timoshenko beam with a force in the middle; Cowper's shear
    coefficient of the circle is 6 (1 + nu) / (7 + 6 nu).
    """
    modulus, nu = 2.1e11, 0.3
    bending = modulus * np.pi * RADIUS**4 / 4.0
    shear = 6 * (1 + nu) / (7 + 6 * nu) * modulus / (2 * (1 + nu)) * np.pi * RADIUS**2
    k = 1.0 / (LENGTH**3 / (48.0 * bending) + LENGTH / (4.0 * shear))
    kb, cb = 2.0 * stiffness, 2.0 * damping
    # (m s² (k + kb + cb s) + k (kb + cb s)) = 0
    roots = np.roots([MASS * cb, MASS * (k + kb), k * cb, k * kb])
    return max(roots[roots.imag > 0.0], key=lambda s: s.real)


@pytest.fixture(scope="module")
def rows():
    return table(scene, STIFFNESS, DAMPING)


@pytest.mark.verify
@pytest.mark.solver
def test_the_first_forward_mode_is_one_track_through_all_cases(rows):
    (design,) = sweep_designs(rows)
    tracks = critical_tracks(design)
    roots = [lateral_root(**_short(row.values)) for row in rows]
    expected = np.array([root.imag * RPM for root in roots])
    # the rule leaves it in: its amplification factor is above 2.5 in all cases
    assert max(-2.0 * np.pi * root.real / root.imag for root in roots) < np.pi / 2.5
    for whirl in ("forward", "backward"):
        own = [t for t in tracks if t.whirl == whirl and np.isfinite(t.speed_rpm).all()]
        found = [t for t in own if np.allclose(t.speed_rpm, expected, rtol=2e-3)]
        assert len(found) == 1, (whirl, [t.speed_rpm for t in own])
        assert not found[0].doubtful.any()
    every = [speed for row in rows for speed in row.critical_speed_rpm]
    assert sum(np.isfinite(t.speed_rpm).sum() for t in tracks) == len(every)
    # notes tell nothing of the modes that are everywhere
    (found,) = analyse_sweep(rows, SweepPictureSettings())
    everywhere = [t.name for t in tracks if np.isfinite(t.speed_rpm).all()]
    assert len(everywhere) >= 2
    assert not [n for n in found.notes for name in everywhere if n.startswith(f"{name}:")]


@pytest.mark.verify
@pytest.mark.solver
def test_a_mode_stays_one_track_where_its_whirl_changes():
    """Sixteen cases between little and too much damping: the words for the whirl change, two
    modes stay two. By words and order alone there were three tracks, seven cases in doubt."""
    rows = table(films, (1.5e7, 3e7, 6e7, 1.2e8), (5e3, 1.5e4, 4e4, 1e5))
    (design,) = sweep_designs(rows)
    tracks = critical_tracks(design)
    assert len(tracks) == 2
    assert not any(t.doubtful.any() for t in tracks)
    assert all(len(t.whirl.split("/")) > 1 for t in tracks)
    low, high = (t.speed_rpm.reshape(4, 4) for t in tracks)
    both = np.isfinite(low) & np.isfinite(high)
    assert both.sum() >= 12
    assert (low[both] < high[both]).all()
    # both rise with the stiffness where there is little damping: the first column
    assert (np.diff(low[:, 0]) > 0.0).all() and (np.diff(high[:, 0]) > 0.0).all()


def _short(values):
    return {key.split("_")[0]: value for key, value in values.items()}


@pytest.mark.solver
def test_the_table_has_what_a_design_review_asks_for(rows):
    (design,) = sweep_designs(rows)
    for row in rows:
        root = lateral_root(**_short(row.values))
        assert row.responses["verdict.stable"] == 1.0
        assert "verdict.unstable_from_rpm" not in row.responses
        first = row.responses["verdict.first_forward_log_decrement"]
        assert first == pytest.approx(-2.0 * np.pi * root.real / root.imag, rel=5e-3)
        assert row.responses["verdict.margins_passed"] in (0.0, 1.0)
    names = [q.name for q in quantities(design, critical_tracks(design))]
    assert "verdict.first_forward_log_decrement" in names
    # what is yes or no has no sensitivity
    assert not {"verdict.stable", "verdict.margins_passed"} & {*names}


def test_shapes_part_what_values_would_join():
    """Two modes cross between two cases; one of them changes the name of its whirl."""
    bounce, tilt = np.array([1.0, -1j, 1.0, -1j]), np.array([1.0, -1j, -1.0, 1j])
    places = np.array([[0.0], [1.0]])
    curves = [np.array([[100.0], [130.0]]), np.array([[105.0], [125.0]])]
    shapes = [np.array([bounce, tilt]), np.array([1j * tilt, 2.0 * bounce])]
    kinds = [[(0, "forward")] * 2, [(0, "mixed"), (0, "forward")]]
    apart = [[(0, "")] * 2] * 2
    assert match_curves(places, curves, kinds).index.tolist() != [[1, 0], [0, 1]]
    found = match_curves(places, curves, apart, shapes)
    assert {tuple(row) for row in found.index.tolist()} == {(0, 1), (1, 0)}
    assert not found.doubtful.any()


def test_likeness_is_that_of_shapes_not_of_their_scale_or_phase():
    forward, backward, none = [1.0, -1j], [1.0, 1j], [0.0, 0.0]
    first = np.array([forward, none], dtype=complex)
    second = np.array([[3j, 3.0], backward, none], dtype=complex)
    assert modal_assurance(first, second) == pytest.approx(np.array([[1, 0, 0], [0, 0, 1]]))


@pytest.fixture(scope="module")
def crossing_rows():
    """Rigid rotors held symmetrically: translation √(2k/m), tilt l √(2k/I), whichever is lower."""
    draw, found = np.random.default_rng(5), []
    for number in range(24):
        mass, tilt = draw.uniform(8.0, 16.0), draw.uniform(0.9, 2.6)
        data = rigid_rotor(
            1e6,
            1e6,
            rpm=(0.0, 3000.0),
        )
        data["rigid_bodies"]["rotor"] |= {"mass_kg": mass, "inertia_kg_m2": [tilt, tilt, 0.05]}
        found.append(row_of(number, {"mass_kg": mass, "tilt": tilt}, data))
    return found


def test_bands_follow_modes_that_cross(crossing_rows):
    """By frequencies alone the bands of translation and tilt exchange cases."""
    (design,) = sweep_designs(crossing_rows)
    found = campbell_bands(design)
    assert found.cases == 24 and not found.doubtful.any()
    at_rest = {
        "translation": [np.sqrt(2e6 / r.values["mass_kg"]) for r in crossing_rows],
        "tilt": [0.4 * np.sqrt(2e6 / r.values["tilt"]) for r in crossing_rows],
    }
    both = np.array(list(at_rest.values()))
    assert 4 < np.count_nonzero(both[0] < both[1]) < 20  # they cross
    wanted = np.quantile(both / (2 * np.pi), LEVELS, axis=1)  # (levels, modes)
    bands = found.frequency_hz.value[:, :, 0]
    off = np.abs(bands[:, :, None] / wanted[:, None] - 1.0).max(axis=0)
    assert bands.shape[1] == 4
    assert np.count_nonzero(off < 1e-9, axis=0).tolist() == [2, 2]
