"""Time per step and error of a run-up, beside the plain integrator and the floor of one mat-vec.

An engine of three spools and a casing, made of beams, with the unbalances and the profile of Müller
and Hennings, section 5.8: 20 s to 13 690 rpm, 10 s there. Everything in one process on one core;
ratios are what to quote, machines differ.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "rotordyn"))

from plain_run_up import run_up_newmark

from solidwhirl.rotordyn import Bearing, Disk, End, Rotor, assemble, beam_superelement
from solidwhirl.rotordyn.assembly.coordinates import interface_row
from solidwhirl.rotordyn.response.unbalance import Unbalance
from solidwhirl.rotordyn.run_up.blocks import propagate
from solidwhirl.rotordyn.run_up.complexity import rigid_bodies_system
from solidwhirl.rotordyn.run_up.integration import MotionState, ramp_and_hold, run_up
from solidwhirl.rotordyn.run_up.modal_basis import modal_basis
from solidwhirl.rotordyn.run_up.speed_profile import SpeedProfile

DESIGN = 13_690.0 * np.pi / 30.0
STEP = 5e-5
#: Steps of the plain integrator and of the comparison of errors.
SHORT = 1000
MOUNT = "mount front"
UNBALANCES = (
    Unbalance(body="lp", interface="node 9", moment_kg_m=1e-6),
    Unbalance(body="hp", interface="node 5", moment_kg_m=1e-6),
    Unbalance(body="fan", interface="node 4", moment_kg_m=1e-4),
)


def engine(stations: int):
    """Fan, low and high pressure spool in a casing; more stations give more coordinates."""

    def shaft(name, start, stop, radii, seats, disks, material=(2e11, 0.3, 7800.0)):
        parts = [
            Disk(name=str(z), position_m=z, mass_kg=m, polar_kg_m2=p, diametral_kg_m2=d)
            for z, m, p, d in disks
        ]
        z = np.linspace(start, stop, stations)
        return beam_superelement(name, z, *radii, material, seats, parts)

    elements = {
        "lp": shaft(
            "lp", 0.0, 2.0, (0.05, 0.03), {"C": 0.3, "D": 1.8, "node 9": 1.0},
            [(0.15, 60.0, 10.0, 6.0), (1.85, 70.0, 12.0, 7.0)],
        ),
        "hp": shaft(
            "hp", 0.6, 1.6, (0.09, 0.08), {"E": 0.6, "F": 1.6, "node 5": 1.1},
            [(0.8, 40.0, 0.8, 0.6), (1.4, 30.0, 0.7, 0.5)],
        ),
        "fan": shaft(
            "fan", -0.8, -0.1, (0.08, 0.04), {"A": -0.6, "B": -0.2, "node 4": -0.8},
            [(-0.8, 500.0, 140.0, 75.0)],
        ),
        "casing": shaft(
            "casing", -0.7, 2.0, (0.6, 0.59),
            {"A": -0.6, "B": -0.2, "C": 0.3, "D": 1.8, "E": 0.6, "F": 1.6, "front": 0.0,
             "aft": 1.2},
            [], (7e10, 0.3, 2700.0),
        ),
    }  # fmt: skip

    def spring(name, first, second, stiffness, damping):
        return Bearing(
            name=name,
            first=first,
            second=second,
            stiffness_n_per_m=stiffness * np.eye(2),
            damping_n_s_per_m=damping * np.eye(2),
        )

    seats = [("A", "fan", 8.54e7, 3000.0), ("B", "fan", 8.54e7, 3000.0)]
    seats += [("C", "lp", 4.53e7, 1000.0), ("D", "lp", 4.53e7, 1000.0)]
    seats += [("E", "hp", 5.54e7, 1000.0), ("F", "hp", 5.54e7, 1000.0)]
    bearings = [
        spring(at, End(body=body, interface=at), End(body="casing", interface=at), k, c)
        for at, body, k, c in seats
    ]
    bearings += [
        spring(f"mount {at}", End(body="casing", interface=at), None, 1e7, 5e3)
        for at in ("front", "aft")
    ]
    ratios = {"lp": 1.0, "hp": -1.32, "fan": 0.315, "casing": 0.0}
    rotors = {name: Rotor(element=elements[name], speed_ratio=r) for name, r in ratios.items()}
    return assemble(rotors, tuple(bearings), "lp")


def seconds_per_call(function, calls: int) -> float:
    function()
    begun = time.perf_counter()
    for _ in range(calls):
        function()
    return (time.perf_counter() - begun) / calls


def errors(system, step: float) -> tuple[float, float]:
    """Relative error of the displacement at node 9 of both integrators on a short steep ramp."""
    output = End(body="lp", interface="node 9")
    duration = SHORT * STEP
    profile = SpeedProfile(
        times_s=[0.0, duration], speeds_rad_s=[0.5 * DESIGN, 0.5 * DESIGN + 71.7 * duration]
    )
    options = {"outputs": [output], "step_s": step}
    exact = run_up(
        system,
        profile,
        UNBALANCES,
        outputs=[output],
        step_s=0.25 * step,
        record_every=4,
        phase_error_rad=1e-8,
    )
    expected = exact.translation_m[0, 0]
    run = run_up(system, profile, UNBALANCES, **options)
    still = MotionState(displacement=np.zeros(system.size), velocity=np.zeros(system.size))
    plain = run_up_newmark(system, profile, UNBALANCES, step, still)
    other = plain.displacement @ interface_row(system, output.body, output.interface, "ux")
    size = np.abs(expected).max()
    return (
        float(np.abs(run.translation_m[0, 0] - expected).max() / size),
        float(np.abs(other - expected).max() / size),
    )


def measure(system) -> dict:
    profile = ramp_and_hold(DESIGN, 20.0, 10.0)
    begun = time.perf_counter()
    run = run_up(
        system,
        profile,
        UNBALANCES,
        step_s=STEP,
        record_every=4,
        outputs=[End(body="lp", interface="node 9")],
        bearings=[MOUNT],
    )
    total = time.perf_counter() - begun
    steps = round(profile.duration_s / STEP)

    n = modal_basis(system).size
    matrix = np.asfortranarray(np.eye(2 * n))
    vector, loads = np.ones(2 * n), np.zeros((2, 2 * n))
    floor = seconds_per_call(lambda: matrix @ vector, 20_000)
    bare = seconds_per_call(lambda: propagate(matrix, loads), 20_000)

    short = SpeedProfile(times_s=[0.0, SHORT * STEP], speeds_rad_s=[0.5 * DESIGN, 0.5 * DESIGN + 4])
    still = MotionState(displacement=np.zeros(n), velocity=np.zeros(n))
    begun = time.perf_counter()
    run_up_newmark(system, short, UNBALANCES, STEP, still)
    plain = (time.perf_counter() - begun) / SHORT
    error, plain_error = errors(system, STEP)
    balance = np.abs(run.energy.error_j).max() / np.abs(run.energy.load_work_j).max()
    return {
        "coordinates": n,
        "steps": steps,
        "run_s": total,
        "simulated_s_per_s": profile.duration_s / total,
        "step_us": 1e6 * total / steps,
        "bare_step_us": 1e6 * bare,
        "mat_vec_us": 1e6 * floor,
        "step_over_mat_vec": total / steps / floor,
        "newmark_step_us": 1e6 * plain,
        "newmark_over_step": plain * steps / total,
        "error": error,
        "newmark_error": plain_error,
        "energy_balance": float(balance),
    }


def main() -> None:
    """Run all sizes and print a table."""
    systems = [rigid_bodies_system(engine(2), ["casing", "fan"])]
    systems += [engine(stations) for stations in (2, 4, 6)]
    for at, system in enumerate(systems):
        row = measure(system)
        if at == 0:
            print("| " + " | ".join(row) + " |\n|" + "---|" * len(row))
        cells = (f"{v:.3g}" if isinstance(v, float) else str(v) for v in row.values())
        print("| " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
