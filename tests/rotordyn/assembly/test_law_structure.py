"""Fast forms against a general solver on laws whose structure shows at few speeds only.

The solver is written here: M, G, C and K of a rigid rotor from its own geometry, laws interpolated
by scipy or summed as polynomials, all eigenvalues of the state matrix, linear solutions.
"""

from __future__ import annotations

import dataclasses
from itertools import pairwise

import numpy as np
import pytest
import scipy.linalg as la
from rotors import (
    SKEW,
    connect,
    one_rotor,
    polynomial_law,
    rigid_body,
    state_eigenvalues,
    table_law,
    turning,
)
from scipy.interpolate import PchipInterpolator
from scipy.optimize import minimize_scalar

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.assembly.bearing_laws import BearingCoefficients, PolynomialLaw
from solidwhirl.rotordyn.assembly.bearing_notes import bearing_notes
from solidwhirl.rotordyn.assembly.system import speed_derivative
from solidwhirl.rotordyn.checks.system_checks import check_critical_speeds
from solidwhirl.rotordyn.critical_speeds.search import count_critical_speeds
from solidwhirl.rotordyn.estimates.response_errors import unbalance_peak_errors
from solidwhirl.rotordyn.modes.complex_form import complex_form
from solidwhirl.rotordyn.modes.split_spectrum import planes_apart
from solidwhirl.rotordyn.response import unbalance
from solidwhirl.rotordyn.response.unbalance_peaks import resonance_peaks
from solidwhirl.rotordyn.stability.intervals import unstable_intervals
from solidwhirl.rotordyn.superelement.rigid_body import rigid_superelement

ZERO = np.zeros((2, 2))
PLACES = {"a": -0.1, "b": 0.2}
MASS, DIAMETRAL, POLAR = 10.0, 0.1, 0.15
LIMIT = 1000.0


BODY = rigid_body("rotor", MASS, 0.0, (DIAMETRAL, DIAMETRAL, POLAR), PLACES)


def _held(owns, ratio=1.0):
    """The rotor on one bearing at each place."""
    pairs = zip(PLACES, owns, strict=True)
    return one_rotor(BODY, [connect(at, f"rotor.{at}", **own) for at, own in pairs], ratio)


def _system(laws, ratio=1.0, **options):
    """The rotor on two bearings with laws; polynomials scale 1e6 N/m, 100 N s/m."""
    scaled = {"stiffness": 1e6, "damping": 100.0}
    owns = [scaled if isinstance(law, PolynomialLaw) else {} for law in laws]
    pairs = zip(owns, laws, strict=True)
    return _held([{**own, "speed_law": law, **options} for own, law in pairs], ratio)


# The general solver.


def _evaluated(law, speed):
    """k and c of a law at a speed by scipy and sums of powers."""
    if isinstance(law, PolynomialLaw):
        factors = (law.stiffness_x, law.stiffness_y, law.damping_x, law.damping_y)
        x = [sum(c * speed**p for p, c in enumerate(factor)) for factor in factors]
        return 1e6 * np.diag(x[:2]), 100.0 * np.diag(x[2:])
    at = np.clip(speed, law.speeds_rad_s[0], law.speeds_rad_s[-1])
    out = []
    for table in (law.stiffness_n_per_m, law.damping_n_s_per_m):
        if law.interpolation == "monotone":
            out.append(PchipInterpolator(law.speeds_rad_s, table)(at))
        else:
            columns = table.reshape(-1, 4).T
            out.append(np.array([np.interp(at, law.speeds_rad_s, c) for c in columns]))
    return [part.reshape(2, 2) for part in out]


def _general(laws, speed):
    """M, C + ΩG and K of (x, y, rx, ry): a place at z moves by (x + z ry, y − z rx)."""
    mass = np.diag([MASS, MASS, DIAMETRAL, DIAMETRAL])
    velocity = np.zeros((4, 4))
    velocity[2, 3], velocity[3, 2] = speed * POLAR, -speed * POLAR
    stiffness = np.zeros((4, 4))
    for z, law in zip(PLACES.values(), laws, strict=True):
        seen = np.array([[1.0, 0.0, 0.0, z], [0.0, 1.0, -z, 0.0]])
        k, c = _evaluated(law, speed)
        stiffness += seen.T @ k @ seen
        velocity += seen.T @ c @ seen
    return mass, velocity, stiffness


def _eigenvalues(laws, speed):
    """All eigenvalues with a frequency, rising; scaled so that entries are of one size."""
    values = state_eigenvalues(*_general(laws, speed))
    return np.sort_complex(values[values.imag > 1e-6 * np.abs(values)] * -1j) * 1j


def _amplitude(laws, speed):
    """Larger amplitude of x and y at a by an unbalance of 1 kg m there."""
    mass, velocity, stiffness = _general(laws, speed)
    at = np.array([[1.0, 0.0, 0.0, PLACES["a"]], [0.0, 1.0, -PLACES["a"], 0.0]])
    load = speed**2 * at.T @ [1.0, -1j]
    motion = la.solve(stiffness + 1j * speed * velocity - speed**2 * mass, load)
    return np.abs(at @ motion).max()


# Laws that deceive samples.


def _rows(rng, kind):
    """Rising speeds: spread, clustered at low speed below one far row, or about one speed."""
    if kind == "far":
        return np.concatenate((np.sort(rng.uniform(0.0, 1.2 * LIMIT, 4)), [1e9]))
    if kind == "clustered":
        centre = rng.uniform(50.0, 900.0)
        return np.unique(np.concatenate(([0.0], centre + rng.uniform(0.0, 2.0, 4), [2e5])))
    return np.sort(rng.uniform(0.0, 1.5 * LIMIT, 5))


def _random_table(rng, damped):
    speeds = _rows(rng, rng.choice(["far", "clustered", "spread"]))
    stiffness = np.multiply.outer(10.0 ** rng.uniform(4.5, 6.5, speeds.size), np.eye(2))
    damping = np.multiply.outer(10.0 ** rng.uniform(0.0, 3.0, speeds.size), np.eye(2)) * damped
    odd, at = rng.choice(["", "cross", "entry", "damping", "symmetric"]), rng.integers(speeds.size)
    if odd == "cross":
        stiffness[at] += 0.5 * stiffness[at, 0, 0] * SKEW
    elif odd == "symmetric":
        stiffness[at] += 0.3 * stiffness[at, 0, 0] * np.array([[0.0, 1.0], [1.0, 0.0]])
    elif odd == "entry":
        stiffness[at, 1, 1] *= 2.0
    elif odd == "damping" and damped:
        damping[at, 0, 1] = 0.5 * damping[at, 0, 0]
    return table_law(speeds, stiffness, damping, str(rng.choice(["linear", "monotone"])))


def _random_polynomial(rng, damped):
    """k touches zero at one speed, in one plane or both."""
    zero = rng.uniform(100.0, 1100.0)
    touching = (1.0 + 1e-9, -2.0 / zero, 1.0 / zero**2)
    other = touching if rng.random() < 0.5 else (1.0, rng.uniform(0.0, 1e-3))
    along = (1.0, 0.0, rng.uniform(0.0, 1e-6)) if damped else (0.0,)
    across = along if rng.random() < 0.5 else (2.0 * damped,)
    return polynomial_law(touching, other, along, across, top=2e3)


def _random_laws(seed):
    """Two laws, and 1.0 if they damp."""
    rng = np.random.default_rng(seed)
    damped = float(rng.random() < 0.6)
    makers = [_random_table, _random_polynomial]
    return [makers[int(rng.random() < 0.3)](rng, damped) for _ in PLACES], damped


def _marks(laws, system):
    """Speeds where laws change, and between and beside them."""
    knots = np.array([0.1, *system.knots_rad_s, LIMIT])
    knots = np.unique(knots[(knots > 0) & (knots <= LIMIT)])
    middles = 0.5 * (knots[1:] + knots[:-1])
    return np.unique(np.concatenate((knots, middles, knots[:-1] + 1e-3 * np.diff(knots))))


def _check_modes(laws, system):
    for speed in _marks(laws, system):
        wanted = _eigenvalues(laws, speed)
        found = rd.modes_at_speed(system, float(speed)).eigenvalues
        found = found[found.imag > 1e-6 * np.abs(found)]
        assert found.size == wanted.size
        rest = list(wanted)
        for value in found:
            near = int(np.argmin(np.abs(np.array(rest) - value)))
            # equal eigenvalues of a defective pair split by the root of the rounding
            assert abs(rest.pop(near) - value) <= 1e-6 * abs(value)


def _check_critical_speeds(laws, system):
    grid = np.unique(np.concatenate((_marks(laws, system), np.linspace(0.1, LIMIT, 401))))
    above = np.array([np.count_nonzero(_eigenvalues(laws, s).imag > s) for s in grid])
    found = np.array([c.speed_rad_s for c in rd.critical_speeds(system, 1.0, LIMIT)])
    for speed in found:
        values = _eigenvalues(laws, speed)
        assert np.abs(values.imag - speed).min() <= 1e-5 * speed
    slack = 1e-8 * grid
    for low, high, change, near in zip(grid[:-1], grid[1:], np.diff(above), slack, strict=False):
        if change and not (np.abs(found[:, None] - [low, high]) < near).any():
            there = np.count_nonzero((found > low) & (found <= high))
            assert there >= abs(change)


def _check_response(laws, system, damped):
    """Reported motions are those of the general solver, and none beside them is higher."""
    placed = [unbalance.Unbalance(body="rotor", interface="a", moment_kg_m=1.0)]
    speeds = unbalance.resolving_speeds(system, placed, np.linspace(0.0, LIMIT, 21))
    response = unbalance.unbalance_response(system, placed, speeds).exciters[0]
    motion = np.abs(response.at_node("rotor", "a")[1:]).max(axis=1)
    wanted = np.array([_amplitude(laws, speed) for speed in speeds[1:]])
    np.testing.assert_allclose(motion, wanted, rtol=1e-6)
    if not damped:
        return  # peaks have no height
    assert {k for k in system.knots_rad_s if k < LIMIT} <= set(speeds)
    grid = np.concatenate([np.linspace(*ends, 40) for ends in pairwise(_marks(laws, system))])
    dense = np.array([_amplitude(laws, speed) for speed in grid])
    shown = np.array([motion[0], *motion])
    beside = np.searchsorted(speeds, grid).clip(1, speeds.size - 1)
    peaks = resonance_peaks(speeds[1:], motion, 1.0)
    limit = np.maximum(shown[beside - 1], shown[beside])
    above = dense > 1.05 * limit
    for speed, height in zip(grid[above], dense[above], strict=True):
        near = [p.amplitude for p in peaks if abs(p.position_rad_s - speed) < 0.2 * speed]
        assert height <= 1.01 * max(near, default=0.0)


def _check_diagram(laws, system):
    """Every branch is an eigenvalue of the general solver at its speed, and none lacks a branch."""
    speeds = np.linspace(5.0, LIMIT, 9)
    diagram = rd.campbell(system, speeds, branch_count=4)
    for column, speed in enumerate(speeds):
        rest = _eigenvalues(laws, speed)
        values = diagram.eigenvalues[:, column]
        values = values[np.isfinite(values)]
        assert values.size == rest.size
        for value in values:
            near = int(np.argmin(np.abs(rest - value)))
            assert abs(rest[near] - value) <= 1e-6 * abs(value)
            rest = np.delete(rest, near)


def _check_stability(laws, system):
    """Where the general solver finds growth there is an interval, and nowhere else."""
    found = unstable_intervals(system, 0.0, LIMIT)
    for speed in _marks(laws, system):
        values = state_eigenvalues(*_general(laws, speed))
        growth = (values.real / np.abs(values).max()).max()
        inside = any(one.low_rad_s <= speed <= one.high_rad_s for one in found)
        if abs(growth) > 1e-6:
            assert inside == (growth > 0)


def _check(seed):
    laws, damped = _random_laws(seed)
    system = _system(laws)
    for check in (_check_modes, _check_critical_speeds, _check_diagram, _check_stability):
        check(laws, system)
    _check_response(laws, system, damped)


@pytest.mark.parametrize("seed", range(2))
def test_random_laws(seed):
    _check(seed)


@pytest.mark.verify
@pytest.mark.parametrize("seed", range(2, 42))
def test_many_random_laws(seed):
    _check(seed)


# One odd entry.


@pytest.mark.parametrize("far", [300.0, 1e4, 1e9])
@pytest.mark.parametrize("change", [[[0, 1e-3], [-1e-3, 0]], [[0, 1], [1, 0]], [[1, 0], [0, 0]]])
def test_one_odd_entry_decides(change, far):
    """Rows at 0, 10, 20, 30 rad/s and far above, isotropic but for the one at 20 rad/s."""
    stiffness = np.stack([1e6 * np.eye(2)] * 5)
    stiffness[2] += change
    round_one = table_law([0.0, far], [1e6, 1e6])
    system = _system([table_law([0.0, 10.0, 20.0, 30.0, far], stiffness), round_one])
    assert complex_form(system) is None
    straight = change[0][1] == 0
    assert (planes_apart(system) is not None) == straight
    assert system.is_conservative == (change[0][1] == change[1][0])
    even = _system([round_one, round_one])
    assert complex_form(even) is not None
    assert even.is_conservative


def test_a_small_cross_term_beside_a_stiff_shaft_decides():
    """In the sum it is below the rounding that other entries are given."""
    soft = connect("soft", "rotor.a", stiffness=[[1e2, 1e-3], [-1e-3, 1e2]])
    system = one_rotor(BODY, [soft, connect("stiff", "rotor.a", stiffness=1e12)])
    assert complex_form(system) is None
    assert not system.is_conservative


@dataclasses.dataclass(frozen=True)
class _Opaque:
    """A user's law that tells nothing of its structure."""

    name: str = "own"
    speed_range_rad_s: tuple[float, float] = (0.0, 100.0)

    def coefficients(self, speed_rad_s, stiffness_n_per_m, damping_n_s_per_m):
        cross = 1e5 * float(40.0 < speed_rad_s < 41.0)
        return BearingCoefficients(np.array([[1e6, cross], [-cross, 1e6]]), ZERO)


def test_nothing_is_assumed_of_a_law_without_pieces():
    system = _system([_Opaque(), _Opaque()])
    assert complex_form(system) is None
    assert planes_apart(system) is None
    assert not system.is_conservative
    with pytest.raises(rd.AnalysisError, match=r"\['a', 'b'\] do not tell their polynomials"):
        count_critical_speeds(system, 1.0, 100.0)
    grows = rd.modes_at_speed(system, 40.5).eigenvalues.real.max()
    assert grows > 10.0
    assert not speed_derivative(system, 20.0).stiffness.any()


# Slopes and knots.


@pytest.mark.parametrize("interpolation", ["linear", "monotone"])
def test_slopes_are_exact_and_one_sided_at_a_knot(interpolation):
    law = table_law([10.0, 20.0, 50.0], [1e6, 3e6, 2e6], interpolation=interpolation)
    system = _system([law, law], 2.0)
    for speed in (5.0, 10.0, 16.0, 20.0, 34.0, 49.998, 50.0, 60.0):
        found = law.pieces(ZERO, ZERO).slopes(speed)
        for slopes, step in zip(found, (-1e-5, 1e-5), strict=True):
            ends = (_evaluated(law, speed + step)[0], _evaluated(law, speed)[0])
            wanted = (ends[0] - ends[1]) / step
            np.testing.assert_allclose(slopes.stiffness_n_per_m, wanted, rtol=1e-5, atol=1.0)
    corner = [speed_derivative(system, 10.0, side).stiffness for side in ("below", "above")]
    both = speed_derivative(system, 10.0).stiffness
    np.testing.assert_allclose(both, 0.5 * (corner[0] + corner[1]), rtol=1e-12)
    assert system.knots_rad_s == (5.0, 10.0, 25.0)
    # a law goes by |Ω|
    ahead, back = (speed_derivative(system, speed).stiffness for speed in (16.0, -16.0))
    np.testing.assert_array_equal(back, -ahead)
    assert not speed_derivative(system, 0.0).stiffness.any()


def test_flutter_of_a_table_that_looks_isotropic():
    """Rows at low speed and one far up: the true growth is that of the general solver."""
    stiffness = np.stack([1e6 * np.eye(2)] * 5)
    stiffness[2] += 5e5 * SKEW
    laws = [table_law([0.0, 50.0, 60.0, 70.0, 5e4], stiffness, [50.0] * 5, "linear")] * 2
    for speed in (55.0, 60.0, 65.0):
        wanted = _eigenvalues(laws, speed)
        assert wanted.real.max() > 50.0
        found = rd.modes_at_speed(_system(laws), speed).eigenvalues
        assert found.real.max() == pytest.approx(wanted.real.max(), rel=1e-9)


def test_peak_at_a_kink_of_a_law():
    """Stiffness falls tenfold within 15 rpm either side of 3000 rpm, where nothing else is."""
    rpm = np.pi / 30.0
    rows = np.array([0, 2985, 3015, 9000]) * rpm
    laws = [table_law(rows, [2e6, 2e6, 2e5, 2e5], [20.0] * 4)] * 2
    system = _system(laws)
    placed = [unbalance.Unbalance(body="rotor", interface="a", moment_kg_m=1e-5)]
    speeds = unbalance.resolving_speeds(system, placed, np.linspace(0.0, 9000.0, 46) * rpm)
    response = unbalance.unbalance_response(system, placed, speeds).exciters[0]
    node, major = response.nodes[0], response.orbits().major_m[1:, 0]
    peaks = unbalance.orbit_peaks(system, placed, node, speeds[1:], major)
    shown = max(peaks, key=lambda p: p.amplitude)
    fine = np.linspace(2985.0, 3015.0, 501) * rpm
    dense = 1e-5 * np.array([_amplitude(laws, speed) for speed in fine])
    top, step = int(dense.argmax()), fine[1] - fine[0]
    truth = minimize_scalar(
        lambda offset: -1e-5 * _amplitude(laws, fine[top] + offset),
        bounds=(-step, step),
        method="bounded",
        options={"xatol": 1e-10},
    )
    assert dense.max() > 20.0 * 1e-5 * max(_amplitude(laws, s * rpm) for s in (2980.0, 3020.0))
    errors = unbalance_peak_errors(system, placed, node, peaks)
    estimate = float(errors.height_total[peaks.index(shown)])
    assert abs(shown.amplitude / max(-truth.fun, dense.max()) - 1.0) <= estimate <= 1e-6
    assert shown.position_rad_s == pytest.approx(fine[top] + truth.x, rel=1e-9)
    # A height that was read wrong is seen.
    wrong = [dataclasses.replace(shown, amplitude=(1.0 + 1e-4) * shown.amplitude)]
    seen = unbalance_peak_errors(system, placed, node, wrong).height_total[0]
    assert seen == pytest.approx(1e-4, rel=0.05)


def test_critical_speeds_below_the_first_sample():
    """The stiffness dips to a millionth within the first thousandth of the range."""
    rows, stiffness = [0.0, 20.0, 21.0, 30.0, 31.0, 1e5], [1e6, 1e6, 1e-3, 1e-3, 1e6, 1e6]
    laws = [table_law(rows, stiffness)] * 2
    found = np.array([c.speed_rad_s for c in rd.critical_speeds(_system(laws), 1.0, 1e5)])
    grid = np.concatenate([np.linspace(20.0, 21.0, 300), np.linspace(30.0, 31.0, 300)])
    above = np.array([np.count_nonzero(_eigenvalues(laws, s).imag > s) for s in grid])
    changes = np.abs(np.diff(above)).sum()
    assert np.count_nonzero(found < 100.0) == changes >= 4


# The sense of spin.


def _film(speeds=(0.0, 600.0)):
    stiffness = np.array([[[2e6, k], [-0.6 * k, 1.2e6]] for k in (0.0, 9e5)])
    damping = np.array([[[600.0, 100.0], [100.0, 400.0]]] * 2)
    return table_law(speeds, stiffness, damping)


def _constant_film(ratio, **options):
    own = {"stiffness": [[2e6, 4e5], [-3e5, 1.2e6]], "damping": [[100.0, 50.0], [50.0, 80.0]]}
    return _held([{**own, **options}] * 2, ratio)


def _growth(system, speed):
    return np.sort_complex(rd.modes_at_speed(system, speed).eigenvalues)


@pytest.mark.parametrize("build", [lambda r, **o: _system([_film()] * 2, r, **o), _constant_film])
def test_a_film_turns_with_its_shaft(build):
    for speed in (100.0, 300.0, 600.0):
        forward, backward = (_growth(build(ratio), speed) for ratio in (1.0, -1.0))
        np.testing.assert_allclose(backward, forward, rtol=1e-9)
        given = _growth(build(-1.0, cross_coupling="as_given"), speed)
        assert np.abs(given - forward).max() > 1e-3 * np.abs(forward).max()
    kinds = [
        [note.kind for note in bearing_notes(system, [0.0, 600.0])]
        for system in (build(1.0), build(-1.0), build(-1.0, cross_coupling="as_given"))
    ]
    assert kinds == [[], ["mirrored"] * 2, ["not mirrored"] * 2]


def test_an_elastic_support_with_inclined_axes_stays():
    bearing = connect("a", "rotor.a", stiffness=[[2e6, 4e5], [4e5, 1e6]])
    system = one_rotor(BODY, [bearing], -1.0)
    assert system.system.bearings == (bearing,)
    assert bearing_notes(system, [0.0, 600.0]) == ()


def test_user_law_is_mirrored_and_a_second_assembly_changes_nothing():
    system = _system([_Opaque(), _Opaque()], -1.0)
    k, _ = system.law_joints[0].coefficients(40.5)
    assert k.tolist() == [[1e6, -1e5], [1e5, 1e6]]
    again = rd.assemble(system.system.rotors, system.system.bearings)
    assert again.law_joints[0].coefficients(40.5)[0].tolist() == k.tolist()


# Joints that can not be.


@pytest.mark.parametrize("ratio", [-1.0, 2.0, 0.0])
@pytest.mark.parametrize("joint", [{"rigid": ("rz",)}, {"torsion_stiffness_n_m_per_rad": 1e4}])
def test_joints_that_would_wind_up_are_refused(ratio, joint):
    def joined(other):
        body = rigid_superelement("b", 1.0, (0.0, 0.0, 0.0), (1.0, 1.0, 1.0), {"a": 0.0})
        tie = connect("tie", "one.a", "other.a", 1e6, **joint)
        return rd.assemble({"one": turning(body), "other": turning(body, other)}, (tie,))

    with pytest.raises(rd.AssemblyError, match=rf"'tie': .*'one'.* at 1 .*'other' at {ratio:g}"):
        joined(ratio)
    assert joined(1.0).size > 0


def test_the_limit_of_residuals_knows_how_steep_a_law_is():
    """The stiffness falls fortyfold within 2e-5 of the speed, right where modes meet it."""
    rows = np.array([0, 2999.97, 3000.03, 9000]) * np.pi / 30.0
    system = _system([table_law(rows, [2e6, 2e6, 5e4, 5e4])] * 2)
    found = rd.critical_speeds(system, 1.0, LIMIT)
    (residual, count) = check_critical_speeds(system, found, 1.0, LIMIT)
    assert residual.passed
    assert count.passed
    # a wrong speed is found out all the same
    wrong = [dataclasses.replace(found[0], speed_rad_s=found[0].speed_rad_s * (1 + 1e-9))]
    assert not check_critical_speeds(system, [*wrong, *found[1:]], 1.0, LIMIT)[0].passed
