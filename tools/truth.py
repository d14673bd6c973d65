"""Results of many machines as numbers, and which of two sets of them is right.

    .venv/bin/python tools/truth.py record FOLDER [--systems 2000] [--laws 500] [--asymmetric 200]
                                                  [--scenes]
    .venv/bin/python tools/truth.py compare OLD NEW [--all]
    .venv/bin/python tools/truth.py scenes OLD NEW [--within 1e-12]

`record` runs random machines (`truth_machines.py`), each the same for its number always, and writes
one file each; what is there already is not done again, so that more can be asked for later.
`--scenes` also runs the scenes. `compare` looks at what both folders have: values that are equal to
1e-9 are the same, others are told by `truth_oracle.py`, which shares nothing with the program but
the matrices stored in OLD, and decides which of the two is a root. `--all` also tests roots that
are equal, and looks for roots that both have missed. Where whole results are compared, `scenes`
names every number that differs. `compare` ends with 1 where NEW lost or invented something.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import resource
import signal
import subprocess
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
import numpy as np

# Processor time that an analysis of a machine, and a scene, may take, s.
LONGEST, LONGEST_SCENE = 5.0, 60
# Parts of the top speed at which modes are compared, and number of speeds of the other analyses.
PLACES = (0.0, 0.31, 0.62, 1.0)
BRANCHES = 12
# What differs between two runs of one scene.
PASSED_OVER = {
    "cpu_s",
    "analyses_cpu_s",
    "dense_problems",
    "body_problems",
    "peak_memory_gib",
    "timings_s",
    "wall_time_per_step_s",
    "wall_time_s",
}
Numbers = dict[str, np.ndarray]


def main() -> int:
    """Do what is asked for."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    commands = parser.add_subparsers(dest="command", required=True)
    one = commands.add_parser("record")
    one.add_argument("folder", type=Path)
    for kind, count in (("systems", 2000), ("laws", 500), ("asymmetric", 200)):
        one.add_argument(f"--{kind}", type=int, default=count)
    one.add_argument("--scenes", action="store_true")
    for name in ("compare", "scenes"):
        two = commands.add_parser(name)
        two.add_argument("old", type=Path)
        two.add_argument("new", type=Path)
    commands.choices["compare"].add_argument("--all", action="store_true")
    commands.choices["scenes"].add_argument("--within", type=float, default=1e-12)
    asked = parser.parse_args()
    if asked.command == "record":
        counts = {kind: getattr(asked, kind) for kind in ("systems", "laws", "asymmetric")}
        return record(asked.folder, counts, asked.scenes)
    if asked.command == "scenes":
        return compare_scenes(asked.old, asked.new, asked.within)
    import truth_verdicts

    return truth_verdicts.compare(asked.old, asked.new, asked.all)


# --- record ---------------------------------------------------------------------------------------


def record(folder: Path, counts: dict[str, int], scenes: bool) -> int:
    """Run what is not there yet."""
    import truth_machines

    drawn = {
        "systems": truth_machines.system,
        "laws": truth_machines.laws,
        "asymmetric": truth_machines.asymmetric,
    }
    # a bit of each kind at a time, so that what is there early is of every kind
    rounds = 50
    for turn in range(rounds):
        for kind, count in counts.items():
            (folder / kind).mkdir(parents=True, exist_ok=True)
            for number in range(turn * count // rounds, (turn + 1) * count // rounds):
                path = folder / kind / f"{number:04d}.npz"
                if not path.exists():
                    with warnings.catch_warnings():
                        warnings.simplefilter("ignore")
                        _write(path, _of_machine(kind, drawn[kind], number))
        print(f"{turn + 1} of {rounds} parts", flush=True)
    if scenes:
        run_scenes(folder / "scenes")
    return 0


def _write(path: Path, found: Numbers) -> None:
    beside = path.with_suffix(".part")
    with beside.open("wb") as stream:
        np.savez_compressed(stream, **found)
    beside.rename(path)


def _of_machine(kind: str, drawn: Callable[[int], Any], number: int) -> Numbers:
    """All numbers of a machine by a path of names; texts of what was refused under `refused/`."""
    found: Numbers = {}
    begun = time.process_time()

    def of(name: str, compute: Callable[[], Any]) -> Any:
        try:
            signal.setitimer(signal.ITIMER_PROF, LONGEST)
            made = compute()
            signal.setitimer(signal.ITIMER_PROF, 0.0)
        except Exception as error:  # whatever it is, it is the result
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            found[f"refused/{name}"] = np.array(f"{type(error).__name__}: {error}"[:2000])
            return None
        found.update(_flat(name, made) if isinstance(made, (dict, list)) else {})
        return made

    signal.signal(signal.SIGPROF, _too_long)
    machine = of("machine", lambda: drawn(number))
    if machine is not None:
        (_asymmetric if kind == "asymmetric" else _round)(machine, number, of)
    found["cpu_s"] = np.array(time.process_time() - begun)
    return found


def _too_long(*_: Any) -> None:
    raise TimeoutError(f"more than {LONGEST:g} s")


def _flat(name: str, value: Any) -> Numbers:
    if isinstance(value, list):
        value = {str(k): own for k, own in enumerate(value)}
    if not isinstance(value, dict):
        return {name: np.asarray(value)}
    parts = [_flat(f"{name}/{key}", own) for key, own in value.items()]
    return {key: own for part in parts for key, own in part.items()}


def _round(machine: Any, number: int, of: Callable[..., Any]) -> None:
    """Modes, diagram, critical speeds, stability and responses of a machine."""
    from solidwhirl import rotordyn as rd
    from solidwhirl.rotordyn.response.stiffness_maps import synchronous_stiffness_map
    from solidwhirl.rotordyn.response.unbalance import Unbalance, unbalance_response
    from solidwhirl.rotordyn.stability import unstable_intervals

    top = machine.top
    system = of("assembled", machine.assembled)
    if system is None:
        return
    of("kinds", lambda: {"all": sorted(machine.kinds), "top": top})
    of("laws", lambda: {k: {**w, "json": _chains(w)} for k, w in machine.laws.items()})
    of("matrices", lambda: _matrices(machine, system))
    for part in PLACES:
        of(f"modes/{part}", lambda part=part: _modes(rd.modes_at_speed(system, part * top)))
    speeds = np.linspace(0.0, top, 5 if "frequency" in machine.kinds else 9)
    of("campbell", lambda: _campbell(rd.campbell(system, speeds, branch_count=BRANCHES)))
    for ratio in (1.0, 0.5) if number % 3 == 0 else (1.0,):
        of(f"critical/{ratio}", lambda r=ratio: _critical(rd.critical_speeds(system, r, top)))
    of("unstable", lambda: _intervals(unstable_intervals(system, 0.0, top)))
    places = [
        u for u in ("c", "a") if u in {n.name for n in machine.rotors["r0"].element.interfaces}
    ]
    load = Unbalance(body="r0", interface=places[0], moment_kg_m=1e-4, phase_rad=0.3)
    at = np.linspace(0.07, 0.97, 7) * top
    of("response", lambda: _response(unbalance_response(system, [load], at)))
    names = [b.name for b in machine.bearings if b.speed_law is None and not b.rigid][:1]
    if names and number % 5 == 0:
        stiffness = np.geomspace(1e5, 1e9, 7)
        of("map", lambda: _map(system, names, stiffness, top))
        node = rd.End(body="r0", interface="b")
        of(
            "stiffness_map",
            lambda: {
                "translation": synchronous_stiffness_map(
                    system, names, stiffness[::2], load, at, node
                ).translation_m
            },
        )


def _chains(law: dict[str, Any]) -> str:
    return json.dumps({axis: law[axis] for axis in "xy" if isinstance(law.get(axis), dict)})


def _matrices(machine: Any, system: Any) -> dict[str, Any]:
    """M, C, G, K, K2, N, the motions of the laws, seats: what the oracle needs, in numbers."""
    from solidwhirl.rotordyn import End
    from solidwhirl.rotordyn.assembly.coordinates import seat_motion

    names = (
        "mass",
        "damping",
        "gyroscopic",
        "stiffness",
        "centrifugal_stiffness",
        "circulatory_stiffness",
    )
    laws = {j.bearing: j.motion for j in system.law_joints}
    seats = {
        f"{body}.{node.name}": seat_motion(system, End(body=body, interface=node.name))
        for body, rotor in machine.rotors.items()
        for node in rotor.element.interfaces
    }
    ratios = {body: rotor.speed_ratio for body, rotor in machine.rotors.items()}
    own = {name: getattr(system, name) for name in names}
    return {**own, "motions": laws, "seats": seats, "ratios": ratios}


def _modes(modes: Any) -> dict[str, Any]:
    return {
        "values": modes.eigenvalues,
        "real": modes.real_eigenvalues,
        "zeros": modes.zero_count,
        "speed": modes.speed_rad_s,
    }


def _campbell(diagram: Any) -> dict[str, Any]:
    return {"values": diagram.eigenvalues, "speeds": diagram.speeds_rad_s, "whirl": diagram.whirl}


def _critical(found: Any) -> dict[str, Any]:
    return {
        "speeds": np.array([c.speed_rad_s for c in found]),
        "decrements": np.array([c.log_decrement for c in found]),
        "whirl": np.array([c.whirl for c in found], dtype=str),
    }


def _intervals(found: Any) -> dict[str, Any]:
    names = (
        "low_rad_s",
        "high_rad_s",
        "growth_1_s",
        "speed_rad_s",
        "opens",
        "closes",
        "frequency_hz",
    )
    return {
        name: np.array([float(getattr(one, name)) for one in found])
        for name in names
        if all(hasattr(o, name) for o in found)
    }


def _response(found: Any) -> dict[str, Any]:
    (exciter,) = found.exciters
    nodes = np.array([f"{end.body}.{end.interface}" for end in exciter.nodes])
    load = found.unbalances[0]
    return {
        "speeds": found.speeds_rad_s,
        "nodes": nodes,
        "translation": exciter.translation_m,
        "at": f"{load.body}.{load.interface}",
        "moment": load.moment_kg_m,
        "phase": load.phase_rad,
    }


def _map(system: Any, names: list[str], stiffness: np.ndarray, top: float) -> dict[str, Any]:
    from solidwhirl.rotordyn.critical_speeds.map import critical_speed_map

    found = critical_speed_map(system, names, stiffness, speed_max_rad_s=top)
    return {"speeds": found.speed_rad_s, "free": found.free_rad_s, "rigid": found.rigid_rad_s}


def _asymmetric(machine: Any, number: int, of: Callable[..., Any]) -> None:
    """Unstable ranges, exponents, critical speeds and steady motion of an asymmetric machine."""
    from solidwhirl.rotordyn import asymmetric
    from solidwhirl.rotordyn.asymmetric.resonances import critical_speeds, gravity_critical_speeds
    from solidwhirl.rotordyn.asymmetric.response import steady_motion

    rotating, periodic, low, high = None, machine, 0.5, 6.0
    if hasattr(machine, "rotors"):
        rotating = of("assembled", machine.rotating)
        if rotating is None:
            return
        periodic, low, high = rotating.periodic, 0.05 * machine.top, machine.top
    of("range", lambda: {"low": low, "high": high})
    of("terms", lambda: _terms(periodic))
    speeds = np.linspace(low, high, 5)
    if periodic.stride:
        of(
            "exponents",
            lambda: {"values": asymmetric.floquet_exponents(periodic, speeds), "speeds": speeds},
        )
    of("unstable", lambda: _intervals(asymmetric.unstable_ranges(periodic, low, high)))
    load = np.cos(np.arange(periodic.size) + number)
    of(
        "steady",
        lambda: {
            "load": load,
            "speeds": speeds,
            "motion": [_harmonics(steady_motion(periodic, float(v), {0: load})) for v in speeds],
        },
    )
    if rotating is not None:
        for name, search in (("critical", critical_speeds), ("gravity", gravity_critical_speeds)):
            of(name, lambda search=search: _resonances(search(rotating, low, high)))


def _terms(periodic: Any) -> dict[str, Any]:
    return {
        "mass": periodic.mass,
        "stride": periodic.stride,
        **{
            part: [{"harmonic": h, "power": p, "matrix": a} for h, p, a in getattr(periodic, part)]
            for part in ("velocity", "stiffness")
        },
    }


def _harmonics(found: Any) -> dict[str, Any]:
    return {str(h): part for h, part in found.items()}


def _resonances(found: Any) -> dict[str, Any]:
    return {
        "speeds": np.array([c.speed_rad_s for c in found]),
        "ratios": np.array([c.damping_ratio for c in found]),
    }


# --- scenes ---------------------------------------------------------------------------------------


def run_scenes(folder: Path) -> None:
    """Run every scene that is not there into a folder of its own; what takes long is left."""
    for scene in sorted((Path(__file__).parents[1] / "scenes").glob("*.toml")):
        out = folder / scene.stem
        if (out / "results.json").exists() or (out / "refused.txt").exists():
            continue
        command = [sys.executable, "-m", "solidwhirl", "run", str(scene), "--out", str(out)]
        done = subprocess.run(command, capture_output=True, text=True, preexec_fn=_limit_processor)
        is_there = (out / "results.json").exists()
        text = "" if is_there else f"exit code {done.returncode}: {done.stderr[-2000:]}"
        if text:
            out.mkdir(parents=True, exist_ok=True)
            (out / "refused.txt").write_text(text)
        print(f"{scene.stem}: {text[-200:] or 'run'}", flush=True)


def _limit_processor() -> None:
    resource.setrlimit(resource.RLIMIT_CPU, (LONGEST_SCENE, LONGEST_SCENE))


def compare_scenes(old: Path, new: Path, within: float) -> int:
    """Print every number of `results.json` that differs, relative to itself or its list."""
    found = 0
    for path in sorted(old.glob("**/results.json")):
        name = path.relative_to(old)
        if not (new / name).exists():
            print(f"{name}: not in {new}")
            found += 1
            continue
        pair = (json.loads(p.read_text(encoding="utf-8")) for p in (path, new / name))
        lines = list(_differences(*pair, within))
        print(f"{name}: {len(lines)} differences")
        for line in lines[:40]:
            print(f"  {line}")
        found += len(lines)
    return int(found > 0)


def _differences(a: Any, b: Any, within: float, at: str = "", size: float = 0.0) -> Iterator[str]:
    if isinstance(a, dict) and isinstance(b, dict):
        for key in sorted((a.keys() | b.keys()) - PASSED_OVER):
            if key not in a or key not in b:
                yield f"{at}.{key}: only in the {'old' if key in a else 'new'}"
            else:
                yield from _differences(a[key], b[key], within, f"{at}.{key}")
    elif isinstance(a, list) and isinstance(b, list):
        if len(a) != len(b):
            yield f"{at}: {len(a)} and {len(b)} entries"
            return
        largest = max((abs(x) for x in a if _is_number(x)), default=0.0)
        for i, (x, y) in enumerate(zip(a, b, strict=True)):
            yield from _differences(x, y, within, f"{at}[{i}]", largest)
    elif _is_number(a) and _is_number(b):
        if abs(a - b) > within * max(abs(a), size):
            yield f"{at}: {a!r} and {b!r}"
    elif a != b:
        yield f"{at}: {str(a)[:120]} and {str(b)[:120]}"


def _is_number(x: Any) -> bool:
    return isinstance(x, (int, float)) and not isinstance(x, bool) and math.isfinite(x)


if __name__ == "__main__":
    raise SystemExit(main())
