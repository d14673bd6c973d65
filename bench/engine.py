"""Time of the engine-wide analyses beside ROSS's compressor example, in one run on one thread.

`python bench/engine.py [scene.toml]`: the engine is the one of the scene, or else a fan and two
spools made of beams. Different rotors: only times are compared, per speed, stiffness or step. The
floor of each figure is the linear algebra that no program of this kind does without.
"""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path

for variable in ("OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[variable] = "1"

import numpy as np  # noqa: E402
import scipy.linalg as la  # noqa: E402

from solidwhirl.rotordyn import (  # noqa: E402
    AssembledSystem,
    Bearing,
    Disk,
    End,
    Rotor,
    assemble,
    beam_superelement,
    campbell,
    complex_form,
    matrices_at_speed,
)
from solidwhirl.rotordyn.assembly.bearing_laws import PolynomialLaw  # noqa: E402
from solidwhirl.rotordyn.critical_speeds.map import critical_speed_map  # noqa: E402
from solidwhirl.rotordyn.response.maps import ground_motion_map  # noqa: E402
from solidwhirl.rotordyn.response.unbalance import Unbalance, unbalance_response  # noqa: E402
from solidwhirl.rotordyn.run_up.integration import ramp_and_hold, run_up  # noqa: E402

ROOT = Path(__file__).parents[1]
TOP_RAD_S = 1000.0
BRANCHES = 12
SPEEDS, POINTS, STEPS = 51, 31, 20_000
WATERFALL = (51, 250)
#: How many times faster than ROSS each analysis is meant to be.
GOALS = {"campbell": 30.0, "unbalance": 50.0, "map": 20.0, "run_up": 20.0}
LABELS = {
    "campbell": "Campbell diagram, per speed",
    "unbalance": "unbalance response, per speed",
    "map": "critical speed map, per stiffness",
    "run_up": "run-up, per step",
    "waterfall": f"waterfall {WATERFALL[1]} x {WATERFALL[0]}, in all",
}


@dataclass(frozen=True)
class Engine:
    """A system, where its unbalance sits, and which bearings a map varies."""

    name: str
    assembled: AssembledSystem
    place: End
    bearings: tuple[str, ...]


LAW = PolynomialLaw(
    name="oil film",
    argument_unit="rad/s",
    argument_range=(0.0, 2.0 * TOP_RAD_S),
    stiffness_x=(1.0, 2e-4),
    stiffness_y=(1.0, 3e-4),
    damping_x=(1.0, -1e-4),
    damping_y=(1.0, -1e-4),
)


def beam_engine(name: str, evenness: float, damping_s: float, law=None) -> Engine:
    """Fan at 0.35, low-pressure spool at 1 and counter-rotating high-pressure spool at -1.6.

    `law` acts on a bearing of the fan and one of the low-pressure spool.
    """

    def disk(label, z, mass, polar):
        return Disk(
            name=label, position_m=z, mass_kg=mass, polar_kg_m2=polar, diametral_kg_m2=0.52 * polar
        )

    def spool(label, start, stop, elements, radii, held, disks):
        stations = np.linspace(start, stop, elements + 1)
        return beam_superelement(label, stations, *radii, (2e11, 0.3, 7800.0), held, disks)

    fan_disks = [disk("fan", -0.5, 120.0, 18.0)]
    low_disks = [disk("booster", 0.25, 40.0, 1.2), disk("rear", 1.9, 38.0, 1.9)]
    high_disks = [disk("compressor", 0.75, 45.0, 1.5), disk("turbine", 1.35, 40.0, 1.3)]
    low_seats = {"front": 0.0, "mid": 0.5, "inter": 1.5, "rear": 2.0}
    bodies = {
        "fan": (spool("fan", -0.5, -0.02, 4, (0.07, 0.05), {"front": -0.38, "rear": -0.02},
                      fan_disks), 0.35),
        "low": (spool("low", 0.0, 2.0, 12, (0.045, 0.035), low_seats, low_disks), 1.0),
        "high": (spool("high", 0.6, 1.5, 6, (0.09, 0.08), {"front": 0.6, "rear": 1.5},
                       high_disks), -1.6),
    }  # fmt: skip

    def bearing(body, seat, stiffness, second=None, speed_law=None):
        k = stiffness * np.diag([1.0, evenness])
        return Bearing(
            name=f"{body} {seat}",
            first=End(body=body, interface=seat),
            second=second,
            stiffness_n_per_m=k,
            damping_n_s_per_m=damping_s * k,
            speed_law=speed_law,
        )

    bearings = (
        bearing("fan", "front", 8e7, speed_law=law),
        bearing("fan", "rear", 4e7),
        bearing("low", "front", 3e7),
        bearing("low", "mid", 5e7, speed_law=law),
        bearing("low", "rear", 3e7),
        bearing("high", "front", 4e7),
        bearing("high", "rear", 3e7, End(body="low", interface="inter")),
    )
    rotors = {key: Rotor(element=e, speed_ratio=ratio) for key, (e, ratio) in bodies.items()}
    assembled = assemble(rotors, bearings, "low")
    return Engine(name, assembled, End(body="low", interface="rear"), ("low front", "low rear"))


def scene_engine(path: str) -> Engine:
    """Engine of a scene; unbalance and map at the first lateral places found."""
    from solidwhirl.pipeline.run import run_scene
    from solidwhirl.scene_reading.reader import read_scene

    assembled = run_scene(read_scene(Path(path))).system
    turning = [(n, r) for n, r in assembled.system.rotors.items() if r.speed_ratio != 0]
    body, rotor = turning[0]
    seat = next(
        i.name for i in rotor.element.interfaces if "ux" in rotor.element.components_at(i.name)
    )
    free = tuple(b.name for b in assembled.system.bearings if not {"ux", "uy"} & set(b.rigid))
    return Engine(Path(path).stem, assembled, End(body=body, interface=seat), free[:1])


def shortest(run, repeats=3) -> float:
    """Return the shortest processor time of some repeats, s."""
    times = []
    for _ in range(repeats):
        start = time.process_time()
        run()
        times.append(time.process_time() - start)
    return min(times)


def measure(engine: Engine) -> dict[str, float]:
    """Return seconds per item of each analysis."""
    system = engine.assembled
    unbalance = Unbalance(
        body=engine.place.body, interface=engine.place.interface, moment_kg_m=1e-3
    )
    # a tenth of a turn per step of the reference shaft
    step = 0.1 * 2.0 * np.pi / TOP_RAD_S
    profile = ramp_and_hold(TOP_RAD_S, STEPS * step)
    speeds = np.linspace(0.0, TOP_RAD_S, SPEEDS)
    stiffness = np.geomspace(1e6, 1e9, POINTS)
    frequencies = np.linspace(0.0, 2.0 * TOP_RAD_S, WATERFALL[1])
    grid = np.linspace(0.0, TOP_RAD_S, WATERFALL[0])
    runs = {
        # a copy, of which no modes are kept from the repeat before
        "campbell": (lambda: campbell(replace(system), speeds, branch_count=BRANCHES), SPEEDS),
        "unbalance": (lambda: unbalance_response(system, [unbalance], speeds), SPEEDS),
        "map": (
            lambda: critical_speed_map(
                system, engine.bearings, stiffness, branch_count=4, speed_max_rad_s=2 * TOP_RAD_S
            ),
            POINTS,
        ),
        "run_up": (
            lambda: run_up(
                system, profile, [unbalance], step_s=step, record_every=10, outputs=[engine.place]
            ),
            STEPS,
        ),
        "waterfall": (
            lambda: ground_motion_map(system, 1e-6, "x", grid, frequencies, engine.place),
            1,
        ),
    }
    return {name: shortest(run) / items for name, (run, items) in runs.items()}


def state_matrix(system: AssembledSystem) -> np.ndarray:
    """Return the matrix of (q', q'')' at half of the top speed."""
    mass, damping, gyroscopic, stiffness = matrices_at_speed(system, 0.5 * TOP_RAD_S)
    lower = -la.solve(mass, np.hstack((stiffness, damping + gyroscopic)))
    return np.vstack((np.eye(system.size, 2 * system.size, system.size), lower))


def floors(engine: Engine) -> dict[str, tuple[str, float]]:
    """Return what bounds each analysis and its time, s."""
    system, n = engine.assembled, engine.assembled.size
    generator = np.random.default_rng(1)
    whole = generator.standard_normal((2 * n, 2 * n))
    form = complex_form(system)
    size = n if form is None else form.size
    square = whole[:size, :size]
    dynamic = square + 1j * whole[size : 2 * size, size : 2 * size]
    load = np.ones((size, 1), dtype=complex)
    state = np.ones(2 * n)

    def many(run, count):
        return lambda: [run() for _ in range(count)]

    def solve():
        la.lapack.zgesv(dynamic, load)

    if system.is_conservative and form is not None:
        text, run = f"eigh, real, {2 * size}", lambda: la.eigh(whole[: 2 * size, : 2 * size])
    elif system.is_conservative:
        text, run = f"svd, real, {n}", lambda: la.svd(whole[:n, :n])
    else:
        motion = state_matrix(system)
        text, run = f"eig, real, {2 * n}", lambda: la.eig(motion)
    one_solve = shortest(many(solve, 50)) / 50
    one_product = shortest(many(lambda: whole @ state, 500)) / 500
    return {
        "campbell": (text, shortest(run)),
        "unbalance": (f"complex LU, {size}", one_solve),
        "map": (f"eigh, real, {size}", shortest(lambda: la.eigh(square))),
        "run_up": (f"matrix times vector, {2 * n}", one_product),
        "waterfall": (
            f"{WATERFALL[0] * WATERFALL[1]} complex LU, {size}",
            one_solve * WATERFALL[0] * WATERFALL[1],
        ),
    }


def ross_times() -> dict[str, float]:
    """Return the times of ROSS, measured in its own environment."""
    python = ROOT / ".venv-ross" / "bin" / "python"
    script = Path(__file__).with_name("ross_compressor.py")
    done = subprocess.run([python, script], check=True, capture_output=True, text=True)
    return json.loads(done.stdout.splitlines()[-1])


def report(engine: Engine, ross: dict[str, float]) -> None:
    """Print the table of one engine."""
    ours, bounds = measure(engine), floors(engine)
    print(f"\n{engine.name}: {engine.assembled.size} coordinates\n")
    print("| analysis | ROSS | here | ratio | goal | met | floor | here / floor |")
    print("|---|---|---|---|---|---|---|---|")
    for name, label in LABELS.items():
        theirs = ross["point"] * WATERFALL[0] * WATERFALL[1] if name == "waterfall" else ross[name]
        ratio, goal = theirs / ours[name], GOALS.get(name)
        met = "" if goal is None else ("yes" if ratio >= goal else "no")
        text, floor = bounds[name]
        print(
            f"| {label} | {in_units(theirs)} | {in_units(ours[name])} | {ratio:.0f} | "
            f"{'' if goal is None else f'{goal:.0f}'} | {met} | {text}: {in_units(floor)} | "
            f"{ours[name] / floor:.1f} |",
            flush=True,
        )


def in_units(seconds: float) -> str:
    """Return a time with three digits."""
    for unit, size in (("s", 1.0), ("ms", 1e-3)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds * 1e6:.3g} µs"


def processor() -> str:
    """Return the name of the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.machine()
    return next((t.split(":")[1].strip() for t in lines if t.startswith("model name")), "")


def main() -> None:
    """Measure ROSS, then the engines, and print the tables."""
    ross = ross_times()
    print(f"{processor()}, one thread; Python {platform.python_version()}, numpy {np.__version__}")
    print(f"ROSS {ross['version']}, compressor example, {ross['coordinates']} coordinates")
    if len(sys.argv) > 1:
        engines = [scene_engine(sys.argv[1])]
    else:
        engines = [
            beam_engine("equal supports, no damping", 1.0, 0.0),
            beam_engine("unequal supports, no damping", 0.7, 0.0),
            beam_engine("unequal supports, damping", 0.7, 2e-5),
            beam_engine("unequal supports, damping, two speed laws", 0.7, 2e-5, LAW),
        ]
    for engine in engines:
        report(engine, ross)


if __name__ == "__main__":
    main()
