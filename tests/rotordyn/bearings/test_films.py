"""Short films against closed forms, printed numbers, quadrature and difference quotients."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy.integrate import quad

from solidwhirl.rotordyn import AnalysisError
from solidwhirl.rotordyn.bearings.short_bearing import exceeded, journal_state
from solidwhirl.rotordyn.bearings.short_film import ShortFilm
from solidwhirl.rotordyn.bearings.squeeze_film import SqueezeFilmDamper

# Friswell et al. (2010), section 5.5.1: 525 N, 1500 rpm, and ε, K and C as printed there.
OIL = ShortFilm(diameter_m=0.1, length_m=0.03, radial_clearance_m=1e-4, viscosity_pa_s=0.1)
FULL = dataclasses.replace(OIL, film="2pi")
SPEED = 1500 * np.pi / 30


def closed_form(e):
    """K c/W and C c ω/W, load along −y, spin from x to y, after Friswell et al., p. 177."""
    p, s = np.pi**2, np.sqrt(1 - e * e)
    h = (p * (1 - e**2) + 16 * e**2) ** -1.5
    kxx = 4 * h * (p * (2 - e**2) + 16 * e**2)
    kyy = 4 * h * (p * (1 + 2 * e**2) + 32 * e**2 * (1 + e**2) / (1 - e**2))
    kxy = h * np.pi * (p * (1 - e**2) ** 2 - 16 * e**4) / (e * s)
    kyx = -h * np.pi * (p * (1 - e**2) * (1 + 2 * e**2) + 32 * e**2 * (1 + e**2)) / (e * s)
    cxx = 2 * np.pi * h * s * (p * (1 + 2 * e**2) - 16 * e**2) / e
    cxy = -8 * h * (p * (1 + 2 * e**2) - 16 * e**2)
    cyy = 2 * np.pi * h * (p * (1 - e**2) ** 2 + 48 * e**2) / (e * s)
    return np.array([[kxx, kxy], [kyx, kyy]]), np.array([[cxx, cxy], [cxy, cyy]])


def load_at(e):
    """W of the π film over ½ B₀ c Ω."""
    return 0.5 * e / (1 - e**2) ** 2 * np.sqrt(16 * e**2 + np.pi**2 * (1 - e**2))


def test_printed_journal_bearing():
    found = journal_state(OIL, (0.0, -525.0), SPEED)
    assert found.eccentricity_ratio == pytest.approx(0.266298, abs=6e-7)
    assert np.degrees(found.attitude_rad) == pytest.approx(70.620, abs=6e-4)
    k, c = found.stiffness_n_per_m / 1e6, found.damping_n_s_per_m / 1e3
    np.testing.assert_allclose(k, [[12.8080, 16.3936], [-25.0604, 8.8153]], atol=6e-5)
    np.testing.assert_allclose(c, [[232.897, -81.924], [-81.924, 294.912]], atol=6e-4)
    assert exceeded(OIL, found) == ()


@pytest.mark.parametrize("ratio", [1e-6, 0.1, 0.5, 0.9, 0.995])
def test_journal_bearing_against_the_closed_form(ratio):
    unit = 0.5 * OIL.scale_n_s_per_m * 1e-4 * SPEED
    load = load_at(ratio) * unit
    found = journal_state(OIL, (0.0, -load), SPEED)
    assert found.eccentricity_ratio == pytest.approx(ratio, rel=1e-11)
    force = OIL.force(found.place_m, np.zeros(2), SPEED).force_n
    np.testing.assert_allclose(force, [0.0, load], atol=1e-11 * load)
    k, c = closed_form(ratio)
    scale = load / 1e-4
    np.testing.assert_allclose(found.stiffness_n_per_m / scale, k, atol=1e-9 * abs(k).max())
    np.testing.assert_allclose(found.damping_n_s_per_m * SPEED / scale, c, atol=1e-9 * c.max())


def test_load_in_any_direction_and_either_sense():
    """A turned load turns the matrices; turned the other way they are those in a mirror."""
    first = journal_state(OIL, (0.0, -525.0), SPEED)
    angle = 0.7
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    turned = journal_state(OIL, tuple(turn @ [0.0, -525.0]), SPEED)
    back = journal_state(OIL, (0.0, -525.0), -SPEED)
    for name in ("stiffness_n_per_m", "damping_n_s_per_m"):
        own = getattr(first, name)
        np.testing.assert_allclose(getattr(turned, name), turn @ own @ turn.T, rtol=1e-9)
        mirror = own * [[1, -1], [-1, 1]]
        np.testing.assert_allclose(getattr(back, name), mirror, rtol=1e-9)


def test_full_film():
    load = 525.0
    found = journal_state(FULL, (load, 0.0), SPEED)
    e, b = found.eccentricity_ratio, FULL.scale_n_s_per_m
    left = 1 - e**2
    assert load == pytest.approx(np.pi * b * SPEED * 1e-4 * e / (2 * left**1.5), rel=1e-12)
    # eccentricity along y, so that radial is y and tangential −x
    assert found.place_m == pytest.approx([0.0, e * 1e-4], abs=1e-18)
    krt = np.pi * SPEED * b / (2 * left**1.5)
    ktr = -np.pi * SPEED * b * (1 + 2 * e**2) / (2 * left**2.5)
    expected = [[0.0, -ktr], [-krt, 0.0]]
    np.testing.assert_allclose(found.stiffness_n_per_m, expected, rtol=1e-11, atol=1e-8 * krt)
    crr, ctt = np.pi * b * (1 + 2 * e**2) / left**2.5, np.pi * b / left**1.5
    expected = [[ctt, 0.0], [0.0, crr]]
    np.testing.assert_allclose(found.damping_n_s_per_m, expected, rtol=1e-11, atol=1e-8 * crr)
    middle = FULL.force(np.zeros(2), np.zeros(2), SPEED)
    assert middle.damping_n_s_per_m[0, 0] == pytest.approx(424115, abs=0.6)
    assert middle.stiffness_n_per_m[0, 1] == pytest.approx(33.31e6, abs=6e3)


@pytest.mark.parametrize(
    ("ratio", "kappa", "whirl", "rigid", "flexible"),
    [
        (0.1, 1.9008, 0.5029, 2.741, 1.963),
        (0.3, 1.8319, 0.5194, 2.606, 1.883),
        (0.5, 1.7111, 0.5146, 2.542, 1.866),
        (0.7, 1.5626, 0.3446, 3.628, 2.718),
    ],
)
def test_threshold_of_oil_whirl(ratio, kappa, whirl, rigid, flexible):
    load = load_at(ratio) * 0.5 * OIL.scale_n_s_per_m * 1e-4 * SPEED
    found = journal_state(OIL, (0.0, -load), SPEED)
    k = found.stiffness_n_per_m * 1e-4 / load
    c = found.damping_n_s_per_m * 1e-4 * SPEED / load
    adjugate = np.array([[c[1, 1], -c[0, 1]], [-c[1, 0], c[0, 0]]])
    ke = np.trace(k @ adjugate) / np.trace(c)
    square = np.linalg.det(ke * np.eye(2) - k) / np.linalg.det(c)
    speeds = np.sqrt(ke / square), np.sqrt(ke / (square * (1 + ke / 2)))
    assert ke == pytest.approx(kappa, abs=6e-5)
    assert np.sqrt(square) == pytest.approx(whirl, abs=6e-5)
    assert speeds == pytest.approx((rigid, flexible), abs=6e-4)
    # a rigid rotor at that speed has an undamped whirl: eigenvalue iγ of M λ² + C λ + K
    p = speeds[0]
    companion = np.block([[np.zeros((2, 2)), np.eye(2)], [-k / p**2, -c / p**2]])
    values = np.linalg.eigvals(companion)
    assert abs(values - 1j * np.sqrt(square)).min() < 1e-9


@pytest.mark.parametrize("film", [OIL, FULL])
def test_force_against_quadrature_and_derivatives(film):
    rng = np.random.default_rng(5)
    for _ in range(6):
        angle, ratio, speed = rng.uniform(0, 6), rng.uniform(0.05, 0.9), rng.uniform(-200, 200)
        place = ratio * 1e-4 * np.array([np.cos(angle), np.sin(angle)])
        velocity = rng.normal(size=2) * 0.01
        found = film.force(place, velocity, speed)
        rate = velocity - 0.5 * speed * np.array([-place[1], place[0]])
        top = np.arctan2(rate[1], rate[0])
        half = 0.5 * np.pi if film is OIL else np.pi

        def part(t, axis, place=place, rate=rate):
            n = np.array([np.cos(t), np.sin(t)])
            return -(n @ rate) * n[axis] / (1e-4 - n @ place) ** 3 * 0.1 * 0.05 * 0.03**3

        by_sum = [
            quad(part, top - half, top + half, args=(k,), epsrel=1e-12, points=[angle])[0]
            for k in (0, 1)
        ]
        np.testing.assert_allclose(found.force_n, by_sum, rtol=1e-9)
        for name, step, size in (("stiffness", 0, 1e-10), ("damping", 1, 1e-8)):
            columns = []
            for move in np.eye(2) * size:
                ends = [
                    film.force(place + s * move * (step == 0), velocity + s * move * step, speed)
                    for s in (1, -1)
                ]
                columns.append((ends[1].force_n - ends[0].force_n) / (2 * size))
            exact = found.stiffness_n_per_m if name == "stiffness" else found.damping_n_s_per_m
            np.testing.assert_allclose(np.array(columns).T, exact, atol=2e-6 * abs(exact).max())


def test_squeeze_film_printed_and_on_its_orbit():
    damper = SqueezeFilmDamper(film=OIL, orbit_ratio=0.3)
    found = damper.coefficients(1000.0)
    assert pytest.approx(135000) == OIL.scale_n_s_per_m
    assert found.damping_n_s_per_m == pytest.approx(244282, abs=0.6)
    assert found.stiffness_n_per_m / 1e6 == pytest.approx(97.814, abs=6e-4)
    for film in (OIL, FULL):
        for whirl in (1000.0, -400.0):
            k, c = dataclasses.replace(damper, film=film).coefficients(whirl)
            place, velocity = np.array([3e-5, 0.0]), np.array([0.0, 3e-5 * whirl])
            force = film.force(place, velocity).force_n
            expected = [-k * 3e-5, -c * 3e-5 * whirl]
            np.testing.assert_allclose(force, expected, rtol=1e-11, atol=1e-9 * abs(force).max())
    z = damper.dynamic_stiffness(1000.0, 1000.0j)
    expected = found.stiffness_n_per_m + 1000.0j * found.damping_n_s_per_m
    np.testing.assert_allclose(z, expected * np.eye(2))


def test_groove_and_seals():
    """Two lands of half the length have a quarter of K and C; a sealed film is Sommerfeld's."""
    damper = SqueezeFilmDamper(film=OIL, orbit_ratio=0.3)
    grooved = dataclasses.replace(OIL, length_m=0.015, lands=2)
    for film in (OIL, FULL):
        whole = dataclasses.replace(damper, film=film).coefficients(500.0)
        half = dataclasses.replace(grooved, film=film.film)
        parted = dataclasses.replace(damper, film=half).coefficients(500.0)
        np.testing.assert_allclose(np.array(whole) / 4, parted, rtol=1e-12)
    e, whirl = 0.3, 500.0

    def pressure(t):
        """Full film: p over 12 µ ω (R/c)², from p' = 12 µ ω (R/c)² (e cos t + K) / (1 − e cos t)³
        integrated, with K for equal ends."""
        return -np.sin(t) * e * (2 - e * np.cos(t)) / ((2 + e**2) * (1 - e * np.cos(t)) ** 2)

    sealed = dataclasses.replace(damper, ends="sealed")
    scale = 12 * 0.1 * whirl * (0.05 / 1e-4) ** 2 * 0.05 * 0.03
    positive = [quad(lambda t, f=f: -pressure(t) * f(t), 0, np.pi)[0] for f in (np.cos, np.sin)]
    k, c = sealed.coefficients(whirl)
    radial, tangential = np.abs(positive)
    assert k == pytest.approx(radial * scale / 3e-5, rel=1e-9)
    assert c * whirl == pytest.approx(tangential * scale / 3e-5, rel=1e-9)
    full = dataclasses.replace(sealed, film=FULL).coefficients(whirl)
    assert full == pytest.approx((0.0, 2 * c))


def test_range_of_validity_is_told():
    wide = dataclasses.replace(OIL, length_m=0.08, film="2pi")
    found = SqueezeFilmDamper(film=wide, orbit_ratio=0.5).exceeded(20000.0, 850.0)
    assert [one.quantity.split()[0] for one in found] == ["L/D", "orbit", "squeeze", "peak"]
    assert [one.limit for one in found[:3]] == [0.5, 0.4, 1.0]
    assert found[0].value == pytest.approx(0.8) and "is 0.8, limit 0.5" in found[0].text
    full = SqueezeFilmDamper(film=OIL, orbit_ratio=0.2)
    assert full.exceeded(1000.0, 850.0) == ()
    slow = full.exceeded(1e-3, 850.0, 0.0)
    assert [one.quantity[:4] for one in slow] == ["peak"]
    angle = np.linspace(0.0, np.pi, 200001)
    shape = 0.2 * np.sin(angle) / (1.0 + 0.2 * np.cos(angle)) ** 3
    scale = 1.5 * 0.1 * 1000.0 * (0.03 / 1e-4) ** 2
    assert full.suction_pa(1000.0) == pytest.approx(scale * shape.max(), rel=1e-9)


def test_bad_input_is_named():
    with pytest.raises(AnalysisError, match=r"length_m is -1.*radial_clearance_m is -0.0001"):
        dataclasses.replace(OIL, length_m=-1.0, radial_clearance_m=-1e-4)
    with pytest.raises(AnalysisError, match="cannot be carried at 1 rad/s"):
        journal_state(OIL, (1e7, 0.0), 1.0)
    with pytest.raises(AnalysisError, match="does not turn"):
        journal_state(OIL, (1.0, 0.0), 0.0)
    with pytest.raises(AnalysisError, match="touches at 1"):
        OIL.force(np.array([1e-4, 0.0]), np.zeros(2))
    with pytest.raises(AnalysisError, match="orbit_ratio is 1"):
        SqueezeFilmDamper(film=OIL, orbit_ratio=1.0)
