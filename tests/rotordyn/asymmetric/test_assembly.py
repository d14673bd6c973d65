"""Engines with an asymmetric body, against the same written by hand."""

from __future__ import annotations

import numpy as np
import pytest
from flat_rotors import flat_mass
from rotors import connect, ground, turning
from scipy.integrate import solve_ivp

from solidwhirl.rotordyn import rigid_superelement
from solidwhirl.rotordyn.asymmetric import assemble_rotating, floquet_multipliers
from solidwhirl.rotordyn.core.errors import AssemblyError

ROTOR, CASING, SPRINGS, JOINT = 2.0, 5.0, (300.0, 700.0), 900.0
HELD, DRAG = np.array([800.0, 2000.0]), np.array([0.8, 1.6])
LATERAL = ("ux", "uy")


def mass(name, kg, components=LATERAL):
    return rigid_superelement(name, kg, [0.0] * 3, [1.0] * 3, {"hub": 0.0}, components)


def with_casing(speed_ratio=1.0):
    """A flat shaft in a casing at rest on supports that are unlike in x and y."""
    rotors = {
        "flat": turning(flat_mass(ROTOR, SPRINGS), speed_ratio),
        "casing": turning(mass("casing", CASING), 0.0),
    }
    between = connect("joint", "flat.hub", "casing.hub", stiffness=(JOINT, JOINT))
    return assemble_rotating(rotors, (between, ground("casing", "hub", *HELD, *DRAG)))


def turns_in_fixed_axes(speed):
    """Motion after a turn, (8, 8), of x, y of shaft and casing in fixed axes, step by step."""

    def rate(time, state):
        c, s = np.cos(speed * time), np.sin(speed * time)
        turn = np.array([[c, -s], [s, c]])
        u, v = state.reshape(8, 8)[:4], state.reshape(8, 8)[4:]
        pull = JOINT * (u[:2] - u[2:])
        shaft = -(turn @ np.diag(SPRINGS) @ turn.T @ u[:2] + pull) / ROTOR
        casing = (pull - HELD[:, None] * u[2:] - DRAG[:, None] * v[2:]) / CASING
        return np.vstack((v, shaft, casing)).ravel()

    found = solve_ivp(rate, (0.0, 2.0 * np.pi / speed), np.eye(8).ravel(), "DOP853",
                      rtol=1e-11, atol=1e-11)  # fmt: skip
    return np.linalg.eigvals(found.y[:, -1].reshape(8, 8))


@pytest.mark.parametrize("speed", [8.0, 17.0, 31.0])
def test_casing_at_rest_beside_a_flat_shaft(speed):
    system = with_casing()
    found = floquet_multipliers(system.periodic, speed, 1e-11)
    own = np.abs(found.values) ** system.periodic.stride
    known = np.abs(turns_in_fixed_axes(speed))
    assert np.sort(own) == pytest.approx(np.sort(known), rel=1e-7)


def test_the_sense_of_the_turn_is_no_matter_where_supports_do_not_cross():
    both = [floquet_multipliers(with_casing(r).periodic, 17.0, 1e-11).values for r in (1.0, -1.0)]
    sizes = [np.sort(np.abs(values)) for values in both]
    assert sizes[1] == pytest.approx(sizes[0], rel=1e-8)


def test_a_flat_body_among_others_rigidly_joined_is_one_of_their_mass():
    joined = {
        "flat": turning(flat_mass(ROTOR, SPRINGS)),
        "disk": turning(mass("disk", 3.0)),
        "ring": turning(mass("ring", 1.0)),
    }
    rigid = [connect(n, "flat.hub", f"{n}.hub", rigid=LATERAL) for n in ("disk", "ring")]
    held = ground("flat", "hub", *HELD, *DRAG)
    several = assemble_rotating(joined, (*rigid, held))
    one = assemble_rotating({"flat": turning(flat_mass(ROTOR + 4.0, SPRINGS))}, (held,))
    assert several.periodic.size == one.periodic.size == 2
    found, known = (
        np.sort(np.abs(floquet_multipliers(s.periodic, 11.0, 1e-11).values)) for s in (several, one)
    )
    assert found == pytest.approx(known, rel=1e-8)


def test_a_spool_of_another_speed_joins_as_a_mass_where_it_does_not_tilt():
    """Without tilt a round body has no gyroscopic moment: its speed is no matter."""
    found = []
    for ratio in (1.0, -1.7):
        rotors = {
            "flat": turning(flat_mass(ROTOR, SPRINGS)),
            "round": turning(mass("round", 3.0), ratio),
        }
        between = connect("joint", "flat.hub", "round.hub", stiffness=(JOINT, JOINT))
        system = assemble_rotating(rotors, (between, ground("round", "hub", *HELD, *DRAG)))
        found.append(np.sort(np.abs(floquet_multipliers(system.periodic, 17.0, 1e-11).values)))
    assert found[1] == pytest.approx(found[0], rel=1e-8)


def test_what_no_frame_holds_is_refused():
    flat = flat_mass(ROTOR, SPRINGS)
    two = {"a": turning(flat), "b": turning(flat, 1.2)}
    with pytest.raises(AssemblyError, match="no common period; reduce one of them"):
        assemble_rotating(two, (ground("a", "hub", 1.0),))
    with pytest.raises(AssemblyError, match="stand still; reduce them as bodies of any shape"):
        assemble_rotating({"a": turning(flat, 0.0)}, (ground("a", "hub", 1.0),))
    half = connect("half", "a.hub", rigid=("ux",))
    with pytest.raises(AssemblyError, match="holds ux rigidly and not the other"):
        assemble_rotating({"a": turning(flat)}, (half,))
