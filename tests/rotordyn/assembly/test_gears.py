"""Gears: torsion of two shafts as one, elastic teeth, and the line of action that bends shafts."""

import numpy as np
import pytest
from rotors import connect, one_rotor, steel_shaft, turning

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.superelement.rigid_body import rigid_superelement

ALL = ("ux", "uy", "uz", "rx", "ry", "rz")
RATIO = 0.315
# Light, slender shafts with a wheel at the far end: torsion springs k = G J / L.
LENGTH, SHEAR = 0.5, 8e10
RADII = {"fast": 0.02, "slow": 0.04}
INERTIA = {"fast": 0.5, "slow": 9.0}


def _stiffness(name):
    return SHEAR * np.pi * RADII[name] ** 4 / 2 / LENGTH


def _shaft(name, seat_inertia):
    wheels = ((0.0, seat_inertia), (LENGTH, INERTIA[name]))
    disks = [(z, 1.0, polar, 0.5 * polar) for z, polar in wheels]
    own = ([0.0, LENGTH], RADII[name], {"seat": 0.0, "far": LENGTH}, disks)
    return steel_shaft(name, *own, material=(2.6 * SHEAR, 0.3, 1e-3), components=ALL)


def _rotors(ratio, seat_inertia=1e-9):
    ratios = {"fast": 1.0, "slow": ratio}
    return {name: turning(_shaft(name, seat_inertia), r) for name, r in ratios.items()}


def _gear(ratio, **options):
    first, second = (rd.End(body=name, interface="seat") for name in RADII)
    return rd.Gear(**{"name": "gear", "first": first, "second": second, "ratio": ratio, **options})


def _pair(ratio=RATIO, **options):
    # one axial support for each shaft is enough
    held = {"seat": ("ux", "uy", "uz"), "far": ("ux", "uy")}
    bearings = tuple(
        connect(f"{name} {at}", f"{name}.{at}", rigid=motions)
        for name in RADII
        for at, motions in held.items()
    )
    return rd.assemble(_rotors(ratio), bearings, gears=(_gear(ratio, **options),))


def _torsion(assembled):
    """Frequencies (rad/s) of modes that turn the far wheel."""
    modes = rd.modes_at_speed(assembled, 0.0)
    index = assembled.system.rotors["fast"].element.interface_index("far", "rz")
    shapes = np.abs(assembled.transformation[index] @ modes.shapes)
    return 2 * np.pi * modes.frequency_hz[shapes > 1e-3]


@pytest.mark.parametrize("ratio", [RATIO, -RATIO, -2.5])
def test_torsion_of_a_geared_pair_is_that_of_the_equivalent_shaft(ratio):
    # Refer the slow side to the fast one: inertia and stiffness times ratio² (any textbook on
    # torsional vibration, Nestorides 1958); two inertias on the springs in series. Shaft inertia
    # 1e-3 kg/m³ leaves 1e-9 of it.
    series = 1 / (1 / _stiffness("fast") + 1 / (ratio**2 * _stiffness("slow")))
    reduced = 1 / (1 / INERTIA["fast"] + 1 / (ratio**2 * INERTIA["slow"]))
    pair = _pair(ratio)
    assert _torsion(pair)[0] == pytest.approx(np.sqrt(series / reduced), rel=1e-7)
    # one rigid motion: both shafts turning together, position and velocity
    assert rd.modes_at_speed(pair, 0.0).zero_count == 2


@pytest.mark.parametrize("stiffness", [3e6, 1e8, 1e13, 1e16])
def test_teeth_are_a_spring_in_series_and_keep_their_digits_where_stiff(stiffness):
    stiff = _torsion(_pair(mesh_stiffness_n_per_m=stiffness, base_radius_first_m=0.07))[0]
    shafts = 1 / (1 / _stiffness("fast") + 1 / (RATIO**2 * _stiffness("slow")))
    slower = 1 / np.sqrt(1 + shafts / (stiffness * 0.07**2))
    assert stiff == pytest.approx(slower * _torsion(_pair())[0], rel=1e-9)


def test_teeth_press_along_the_line_of_action():
    # A force along the line of action pulls seat 1 and turns it: k δ with δ = n·u1 + r θ1.
    stiffness, radius, angle = 1e7, 0.07, 0.4
    rotors = _rotors(-RATIO, 1.0)
    mesh = {"mesh_stiffness_n_per_m": stiffness, "base_radius_first_m": radius}
    gear = _gear(-RATIO, line_of_action_rad=angle, **mesh)
    held = tuple(connect(name, f"{name}.seat", stiffness=1e5) for name in rotors)
    with_gear = rd.assemble(rotors, held, gears=(gear,))
    without = rd.assemble(rotors, held)
    # the same motion of the bodies in both: q = T x, and K summed over the bodies
    spread = np.linalg.pinv(with_gear.transformation)
    free = np.linalg.pinv(without.transformation)
    difference = spread.T @ with_gear.stiffness @ spread - free.T @ without.stiffness @ free
    fast = with_gear.system.rotors["fast"].element
    slow = with_gear.system.rotors["slow"].element
    start = with_gear.body_slices["slow"].start
    row = np.zeros(difference.shape[0])
    for name, value in {"ux": np.cos(angle), "uy": np.sin(angle), "rz": radius}.items():
        row[fast.interface_index("seat", name)] = value
    for name, value in {"ux": -np.cos(angle), "uy": -np.sin(angle), "rz": radius / RATIO}.items():
        row[start + slow.interface_index("seat", name)] = value
    # rounding is that of the shafts' own stiffness, 1e10 N/m
    assert difference == pytest.approx(stiffness * np.outer(row, row), abs=1e-2)


def test_axial_motion_and_torsion_of_a_beam_are_those_of_a_rod():
    # free-free rod: ω = π c / L, c² = E/ρ or G/ρ; linear elements err by (π h / L)² / 24
    count, length = 40, 0.8
    own = (np.linspace(0, length, count + 1), 0.02, {"a": 0.0, "b": length})
    free = one_rotor(steel_shaft("rod", *own, inner=0.01, components=ALL), (), 0.0)
    found = 2 * np.pi * rd.modes_at_speed(free, 0.0).frequency_hz
    for modulus in (2e11, 2e11 / 2.6):
        exact = np.pi / length * np.sqrt(modulus / 7800)
        assert np.abs(found / exact - 1).min() < 1.1 * (np.pi / count) ** 2 / 24
    assert rd.modes_at_speed(free, 0.0).zero_count == 12


REFUSALS = {
    "ratio of speeds": ({"ratio": 0.5}, "ratio is 0.5, but 'fast' turns at 1 and 'slow' at 0.315"),
    "no radius": ({"ratio": RATIO, "mesh_stiffness_n_per_m": 1e8}, "base_radius_first_m is needed"),
    "zero ratio": ({"ratio": 0.0}, "ratio is 0.0; finite and not 0"),
    "only damping": (
        {"ratio": RATIO, "mesh_damping_n_s_per_m": 1.0},
        "a rigid mesh has no damping",
    ),
    "one body": (
        {"ratio": 1.0, "second": rd.End(body="fast", interface="far")},
        "both seats are on body 'fast'",
    ),
    "no such seat": (
        {"ratio": RATIO, "second": rd.End(body="slow", interface="middle")},
        "slow.middle: rotor 'slow' has interfaces",
    ),
}


@pytest.mark.parametrize("name", REFUSALS)
def test_gear_that_can_not_be(name):
    changes, message = REFUSALS[name]
    with pytest.raises(rd.AssemblyError, match=message):
        rd.assemble(_rotors(RATIO), (), gears=(_gear(**changes),))


def test_gear_needs_torsion():
    lateral = steel_shaft("s", [0.0, 1.0], 0.02, {"seat": 0.0})
    rotors = {name: turning(lateral) for name in ("a", "b")}
    first, second = (rd.End(body=name, interface="seat") for name in rotors)
    gear = _gear(1.0, first=first, second=second)
    with pytest.raises(rd.AssemblyError, match=r"needs components \['rz'\]"):
        rd.assemble(rotors, (), gears=(gear,))


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
@pytest.mark.parametrize("mesh", [{}, {"mesh_stiffness_n_per_m": 1e8, "base_radius_first_m": 0.1}])
def test_a_consistent_loop_holds_nothing_more(order, mesh):
    """Two shafts of one speed tied in rz, geared twice to a third: the second gear says nothing."""
    ratios = {"one": 1.0, "idler": -1.0, "other": 1.0}
    body = (10.0, (0.0, 0.0, 0.1), (0.1, 0.1, 0.15), {"a": 0.0, "b": 0.3})
    rotors = {name: turning(rigid_superelement(name, *body), r) for name, r in ratios.items()}
    own = {"stiffness": 1e6, "axial_stiffness_n_per_m": 1e6}
    places = [f"{name}.{place}" for name in rotors for place in "ab"]
    bearings = [connect(place, place, **own) for place in places]
    ends = [rd.End(body=name, interface="a") for name in rotors]
    tie = connect("tie", ends[0], ends[2], rigid=("rz",))
    gears = [
        rd.Gear(name="in", first=ends[0], second=ends[1], ratio=-1.0, **mesh),
        rd.Gear(name="out", first=ends[1], second=ends[2], ratio=-1.0),
    ]
    closed = rd.assemble(rotors, (*bearings, tie), gears=tuple(gears[at] for at in order))
    open_chain = rd.assemble(rotors, (*bearings, tie), gears=(gears[1],))
    # the whole train turns freely: 18 coordinates, one tie, one gear
    assert closed.size == open_chain.size == 16
    found, wanted = (rd.modes_at_speed(s, 100.0).eigenvalues for s in (closed, open_chain))
    np.testing.assert_allclose(found, wanted, rtol=1e-10)
