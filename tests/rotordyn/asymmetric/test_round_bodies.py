"""Bodies of revolution by the road of asymmetric ones: the numbers of the ordinary road."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from flat_rotors import in_its_frame
from rotors import ground, steel_shaft, turning
from sometimes import often

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.asymmetric import assemble_rotating, unstable_ranges
from solidwhirl.rotordyn.asymmetric.diagram import as_campbell, rotating_diagram
from solidwhirl.rotordyn.asymmetric.loads import unbalance_force
from solidwhirl.rotordyn.asymmetric.parametric.block_paths import prepared, solve
from solidwhirl.rotordyn.asymmetric.parametric.hill import hill_block
from solidwhirl.rotordyn.asymmetric.resonances import critical_speeds
from solidwhirl.rotordyn.asymmetric.response import steady_response
from solidwhirl.rotordyn.estimates.eigenvalue_errors import frequency_errors
from solidwhirl.rotordyn.response.unbalance import Unbalance, unbalance_response
from solidwhirl.rotordyn.stability.intervals import unstable_intervals

RPM = np.pi / 30.0
TOP = 9000.0 * RPM
# Of every frequency; what the issue of two roads with other coordinates leaves is 1e-11.
SAME = 1e-9
SUPPORTS = {
    "same in all directions": {},
    "unlike": {"ky": 5e7},
    "damped": {"ky": 5e7, "cx": 3e3, "cy": 1e3},
}


@pytest.fixture(scope="module")
def shafts():
    """An inner shaft with two disks, and an outer one about it that turns the other way."""
    stations = np.linspace(0.0, 1.2, 5)
    seats = {"left": 0.0, "seat": 0.9, "right": 1.2}
    disks = [(0.3, 8.0, 0.06, 0.035), (0.9, 12.0, 0.12, 0.07)]
    inner = steel_shaft("inner", stations, 0.03, seats, disks)
    outer = steel_shaft("outer", np.array([0.5, 0.6, 0.9]), 0.05, {"front": 0.5, "rear": 0.9},
                        [(0.6, 5.0, 0.05, 0.03)], inner=0.04)  # fmt: skip
    return inner, outer


def parts(shafts, support):
    inner, outer = shafts
    rotors = {"inner": turning(inner, 1.0), "outer": turning(outer, -1.6)}
    own = SUPPORTS[support]
    between = rd.Bearing(
        name="between",
        first=rd.End(body="inner", interface="seat"),
        second=rd.End(body="outer", interface="rear"),
        stiffness_n_per_m=2e7 * np.eye(2),
    )
    held = [ground("inner", end, 3e7, **own) for end in ("left", "right")]
    return rotors, (*held, ground("outer", "front", 4e7, **own), between)


def both(shafts, support):
    """The engine by the ordinary road, and with the inner shaft in its own frame."""
    rotors, bearings = parts(shafts, support)
    turned = rotors | {"inner": turning(in_its_frame(rotors["inner"].element), 1.0)}
    return rd.assemble(rotors, bearings), assemble_rotating(turned, bearings)


@pytest.mark.parametrize("support", often(SUPPORTS, "same in all directions", "damped"))
def test_eigenvalues(shafts, support):
    """All below the highest line; e^{λt} at rest is e^{(λ ± iΩ)t} in the frame, up to strides."""
    ordinary, rotating = both(shafts, support)
    assert rotating.turned == {"inner", "outer"}
    periodic, speed = rotating.periodic, 5000.0 * RPM
    assert periodic.stride == (0 if support == "same in all directions" else 2)
    known = rd.modes_at_speed(ordinary, speed).eigenvalues
    known = known[np.abs(known) < 6.0 * speed]
    assert known.size > 6
    order = 4 if periodic.stride else 0
    block = prepared(hill_block(periodic, order), ordinary.body_rate, 0.5 * speed, speed)
    found = solve(block, speed).values
    for value in np.concatenate((known, known.conj())):
        shifted = value + 1j * speed * np.array([-1.0, 1.0])
        apart = np.abs(found[:, None] - shifted).min()
        assert apart < SAME * abs(value)


@pytest.mark.parametrize("support", SUPPORTS)
def test_diagram_in_fixed_axes(shafts, support):
    ordinary, rotating = both(shafts, support)
    speeds = np.array([0.0, 2000.0, 5000.0]) * RPM
    found, moved = as_campbell(rotating_diagram(rotating, speeds, 6), 1.0)
    # supports that are unlike have their branches in modes up to three times as fast
    limit = 1e-6 if rotating.periodic.stride else SAME
    for k, speed in enumerate(speeds):
        modes = rd.modes_at_speed(ordinary, float(speed))
        for hertz, value in zip(found.frequency_hz[:, k], found.eigenvalues[:, k], strict=True):
            nearest = np.abs(modes.frequency_hz - hertz).argmin()
            assert hertz == pytest.approx(modes.frequency_hz[nearest], rel=limit)
            growth = modes.eigenvalues[nearest].real
            assert value.real == pytest.approx(growth, abs=limit * abs(value))
    assert moved.keys() == {"mesh"}


@pytest.mark.parametrize("support", SUPPORTS)
def test_errors_of_the_diagram(shafts, support):
    """What the outer shaft leaves out moves eigenvalues in either frame by the same."""
    inner, outer = shafts
    inner = dataclasses.replace(inner, error_forms=())
    ordinary, rotating = both((inner, outer), support)
    speeds = np.array([0.0, 2000.0, 5000.0]) * RPM
    diagram, moved = as_campbell(rotating_diagram(rotating, speeds, 6), 1.0)
    for k, speed in enumerate(speeds):
        modes = rd.modes_at_speed(ordinary, float(speed))
        known = frequency_errors(ordinary, modes).parts["mesh"] * np.abs(modes.eigenvalues)
        for hertz, found in zip(diagram.frequency_hz[:, k], moved["mesh"][:, k], strict=True):
            nearest = np.abs(modes.frequency_hz - hertz).argmin()
            # shares of two planes that are alike are those of any two vectors
            assert found == pytest.approx(known[nearest], rel=1e-3)


@pytest.mark.parametrize(
    "support", often(["same in all directions", "unlike"], "same in all directions")
)
def test_critical_speeds(shafts, support):
    ordinary, rotating = both(shafts, support)
    known = rd.critical_speeds(ordinary, excitation_ratio=1.0, speed_max_rad_s=TOP)
    found = critical_speeds(rotating, 100.0 * RPM, TOP)
    known_rpm = [c.speed_rad_s for c in known]
    if support == "same in all directions":  # unbalance meets forward whirl alone
        known_rpm = [c.speed_rad_s for c in known if c.whirl == "forward"]
    assert [r.speed_rad_s for r in found if r.motion == "lateral"] == pytest.approx(
        known_rpm, rel=SAME
    )


@pytest.mark.parametrize("support", SUPPORTS)
def test_unbalance_response(shafts, support):
    ordinary, rotating = both(shafts, support)
    load = Unbalance(body="inner", interface="seat", moment_kg_m=1e-4, phase_rad=0.7)
    speeds = np.array([900.0, 3100.0, 7700.0]) * RPM
    (known,) = unbalance_response(ordinary, [load], speeds).exciters
    found = steady_response(rotating, speeds, centrifugal=unbalance_force(rotating, [load]))
    for node in known.nodes:
        motion = known.at_node(node.body, node.interface)
        own = found.translation_m[:, 1, found.nodes.index(node)]
        assert np.abs(own - motion).max() < SAME * np.abs(motion).max()
    for name, force in known.bearing_forces.items():
        assert found.bearing_forces[name][:, 1] == pytest.approx(
            force, abs=SAME * np.abs(force).max()
        )
    others = np.delete(found.translation_m, 1, axis=1)
    assert np.abs(others).max(initial=0.0) < 1e-9 * np.abs(found.translation_m).max()


def test_unstable_ranges(shafts):
    """Internal damping of the inner shaft drives forward whirl above a critical speed."""
    rotors, bearings = parts(shafts, "damped")
    inside = rd.InternalDamping(stiffness_coefficient_s=2e-5)
    rotors["inner"] = turning(rotors["inner"].element, 1.0, internal_damping=inside)
    turned = turning(in_its_frame(rotors["inner"].element), 1.0, internal_damping=inside)
    rotating = assemble_rotating(rotors | {"inner": turned}, bearings)
    ordinary = rd.assemble(rotors, bearings)
    known = unstable_intervals(ordinary, 3000.0 * RPM, TOP)
    found = unstable_ranges(rotating.periodic, 3000.0 * RPM, TOP)
    assert len(known) > 0
    ends = [(r.low_rad_s, r.high_rad_s) for r in found]
    assert ends == [pytest.approx((k.low_rad_s, k.high_rad_s), rel=1e-7) for k in known]
