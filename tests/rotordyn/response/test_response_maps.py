"""Response maps against single responses, closed forms, and loading by bearing forces."""

from __future__ import annotations

import numpy as np
import pytest
from rotors import connect, ground, hub, one_rotor, pinned, twin_bodies, twin_rotors
from scipy.optimize import minimize_scalar

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.assembly.coordinates import interface_row, joint_motion
from solidwhirl.rotordyn.assembly.system import with_bearing_stiffness
from solidwhirl.rotordyn.core.errors import NoSteadyResponseError
from solidwhirl.rotordyn.core.ledger import SYSTEMS
from solidwhirl.rotordyn.response import map_peaks, stiffness_maps
from solidwhirl.rotordyn.response.harmonic_response import harmonic_response
from solidwhirl.rotordyn.response.map_peaks import ground_motion_peaks, stiffness_map_peaks
from solidwhirl.rotordyn.response.maps import ground_motion_map, place_map, shown_range
from solidwhirl.rotordyn.response.unbalance import Unbalance, unbalance_response

MASS, STIFFNESS, DAMPING, MOMENT = 10.0, 4e6, 200.0, 3e-4
INNER_C = rd.End(body="inner", interface="C")


def engine(*more):
    """Counter-rotating shafts of which one has internal damping, on damped bearings."""
    inside = rd.InternalDamping(stiffness_coefficient_s=1e-6)
    held = (
        ground("inner", "A", 3e7, 2e7, 900.0),
        ground("inner", "B", 3e7, 3e7, 900.0, 700.0),
        ground("outer", "D", 5e7, 4e7, 500.0),
        connect("C", INNER_C, "outer.C", 2e8, 400.0),
    )
    return rd.assemble(twin_rotors(-1.4, internal_damping=inside), (*held, *more), "inner")


def laval(damping=DAMPING):
    support = ground("rotor", "hub", STIFFNESS, cx=damping, tilt=1e5)
    return one_rotor(hub(mass_kg=MASS), [support])


def laval_map(stiffnesses, omega, damping=DAMPING):
    """Response of the hub to the unbalance there over the stiffness of its support."""
    own = (laval(damping), ["rotor.hub"], stiffnesses, HUB_UNBALANCE, omega, HUB)
    return stiffness_maps.synchronous_stiffness_map(*own)


def ground_amplitude(omega, damping):
    through = STIFFNESS + 1j * omega * damping
    return np.abs(2e-6 * through / (through - MASS * omega**2))


HUB = rd.End(body="rotor", interface="hub")
HUB_UNBALANCE = Unbalance(body="rotor", interface="hub", moment_kg_m=MOMENT)


def test_each_row_of_the_place_map_is_one_unbalance_response():
    system, speeds = engine(), np.array([0.0, 200.0, 650.0])
    places = [INNER_C, rd.End(body="outer", interface="D"), rd.End(body="inner", interface="A")]
    found = place_map(system, places, 2e-5, speeds)
    assert found.translation_m.shape == (3, 3, 5, 2)
    for row, place in enumerate(places):
        unbalance = Unbalance(body=place.body, interface=place.interface, moment_kg_m=2e-5)
        (exciter,) = unbalance_response(system, [unbalance], speeds).exciters
        np.testing.assert_array_equal(found.frequencies_rad_s[row], exciter.frequencies_rad_s)
        for values, expected in (
            (found.translation_m[row], exciter.translation_m),
            (found.major_m()[row], exciter.orbits().major_m),
        ):
            np.testing.assert_allclose(values, expected, rtol=1e-9, atol=1e-24)
    assert found.nodes[1] == INNER_C and not found.translation_m[:, 0].any()


def test_a_force_turns_at_another_speed_than_the_shafts():
    system, speeds, spin = engine(), np.array([0.0, 200.0, 650.0]), 430.0
    place = rd.End(body="outer", interface="D")
    unbalance = Unbalance(body="outer", interface="D", moment_kg_m=2e-5)
    found = place_map(system, [place], 2e-5, speeds, spin)
    (exciter,) = unbalance_response(system, [unbalance], speeds, spin).exciters
    # the equations at the spin, solved for the force that turns against the reference shaft
    ux, uy = (interface_row(system, "outer", "D", component) for component in ("ux", "uy"))
    omega = 1.4 * speeds
    matrices = rd.matrices_at_speed(system, spin)
    for at, rate in enumerate(omega):
        force = 2e-5 * rate**2 * (ux + 1j * uy)
        velocity = matrices.damping + matrices.gyroscopic
        dynamic = matrices.stiffness + 1j * rate * velocity - rate**2 * matrices.mass
        q = np.linalg.solve(dynamic, force)
        expected = [ux @ q, uy @ q]
        for motion in (exciter.at_node("outer", "D"), found.translation_m[0][:, -1]):
            np.testing.assert_allclose(motion[at], expected, rtol=1e-8, atol=1e-20)
    same = unbalance_response(system, [unbalance], [spin], spin).exciters[0]
    own = unbalance_response(system, [unbalance], [spin]).exciters[0]
    np.testing.assert_allclose(same.translation_m, own.translation_m, rtol=1e-12)
    with pytest.raises(rd.AnalysisError, match="spin_rad_s is -1"):
        place_map(system, [place], 2e-5, speeds, -1.0)


@pytest.mark.parametrize("direction", ["x", "y"])
def test_ground_motion_is_loading_by_the_bearings_on_the_ground(direction):
    system = engine()
    speeds, omega = np.array([0.0, 400.0, 1500.0]), np.array([5.0, 300.0, 900.0, 1100.0])
    found = ground_motion_map(system, 3e-6, direction, speeds, omega, INNER_C)
    column = ("x", "y").index(direction)
    # Absolute coordinates: bearings on the ground push with k x_g + c x_g'.
    load = np.zeros((omega.size, system.size), complex)
    for bearing in system.system.bearings:
        if bearing.second is None:
            k, c = bearing.matrices()
            motion = joint_motion(system, bearing)
            dynamic = k[:, column] + 1j * omega[:, None] * c[:, column]
            load += 3e-6 * dynamic @ motion
    rows = [interface_row(system, "inner", "C", component) for component in ("ux", "uy")]
    for at, speed in enumerate(speeds):
        q = harmonic_response(system, speed, omega, load[:, :, None]).displacement[:, :, 0]
        expected = q @ np.array(rows).T
        limit = 1e-10 * np.abs(expected).max()
        np.testing.assert_allclose(found.translation_m[at], expected, rtol=0, atol=limit)


def test_exact_supports_carry_the_ground_motion_on():
    # At low frequency everything follows; an exactly held seat follows at any.
    system = engine(pinned("outer", "C"))
    seat = rd.End(body="outer", interface="C")
    found = ground_motion_map(system, 1e-6, "y", [0.0, 500.0], [0.01, 300.0], seat)
    np.testing.assert_array_equal(found.translation_m[..., 1], 1e-6)
    free = ground_motion_map(system, 1e-6, "y", [500.0], [0.01, 300.0], INNER_C)
    np.testing.assert_allclose(free.translation_m[0, 0], [0.0, 1e-6], rtol=1e-6, atol=1e-13)
    assert abs(free.translation_m[0, 1, 1] - 1e-6) > 1e-9


def test_ground_motion_in_blocks_is_the_same(monkeypatch):
    import solidwhirl.rotordyn.response.maps as maps

    system = engine()
    speeds, omega = np.linspace(0.0, 900.0, 7), np.linspace(0.0, 800.0, 5)
    whole = ground_motion_map(system, 1e-6, "x", speeds, omega, INNER_C)
    monkeypatch.setattr(maps, "_BLOCK_BYTES", 16 * system.size * omega.size * 2)
    blocks = ground_motion_map(system, 1e-6, "x", speeds, omega, INNER_C)
    np.testing.assert_allclose(blocks.translation_m, whole.translation_m, rtol=1e-9, atol=1e-20)


def test_other_bearing_stiffness():
    system = engine()
    changed = with_bearing_stiffness(system, ["inner.A", "outer.D"], 7e7)
    assert dict(changed.system.rotors) == dict(system.system.rotors)
    before = {b.name: b for b in system.system.bearings}
    for bearing in changed.system.bearings:
        old = before[bearing.name]
        if bearing.name in ("inner.A", "outer.D"):
            np.testing.assert_array_equal(bearing.stiffness_n_per_m, 7e7 * np.eye(2))
            np.testing.assert_array_equal(bearing.damping_n_s_per_m, old.damping_n_s_per_m)
        else:
            assert bearing is old
    np.testing.assert_array_equal(before["inner.A"].stiffness_n_per_m, np.diag([3e7, 2e7]))


def test_stiffness_map_of_a_laval_rotor():
    stiffness, omega = np.array([1e5, 4e6, 1e9]), np.linspace(0.0, 1500.0, 40)
    found = laval_map(stiffness, omega)
    dynamic = stiffness[:, None] - MASS * omega**2 + 1j * omega * DAMPING
    expected = MOMENT * omega**2 / dynamic
    np.testing.assert_allclose(found.translation_m[..., 0], expected, rtol=1e-9, atol=1e-25)
    np.testing.assert_allclose(found.translation_m[..., 1], -1j * expected, rtol=1e-9, atol=1e-25)
    np.testing.assert_array_equal(found.speeds_rad_s, omega)


def test_stiffness_map_at_a_speed_keeps_the_gyroscopic_moment():
    system, omega = engine(), np.array([100.0, 400.0, 700.0])
    unbalance = Unbalance(body="outer", interface="D", moment_kg_m=1e-5, phase_rad=0.3)
    names, values = ["inner.A", "inner.B"], np.array([1e7, 1e9])
    given = (system, names, values, unbalance, omega, INNER_C)
    synchronous = stiffness_maps.synchronous_stiffness_map(*given)
    np.testing.assert_allclose(synchronous.speeds_rad_s, omega / 1.4)
    # Where the fixed speed is the synchronous one, both are the same, and elsewhere not.
    speed = float(omega[1] / 1.4)
    fixed = stiffness_maps.stiffness_map_at_speed(*given, speed)
    same = [np.abs(m.translation_m[:, 1]) for m in (fixed, synchronous)]
    np.testing.assert_allclose(*same, rtol=1e-9)
    away = np.abs(fixed.translation_m[:, 2] / synchronous.translation_m[:, 2] - 1)
    assert away.min() > 1e-4
    for at, value in enumerate(values):
        changed = with_bearing_stiffness(system, names, value)
        (exciter,) = unbalance_response(changed, [unbalance], [speed]).exciters
        expected = exciter.at_node("inner", "C")[0]
        np.testing.assert_allclose(fixed.translation_m[at, 1], expected, rtol=1e-9)


@pytest.mark.parametrize("at_speed", [True, False])
def test_stiffnesses_share_one_solution(at_speed):
    system = engine(ground("outer", "C", 1e5, 3e5, 20.0))
    names = [system.system.bearings[0].name, system.system.bearings[3].name]
    unbalance = Unbalance(body="inner", interface="C", moment_kg_m=MOMENT)
    stiffnesses, omega = np.geomspace(1e5, 1e11, 13), np.linspace(0.0, 2500.0, 12)
    given = (system, names, stiffnesses, unbalance, omega, INNER_C)
    with SYSTEMS.counted() as counts:
        if at_speed:
            found = stiffness_maps.stiffness_map_at_speed(*given, 700.0)
        else:
            found = stiffness_maps.synchronous_stiffness_map(*given)
    # one solution of each frequency but 0, not of each stiffness
    assert counts == {"responses": 11}
    for k, row in zip(stiffnesses, found.translation_m, strict=True):
        own = stiffness_maps.stiffness_row(system, found, k, omega, found.speeds_rad_s)
        np.testing.assert_allclose(row, own, rtol=0, atol=1e-10 * np.abs(own).max())


def test_stiffnesses_at_a_resonance_of_the_shared_one_are_solved_by_themselves():
    # without damping the middle one has no response there, the others have
    omega = np.array([100.0, np.sqrt(STIFFNESS / MASS)])
    with pytest.raises(rd.AnalysisError):
        laval_map([0.5 * STIFFNESS, STIFFNESS, 2 * STIFFNESS], omega, 0.0)
    near = np.array([0.5, 1.0 + 1e-9, 2.0]) * STIFFNESS
    found = np.abs(laval_map(near, omega, 0.0).translation_m[..., 0])
    exact = MOMENT * omega**2 / np.abs(near[:, None] - MASS * omega**2)
    np.testing.assert_allclose(found[[0, 2]], exact[[0, 2]], rtol=1e-9)


def test_chosen_stiffness_keeps_resonance_out_of_the_band():
    # For a rigid rotor well above resonance softer is better, down to self-centring; a stiff one
    # is better still: MOMENT ω²/k. Between, the band holds a resonance.
    stiffness, omega = np.logspace(5, 9, 33), np.linspace(0.0, 900.0, 361)
    found = laval_map(stiffness, omega)
    choice = stiffness_maps.choose_stiffness(found, 600.0, 0.2)
    assert choice.band_rad_s == pytest.approx((480.0, 720.0))
    inside = np.linspace(480.0, 720.0, 97)
    dynamic = stiffness[:, None] - MASS * inside**2 + 1j * inside * DAMPING
    peaks = np.abs(MOMENT * inside**2 / dynamic).max(axis=1)
    np.testing.assert_allclose(choice.candidates_m, peaks, rtol=1e-6)
    assert choice.stiffness_n_per_m == stiffness[peaks.argmin()] == 1e9
    assert choice.is_at_end and choice.amplitude_m == pytest.approx(peaks.min())
    resonant = (stiffness > MASS * 480.0**2) & (stiffness < MASS * 720.0**2)
    assert choice.candidates_m[resonant].min() > 3 * MOMENT / MASS
    # Without the stiff end the softest is best.
    soft = laval_map(stiffness[:14], omega)
    assert stiffness_maps.choose_stiffness(soft, 600.0, 0.15).stiffness_n_per_m == stiffness[0]


def test_wrong_arguments_are_refused():
    system, nowhere = engine(), rd.End(body="inner", interface="X")
    for places, message in [
        ([], "places is empty"),
        ([nowhere], "unbalance at inner.X: body 'inner' has no interface"),
    ]:
        with pytest.raises(rd.AnalysisError, match=message):
            place_map(system, places, 1e-5, [1.0])
    for options, message in [
        ({"direction": "z"}, "direction is 'z'; allowed are 'x' and 'y'"),
        ({"amplitude_m": np.nan}, "amplitude_m is nan"),
        ({"frequencies_rad_s": [-1.0]}, "frequencies_rad_s needs a list"),
        ({"node": nowhere}, "node of the response: body 'inner' has no"),
    ]:
        arguments = {
            "amplitude_m": 1e-6, "direction": "x", "speeds_rad_s": [1.0],
            "frequencies_rad_s": [1.0], "node": INNER_C, **options,
        }  # fmt: skip
        with pytest.raises(rd.AnalysisError, match=message):
            ground_motion_map(system, **arguments)
    held = one_rotor(hub(stiffness=1e6 * np.eye(4)), [])
    with pytest.raises(rd.AnalysisError, match="body 'rotor' cannot move along x as a whole"):
        ground_motion_map(held, 1e-6, "x", [1.0], [1.0], HUB)
    for names, value, message in [
        (["A"], 1e6, r"names is \['A'\]; a sequence of one or more of the bearings \['inner.A'"),
        ("inner.A", 1e6, "names is 'inner.A'"),
        ([], 1e6, r"names is \[\]"),
        (["inner.A"], -1.0, "stiffness_n_per_m is -1.0"),
        (["inner.A"], np.inf, "stiffness_n_per_m is inf"),
    ]:
        with pytest.raises(rd.AnalysisError, match=message):
            with_bearing_stiffness(system, names, value)
    rigid = one_rotor(twin_bodies()[0], [pinned("rotor", end) for end in ("A", "B")])
    with pytest.raises(rd.AnalysisError, match=r"bearing 'rotor.A' joins \['ux', 'uy'\] rigidly"):
        with_bearing_stiffness(rigid, ["rotor.A"], 1e6)


def test_wrong_choices_are_refused():
    omega = np.linspace(0.0, 900.0, 91)
    found = laval_map([1e6], omega)
    for center, margin, message in [
        (-1.0, 0.2, "operating_frequency_rad_s is -1.0"),
        (500.0, 0.0, "margin 0.0"),
        (800.0, 0.2, r"the band 640 to 960 rad/s .* within 0 to 900"),
        (500.0, 0.01, "needs 5 frequencies"),
    ]:
        with pytest.raises(rd.AnalysisError, match=message):
            stiffness_maps.choose_stiffness(found, center, margin)
    with pytest.raises(rd.AnalysisError, match="needs a rising list"):
        laval_map([2.0, 1.0], omega)
    with pytest.raises(rd.AnalysisError, match="speed_rad_s is -1"):
        stiffness_maps.stiffness_map_at_speed(
            laval(), ["rotor.hub"], [1e6], HUB_UNBALANCE, omega, HUB, speed_rad_s=-1.0
        )


@pytest.mark.parametrize("count", [2, 300])
@pytest.mark.parametrize("damping", [20.0, 0.2])
def test_peaks_of_ground_motion_do_not_hang_on_the_frequencies(count, damping):
    # Damping ratios of 1.6e-3 and 1.6e-5: a resonance of 2 and 0.02 rad/s in steps of 5 to 1500.
    omega = np.linspace(0.0, 1500.0, count)
    system = laval(damping=damping)
    found = ground_motion_map(system, 2e-6, "y", [0.0, 300.0], omega, HUB)
    peaks = ground_motion_peaks(system, found)
    assert peaks.height_m.shape == peaks.frequency_rad_s.shape == (2, count)
    natural = np.sqrt(STIFFNESS / MASS)
    highest = ground_amplitude(natural * (1.0 + np.linspace(-3e-5, 3e-5, 6001)), damping).max()
    for height, place in zip(peaks.height_m, peaks.frequency_rad_s, strict=True):
        at = int(height.argmax())
        assert height[at] == pytest.approx(highest, rel=1e-4)
        assert place[at] == pytest.approx(natural, rel=1e-5)
        assert at == np.abs(omega - natural).argmin()
    assert (peaks.height_m >= found.major_m()).all()


def test_maps_without_sharp_resonances_need_no_more_frequencies():
    # A damping ratio of 0.8, and no mode of tilt in the range: none is narrower than a few steps.
    for omega in (np.linspace(0.0, 300.0, 2), np.linspace(0.0, 300.0, 300)):
        system, tried = laval(1e4), laval_map([3e6], omega, 1e4)
        shaken = ground_motion_map(system, 2e-6, "x", [0.0, 300.0], omega, HUB)
        assert (ground_motion_peaks(system, shaken).height_m >= shaken.major_m()).all()
        assert (stiffness_map_peaks(system, tried).height_m >= tried.major_m()).all()


def test_a_sharp_resonance_between_two_frequencies_is_not_chosen():
    # The supports of 3.6e6 N/m resonate at 600 rad/s, 1 rad/s away from the nearest frequency.
    stiffness, omega = np.array([3.6e6, 6e6]), np.linspace(0.5, 900.5, 451)
    system, map_ = laval(damping=2.0), laval_map(stiffness, omega, 2.0)
    peaks = stiffness_map_peaks(system, map_)
    for row, value in zip(peaks.height_m, stiffness, strict=True):
        natural = np.sqrt(value / MASS)
        assert row.max() == pytest.approx(MOMENT * natural / 2.0, rel=1e-4)  # u ω² / (c ω)
    without, with_peaks = (
        stiffness_maps.choose_stiffness(map_, 600.0, 0.2, known).candidates_m[0]
        for known in (None, peaks)
    )
    assert with_peaks == pytest.approx(MOMENT * 600.0 / 2.0, rel=1e-4)
    assert without < 0.5 * with_peaks
    # at one speed alone the resonance is the same
    fixed = stiffness_maps.stiffness_map_at_speed(
        system, ["rotor.hub"], stiffness, HUB_UNBALANCE, omega, HUB, 300.0
    )
    same = stiffness_map_peaks(system, fixed)
    np.testing.assert_allclose(same.height_m.max(axis=1), peaks.height_m.max(axis=1), rtol=1e-6)


def test_colours_of_a_map_leave_room_for_what_is_not_resonant():
    quiet = np.geomspace(0.1, 10.0, 101)  # its median is 1
    assert shown_range(quiet) == pytest.approx((0.1, 10.0))
    with_peak = np.append(quiet, [1e9, 0.0, np.nan])
    low, high = shown_range(with_peak)
    assert low == pytest.approx(0.1) and high == pytest.approx(1e3, rel=0.1)
    assert shown_range([1e-9, *quiet, *quiet])[0] == pytest.approx(1e-5 * 10.0)
    assert shown_range([2.0, 2.0]) == pytest.approx((1.998, 2.0))
    with pytest.raises(rd.AnalysisError, match="all responses of the map are zero"):
        shown_range([0.0, np.nan])


@pytest.mark.parametrize("count", [12, 400])
@pytest.mark.parametrize("damping", [2.0, 200.0, 2500.0])
def test_heights_of_peaks_are_off_by_less_than_they_say(count, damping):
    """Damping ratios of 1.6e-4 to 0.2: sharp, and so broad that the frequencies show them."""
    system, omega = laval(damping=damping), np.linspace(100.0, 1500.0, count)
    shaken = ground_motion_map(system, 2e-6, "y", [0.0, 300.0], omega, HUB)
    turned = laval_map([STIFFNESS], omega, damping)

    def unbalance(rate):
        through = STIFFNESS + 1j * rate * damping - MASS * rate**2
        return np.abs(MOMENT * rate**2 / through)

    for peaks, curve in (
        (ground_motion_peaks(system, shaken), lambda rate: ground_amplitude(rate, damping)),
        (stiffness_map_peaks(system, turned), unbalance),
    ):
        natural = np.sqrt(STIFFNESS / MASS)  # offsets from it, as the search needs their digits
        found = minimize_scalar(
            lambda offset, curve=curve, natural=natural: -curve(natural + offset),
            bounds=(-0.25 * natural, 0.25 * natural), method="bounded", options={"xatol": 1e-9},
        )  # fmt: skip
        for heights, errors in zip(peaks.height_m, peaks.sampling_error, strict=True):
            at = heights.argmax()
            off = abs(heights[at] / -found.fun - 1.0)
            assert off <= errors[at] + 1e-11
            assert off < 1e-6 and errors[at] < 1e-4


def test_peaks_without_damping_have_no_height():
    omega = np.linspace(100.0, 1500.0, 61)
    system = laval(damping=0.0)
    peaks = ground_motion_peaks(system, ground_motion_map(system, 1e-6, "x", [0.0], omega, HUB))
    assert peaks.sampling_error[0, peaks.height_m[0].argmax()] == np.inf


@pytest.mark.parametrize("rounding", [0.0, 1e-3])
def test_the_top_of_a_peak_of_hardly_any_width_is_found(rounding):
    """Points around it come together to rounding; the response there is bounded by rounding too.

    `rounding`: by which the same point differs from one solution to the next.
    """

    def respond(frequencies):
        assert np.isfinite(frequencies).all()
        motion = (1.0 + rounding * frequencies.size) / (100.0 - frequencies + 1e-14j)
        return np.stack((motion, 0.0 * motion), axis=1)

    known = np.array([99.0, np.nextafter(100.0, 0.0), 100.0, np.nextafter(100.0, 200.0), 101.0])
    row = map_peaks.Row(known, respond(known), respond)
    place, top, error = map_peaks.summits(row, np.abs(row.motion[:, 0]))
    assert place == pytest.approx([100.0], rel=1e-15)
    assert top == pytest.approx([1e14], rel=10.0 * rounding + 1e-6)
    assert np.isfinite(error).all()


@pytest.mark.parametrize("lost", [1e-9, 1.0])
def test_a_peak_without_steady_response_keeps_its_highest_point(lost):
    """No height is known then: the error is infinite, and other peaks are found."""

    def respond(frequencies):
        if (np.abs(frequencies - 100.0) < lost).any():
            raise NoSteadyResponseError("undamped")
        motion = 1.0 / (100.0 - frequencies) + 1.0 / (200.0 - frequencies + 0.5j)
        return np.stack((motion, 0.0 * motion), axis=1)

    known = np.array([97.0, 98.5, 101.5, 103.0, 199.0, 199.9, 201.0])
    row = map_peaks.Row(known, respond(known), respond)
    place, top, error = map_peaks.summits(row, np.abs(row.motion[:, 0]))
    assert error[0] == np.inf and top[0] >= np.abs(row.motion[1:3, 0]).max()
    assert place[1] == pytest.approx(200.0, rel=1e-3) and error[1] < 1e-2


def test_a_peak_at_equal_points_without_steady_response_keeps_its_place():
    """Points one to rounding, some without a height: the next ones are still between them."""
    asked = []

    def respond(frequencies):
        asked.extend(frequencies)
        raise NoSteadyResponseError("undamped")

    known = np.array([99.0, 100.0, np.nextafter(100.0, 200.0), 101.0])
    motion = np.array([1.0, 1e14, 1e13, 1.0])[:, None] * [1.0, 0.0]
    row = map_peaks.Row(known, motion + 0j, respond)
    place, top, error = map_peaks.summits(row, motion[:, 0])
    assert np.isfinite(asked).all() and place == pytest.approx([100.0], rel=1e-2)
    assert (top, error) == ([1e14], [np.inf])
