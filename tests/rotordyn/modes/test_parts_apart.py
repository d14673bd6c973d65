"""Shafts that only meet in a casing that is held, each by itself, against the whole at once."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg as la
from rotors import connect, polynomial_law, rigid_body, steel_shaft, turning

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.checks.mode_counts import full_spectrum
from solidwhirl.rotordyn.checks.plain_system import PlainSystem
from solidwhirl.rotordyn.core import dense
from solidwhirl.rotordyn.core.ledger import SYSTEMS
from solidwhirl.rotordyn.critical_speeds.search import count_critical_speeds
from solidwhirl.rotordyn.critical_speeds.whirl_pencils import Pencil
from solidwhirl.rotordyn.modes.nearby import nearby_modes
from solidwhirl.rotordyn.response.unbalance import Unbalance, unbalance_response
from solidwhirl.rotordyn.run_up import complexity, integration
from solidwhirl.rotordyn.run_up.speed_profile import ramp_and_hold

LAW = polynomial_law((1.0, -3e-4, 2e-7), (1.0, -3e-4, 2e-7), top=2000.0)
SPEED = 700.0


def shaft(name, radius):
    seats = {"left": 0.1, "middle": 0.5, "right": 0.9}
    disks = [(0.5, 12.0, 0.3, 0.2)]
    lateral = ("ux", "uy", "rx", "ry")
    return steel_shaft(name, np.linspace(0.0, 1.0, 6), radius, seats, disks, components=lateral)


def engine(across=1.0, between=None):
    """Two shafts on a rigid casing; `across`: stiffness in y over that in x of one bearing."""
    held = ("ux", "uy", "rx", "ry")
    places = {"a": 0.1, "b": 0.9, "c": 0.1, "d": 0.9, "foot": 0.43}
    casing = rigid_body("casing", 300.0, 0.5, [20.0, 20.0, 9.0], places)
    bearings = [
        connect("a", "one.left", "casing.a", (3e7, across * 3e7), 900.0, speed_law=LAW),
        connect("b", "one.right", "casing.b", 3e7, 900.0, speed_law=LAW),
        connect("c", "two.left", "casing.c", 2e7, 700.0, speed_law=LAW),
        connect("d", "two.right", "casing.d", 2e7, 700.0, speed_law=LAW),
        connect("foot", "casing.foot", None, rigid=held),
    ]
    bearings += [connect("inter", "one.middle", "two.middle", between)] if between else []
    bodies = {"one": turning(shaft("one", 0.03)), "two": turning(shaft("two", 0.025), -1.3)}
    return rd.assemble({**bodies, "casing": turning(casing, 0.0)}, tuple(bearings), "one")


def groups_of(system):
    matrices = rd.matrices_at_speed(system, SPEED)
    return [at.size for at in dense.uncoupled(*matrices)]


def test_a_casing_that_is_held_joins_nothing():
    """To the last bit: no rounding of the tied body is left between the shafts."""
    apart = groups_of(engine())
    assert len(apart) == 2 and sum(apart) == engine().size
    assert groups_of(engine(between=1e6)) == [engine().size]


@pytest.mark.parametrize("across", [1.0, 0.7])
def test_eigenvalues_of_shafts_are_those_of_the_whole(across, monkeypatch):
    system = engine(across)
    with SYSTEMS.counted() as counts:
        found = rd.modes_at_speed(system, SPEED)
    assert counts["eigenproblems"] <= 2
    plain = full_spectrum(PlainSystem.of(system).at(SPEED), 500.0)
    known = np.sort(plain.imag[plain.imag > 1.0])
    np.testing.assert_allclose(found.eigenvalues.imag, known, rtol=1e-8)
    sizes = []
    solve = la.eig
    monkeypatch.setattr(la, "eig", lambda m, **how: sizes.append(len(m)) or solve(m, **how))
    rd.modes_at_speed(engine(across), SPEED)  # one of which nothing is kept
    # half of it in complex coordinates
    states = 1 if across == 1.0 else 2
    assert sizes == [states * size for size in groups_of(system)]
    monkeypatch.setattr(dense, "uncoupled", lambda *m: [np.arange(len(m[0]))])
    whole = rd.modes_at_speed(engine(across), SPEED)
    np.testing.assert_allclose(found.eigenvalues, whole.eigenvalues, rtol=1e-11)


def test_critical_speeds_of_shafts_are_those_of_the_whole(monkeypatch):
    system = engine()
    found = rd.critical_speeds(system, 1.0, 1500.0)
    counted = count_critical_speeds(system, 1.0, 1500.0).count
    monkeypatch.setattr(dense, "uncoupled", lambda *m: [np.arange(len(m[0]))])
    monkeypatch.setattr(Pencil, "apart", lambda pencil: [pencil])
    again = engine()
    whole = rd.critical_speeds(again, 1.0, 1500.0)
    assert len(found) == len(whole) == counted
    assert count_critical_speeds(again, 1.0, 1500.0).count == counted
    for one, other in zip(found, whole, strict=True):
        assert one.whirl == other.whirl
        np.testing.assert_allclose(one.speed_rad_s, other.speed_rad_s, rtol=1e-10)
        np.testing.assert_allclose(one.log_decrement, other.log_decrement, rtol=1e-8)


def test_nearby_modes_are_found_in_what_they_move():
    """Of two shafts at once, each in its own coordinates."""
    system = engine()
    matrices, modes = rd.matrices_at_speed(system, SPEED), rd.modes_at_speed(system, SPEED)
    at = dense.uncoupled(*matrices)
    one, two = (np.flatnonzero(modes.shapes[group].any(axis=0)) for group in at)
    apart = np.abs(np.subtract.outer(modes.eigenvalues[one], modes.eigenvalues[two]))
    nearest = np.unravel_index(int(apart.argmin()), apart.shape)
    pair = [int(one[nearest[0]]), int(two[nearest[1]])]
    for columns in ([pair[0]], pair):
        rate = complex(modes.eigenvalues[columns].mean()) * 1.001
        values, shapes = nearby_modes(matrices, rate, modes.shapes[:, columns])
        np.testing.assert_allclose(
            np.sort_complex(values), np.sort_complex(modes.eigenvalues[columns]), rtol=1e-10
        )
        for value, shape in zip(values, shapes.T, strict=True):
            moved = [bool(shape[group].any()) for group in at]
            assert sum(moved) == 1
            assert np.abs(modes.eigenvalues - value).min() <= 1e-10 * abs(value)


UNBALANCES = (
    Unbalance(body="one", interface="middle", moment_kg_m=1e-4),
    Unbalance(body="two", interface="middle", moment_kg_m=2e-4, phase_rad=0.7),
)


def test_models_share_the_run_ups_of_what_is_the_same_in_them(monkeypatch):
    """Each shaft flexible and rigid once; the force in the foot is that of each model alone."""
    full = engine()
    names = [[], ["one"], ["two"], ["one", "two"]]
    variants = {str(own): complexity.rigid_bodies_system(full, own) for own in names}
    profile = ramp_and_hold(500.0, 0.1, 0.06)
    settings = {"step_s": 2e-4, "bearing": "foot", "bands_hz": [(15.0, 80.0)]}
    runs = []
    solve = integration._integrated
    monkeypatch.setattr(
        integration, "_integrated", lambda *own, **how: runs.append(own) or solve(*own, **how)
    )
    shared = complexity.compare_complexity(variants, profile, UNBALANCES, **settings)
    assert len(runs) == 4
    # the forecast asks the run-up itself, without a step
    foreseen = {}
    asked = {"known": foreseen, "step_s": 2e-4, "bearings": ["foot"]}
    todo = [
        at
        for system in variants.values()
        for at in integration.parts_to_run(system, profile, UNBALANCES, **asked)
    ]
    flexible = groups_of(full)
    assert sorted(at.size for at in todo) == sorted([*flexible, 4, 4])
    assert integration.parts_to_run(full, profile, UNBALANCES, **asked) == []
    more = {**asked, "outputs": [rd.End(body="one", interface="middle")]}
    assert len(integration.parts_to_run(full, profile, UNBALANCES, **more)) == 2
    for name, system in variants.items():
        alone = complexity.compare_complexity({name: system}, profile, UNBALANCES, **settings)
        at = shared.names.index(name)
        np.testing.assert_allclose(shared.peak_force_n[at], alone.peak_force_n[0], rtol=1e-9)
    assert len(runs) == 4 + 2 * len(variants)
    parts = {}
    integration.run_up(
        full, profile, UNBALANCES, known=parts, step_s=2e-4, bearings=["foot"],
        outputs=[rd.End(body="one", interface="middle")],
    )  # fmt: skip
    runs.clear()
    again = complexity.compare_complexity(variants, profile, UNBALANCES, known=parts, **settings)
    assert len(runs) == 2  # the rigid ones
    np.testing.assert_array_equal(again.peak_force_n, shared.peak_force_n)


def test_response_is_solved_in_the_shaft_that_is_loaded():
    """One shaft alone, as if the other were not there."""
    system, speeds = engine(), np.array([0.0, 200.0, SPEED])
    both = unbalance_response(system, UNBALANCES, speeds)
    for exciter, unbalance in zip(both.exciters, UNBALANCES, strict=True):
        (alone,) = unbalance_response(engine(between=1e-300), [unbalance], speeds).exciters
        size = np.nanmax(np.abs(alone.translation_m))
        np.testing.assert_allclose(
            exciter.translation_m, alone.translation_m, rtol=1e-9, atol=1e-12 * size
        )
