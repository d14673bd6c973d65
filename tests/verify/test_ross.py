"""The same beam rotors in ROSS 2.3.0 (petrobras/ross) and here, value by value.

ROSS builds its own matrices from the same data. Its element is the one used here: Timoshenko
beam with Cowper's shear coefficient, consistent mass with rotary inertia, gyroscopic matrix from
the same slope functions. So nothing but rounding may differ where both solve the same equation;
tolerances are about a hundred times the differences seen. Where the methods differ, the test says
how. Axial motion and torsion are left out unless there is a gear.
"""

from __future__ import annotations

import numpy as np
import pytest
from ross_shafts import STEEL, bearing, complex_of, disk, shaft

from solidwhirl.rotordyn import End, critical_speeds, modes_at_speed
from solidwhirl.rotordyn.critical_speeds.map import critical_speed_map
from solidwhirl.rotordyn.response.unbalance import Unbalance, unbalance_response
from solidwhirl.rotordyn.run_up.integration import ramp_and_hold, run_up

pytestmark = pytest.mark.verify
SPEEDS = [0.0, 100.0, 400.0, 1200.0]
# Coefficients of bearings that depend on the speed: factors over Ω in rad/s.
FACTORS = {"k": [1.0, 4e-4, 3e-7], "c": [1.0, -2e-4, 1e-7]}


def one_shaft(bearings, asked, **more):
    return {"material": STEEL, "shafts": [shaft(bearings, **more)], "asked": asked}


def stepped_shaft():
    """Hollow, stepped, disk on the overhang, elements of very different length."""
    return shaft(
        [bearing(3, 4e7, 3e7), bearing(5, 4e7, 3e7)],
        [disk(0, 0.02, 0.12, 0.02), disk(7, 0.03, 0.1, 0.03)],
        np.cumsum([0.0, 0.05, 0.013, 0.1, 0.09, 0.2, 0.04, 0.06]),
        [0.012, 0.03, 0.02, 0.025, 0.025, 0.03, 0.015],
        [0.0, 0.018, 0.0, 0.01, 0.01, 0.0, 0.012],
    )


def coaxial(ratio):
    """Two shafts with a bearing between them, two of the bearings in flexible pedestals."""
    inner = shaft(
        [bearing(0, 3e6, 2e6, 200.0, 300.0, other=10), bearing(5, 2e6, 2e6, 150.0, 150.0)],
        [disk(1, 0.05, 0.22), disk(4, 0.04, 0.25)],
        np.linspace(0.0, 1.0, 6),
    )
    outer = shaft(
        [bearing(9, 1.5e6, 1.5e6, 100.0, 100.0), bearing(6, 2e6, 1.8e6, 80.0, 80.0, other=3)],
        [disk(1, 0.05, 0.3, 0.12), disk(2, 0.03, 0.26, 0.12)],
        np.linspace(0.0, 0.45, 4),
        0.06,
        0.05,
        first_node=6,
    )
    pedestal = bearing(10, 2e7, 1e7, 400.0, 500.0)
    return {
        "material": STEEL,
        "shafts": [inner, outer],
        "ratios": [1.0, ratio],
        "point_masses": [[10, 12.0]],
        "pedestals": [pedestal],
        "asked": {"modes": {"speeds": SPEEDS, "count": 12}},
    }


def geared():
    """Turbo-alternator of Rao, Shiau and Chang 1998, Mech. Mach. Theory 33, 761-783.

    The data are those of ROSS's example; its second base radius is that of the teeth here.
    """
    angle, teeth, base = np.deg2rad(22.5), (328, 23), 0.5086
    wheels = [
        {"node": 4, "mass": 726.4, "diametral": 56.95, "polar": 113.9},
        {"node": 0, "mass": 5.0, "diametral": 0.002, "polar": 0.004},
    ]
    for wheel, count in zip(wheels, teeth, strict=True):
        wheel |= {"teeth": count, "pressure_angle_rad": angle}
        wheel["base_radius_m"] = base * count / teeth[0]
    generator = {"node": 1, "mass": 525.7, "diametral": 16.1, "polar": 32.2}
    plain = {"node": 2, "mass": 116.04, "diametral": 3.115, "polar": 6.23}
    turbine = {"node": 2, "mass": 7.45, "diametral": 0.0745, "polar": 0.149}
    first = shaft(
        [bearing(n, 183.9e6, 200.4e6, 3e3, 3e3) for n in (0, 3)],
        [generator, plain, wheels[0]],
        np.cumsum([0.0, 0.1, 4.24, 1.16, 0.3]),
        [0.15, 0.15, 0.11, 0.11],
    )
    second = shaft(
        [bearing(n, 10.1e6, 41.6e6, 3e3, 3e3) for n in (1, 3)],
        [wheels[1], turbine],
        np.cumsum([0.0, 0.3, 5.0, 0.1]),
        0.075,
    )
    return {
        "material": {"E": 207e9, "G": 79.5e9, "rho": 7800.0},
        "shafts": [first, second],
        "ratios": [1.0, -teeth[0] / teeth[1]],
        "gear": {"nodes": [4, 0], "stiffness": 1e8, "orientation_rad": 0.4},
        "asked": {"modes": {"speeds": [0.0, 157.08], "count": 30}},
    }


MODES = {"speeds": SPEEDS, "count": 10}
PLACED = {"node": 2, "unbalance_kg_m": 1e-3, "phase_rad": 0.4}
RESPONSE = {
    **PLACED, "speeds_rad_s": np.linspace(20.0, 620.0, 25).tolist(), "read_nodes": [0, 2, 4]
}  # fmt: skip
MAP = {"stiffness_n_per_m": np.logspace(4, 9, 6).tolist(), "count": 4}
RUN_UP = {
    **PLACED, "read_node": 2, "start_rad_s": 0.0, "acceleration_rad_s2": 180.0, "duration_s": 0.6,
    "steps": [1200, 2400], "records": 120,
}  # fmt: skip
UNEVEN = [bearing(n, 1e6, 8e5) for n in (0, 6)]
DAMPED = [bearing(n, 1e6, 8e5, 2e3, 2.6e3, 1e5, -2e5) for n in (0, 6)]
EVEN = [bearing(n, 1e6) for n in (0, 6)]
LIGHT = [bearing(n, 1e6, 8e5, 600.0, 600.0) for n in (0, 6)]
WITH_LAW = [
    bearing(n, 1e6, 8e5, 2e3, 2.6e3, factors=FACTORS, speeds_rad_s=np.linspace(0, 1500, 9).tolist())
    for n in (0, 6)
]
CASES = {
    "uneven": one_shaft(UNEVEN, {"modes": MODES, "critical": 6}),
    "damped": one_shaft(DAMPED, {"modes": MODES, "critical": 6, "response": RESPONSE}),
    "even": one_shaft(EVEN, {"modes": MODES, "critical": 6, "map": MAP}),
    "light": one_shaft(LIGHT, {"run_up": RUN_UP, "response": RESPONSE}),
    "law": one_shaft(WITH_LAW, {"modes": MODES, "critical": 6, "response": RESPONSE}),
    "stepped": {"material": STEEL, "shafts": [stepped_shaft()], "asked": {"modes": MODES}},
    "equal speeds": coaxial(1.0),
    "counter-rotating": coaxial(-1.3),
    "geared": geared(),
}


@pytest.fixture(scope="module")
def ross(run_ross):
    return run_ross(CASES)


def unbalance_of(asked):
    own = {"moment_kg_m": asked["unbalance_kg_m"], "phase_rad": asked["phase_rad"]}
    return Unbalance(body="0", interface=f"{asked['node']}", **own)


def with_values(kind):
    return pytest.mark.parametrize(
        "name", [n for n, case in CASES.items() if kind in case["asked"]]
    )


@with_values("modes")
def test_modes(ross, system_of, name):
    """Frequency and damping: complex eigenvalues against those of ROSS's dense solver."""
    asked, assembled = CASES[name]["asked"]["modes"], system_of(CASES[name])
    for speed, pairs in zip(asked["speeds"], ross[name]["modes"], strict=True):
        theirs = complex_of(pairs)
        assert theirs.size == asked["count"]
        ours = modes_at_speed(assembled, speed).eigenvalues[: theirs.size]
        # Seen: 3e-12, at the lowest mode, where ROSS inverts M rather than K.
        np.testing.assert_allclose(ours, theirs, rtol=3e-10)


@with_values("critical")
def test_critical_speeds(ross, system_of, name):
    """Newton's method on damped frequencies against the direct solution or the root on a branch."""
    theirs = ross[name]["critical"]
    found = critical_speeds(system_of(CASES[name]), speed_max_rad_s=1.1 * max(theirs))
    # Seen: 2e-12.
    np.testing.assert_allclose([c.speed_rad_s for c in found[: len(theirs)]], theirs, rtol=3e-10)


@with_values("response")
def test_unbalance_response(ross, system_of, name):
    """Amplitude and phase at three nodes over 25 speeds, through two resonances."""
    asked = CASES[name]["asked"]["response"]
    theirs = complex_of(ross[name]["response"])
    placed = [unbalance_of(asked)]
    (exciter,) = unbalance_response(system_of(CASES[name]), placed, asked["speeds_rad_s"]).exciters
    for place, node in enumerate(asked["read_nodes"]):
        ours = exciter.at_node("0", f"{node}")
        # Seen: 5e-13. Both give complex amplitudes for e^{iωt}, so the phase is compared as well.
        np.testing.assert_allclose(ours, theirs[:, place], rtol=5e-11)


@with_values("map")
def test_critical_speed_map(ross, system_of, name):
    """ROSS's synchronous map: forward critical speeds over the stiffness of all bearings."""
    asked = CASES[name]["asked"]["map"]
    assembled = system_of(CASES[name])
    names = [b.name for b in assembled.system.bearings]
    found = critical_speed_map(
        assembled, names, asked["stiffness_n_per_m"], branch_count=asked["count"]
    )
    forward = np.sort(found.speed_rad_s[found.whirl[:, 0] == "forward"], axis=0)
    # Seen: 6e-11, at the softest bearings and the lowest speed.
    np.testing.assert_allclose(forward, np.array(ross[name]["map"]).T, rtol=6e-9)


@with_values("run_up")
def test_run_up(ross, system_of, name):
    """Displacement through the first resonance, against Newmark's method at two steps.

    Its error falls with the square of the step, so extrapolation leaves a comparison of the
    equations. ROSS measures the tilt by angles about axes that follow each other, which puts the
    moment of Ω' on one of the two tilts; here both carry half. With ½G in place of its matrix
    both programs solve the same equation.
    """
    asked = CASES[name]["asked"]["run_up"]
    coarse, fine = asked["steps"]
    stop = asked["start_rad_s"] + asked["acceleration_rad_s2"] * asked["duration_s"]
    found = run_up(
        system_of(CASES[name]),
        ramp_and_hold(stop, asked["duration_s"], start_speed_rad_s=asked["start_rad_s"]),
        [unbalance_of(asked)],
        step_s=asked["duration_s"] / coarse,
        record_every=coarse // asked["records"],
        outputs=[End(body="0", interface=f"{asked['read_node']}")],
        phase_error_rad=1e-4,
    )
    ours = found.translation_m[0, :2].T
    theirs = {key: np.array(values) for key, values in ross[name]["run_up"].items()}
    size = np.abs(ours).max()

    def miss(values):
        return float(np.abs(ours - values).max() / size)

    def extrapolated(term):
        return (4 * theirs[f"{term} {fine}"] - theirs[f"{term} {coarse}"]) / 3

    # Seen: 3.96; 1.9e-5, as Newmark's first step assumes rest in acceleration too; 6.7e-4.
    rate = miss(theirs[f"half {coarse}"]) / miss(theirs[f"half {fine}"])
    assert rate == pytest.approx(4.0, abs=0.3)
    assert miss(extrapolated("half")) < 1e-4
    assert miss(extrapolated("ross")) < 2e-3
