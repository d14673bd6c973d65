"""Time, memory and error beside CalculiX, Exudyn and ROSS on the reference rotor, in one run.

`python bench/peers.py` writes out/peers/peers.json and prints tables. What the other programs took
is kept in out/peers/store and used again while decks, scripts and versions are the same; `--fresh`
measures it anew, `--peers-only` leaves solidwhirl out. CPU time and peak memory are those of whole
processes, start-up included.
"""

from __future__ import annotations

import json
import sys
import time

import peers_calculix as calculix
from peers_run import (
    BENCH,
    EXUDYN,
    OUT,
    PYTHON,
    ROSS,
    SOLIDWHIRL,
    Store,
    key_of,
    machine,
    measured,
    read,
    run,
)
from peers_table import tables

#: Free modes CalculiX is asked for: the tenth elastic lateral one is the 26th.
MODES = 30
#: To show what asking for fewer saves CalculiX; these hold eight of the ten lateral modes.
FEWER_MODES = 20
TOP_RPM, SPEEDS = 20_000.0, 21
ALL_RPM = [TOP_RPM * k / (SPEEDS - 1) for k in range(SPEEDS)]
ONE_RPM = TOP_RPM / 2
#: Speeds measured one by one where the whole diagram is not run, by mesh.
SAMPLES = {"even": [0.0, ONE_RPM], "graded, finer": [0.0, 2_000.0, ONE_RPM, TOP_RPM]}
#: Short runs are repeated; the middle one counts.
REPEATS = 3
ACCURACIES = {
    "harmonic": ("1e-2", "3e-3", "1e-3", "3e-4", "1e-4"),
    "solid": ("1e-2", "3e-3", "1e-3"),
}
SCENE = """name = "reference"
title = "Free steel rotor"

[speeds]
from_rpm = 0
to_rpm = 20000
count = 21

[campbell]
branches = 10

[bodies.rotor]
material = "steel"
sections = [
    { name = "shaft", start_m = 0.0, end_m = 0.4, outer_radius_m = 0.02 },
    { name = "disk", start_m = 0.145, end_m = 0.175, inner_radius_m = 0.02, outer_radius_m = 0.15 },
]
interfaces = [
    { name = "left", kind = "section", at_m = 0.0 },
    { name = "right", kind = "section", at_m = 0.4 },
]
"""


def calculix_job(mesh: dict, speeds: list[float], modes: int) -> dict:
    """One CalculiX process over some speeds of a mesh."""
    folder = OUT / "calculix"
    folder.mkdir(exist_ok=True)
    model = (OUT / f"{mesh['stem']}.mesh").read_text()
    (folder / "rotor.inp").write_text(model + calculix.steps(mesh["pins"], speeds, modes))
    done = run([calculix.program()[0], "rotor"], folder)
    hz = calculix.read_frequencies((folder / "rotor.dat").read_text(), speeds)
    return {**done, "speed_rpm": speeds, "frequency_hz": hz}


def calculix_stored(store: Store, mesh: dict, speeds: list[float], modes: int = MODES) -> dict:
    """A job of CalculiX, measured or stored."""
    steps = calculix.steps(mesh["pins"], speeds, modes)
    key = key_of(mesh["sha256"], steps, calculix.program()[1])
    what = "all" if len(speeds) > 1 else f"{speeds[0]:.0f}"
    name = f"calculix_{mesh['stem']}_{what}" + ("" if modes == MODES else f"_{modes}_modes")
    return store.get(name, key, lambda: calculix_job(mesh, speeds, modes))


def calculix_all(store: Store, meshes: dict) -> dict:
    """One speed and the diagram on the three meshes.

    On the smallest mesh one process runs all speeds. On the others single speeds are run and the 20
    above 0 are charged their mean; `cpu_21_s` holds the sum.
    """
    found = {}
    for name in ("graded", "graded, finer", "even"):
        mesh = meshes[name]
        listed = SAMPLES.get(name, [0.0, ONE_RPM])
        done = {f"{rpm:.0f}": calculix_stored(store, mesh, [rpm]) for rpm in listed}
        above = [v["cpu_s"] for k, v in done.items() if k != "0"]
        if name in SAMPLES:
            whole = done["0"]["cpu_s"] + (SPEEDS - 1) * sum(above) / len(above)
            how = f"{len(above)} of 20 speeds run"
        else:
            done["all"] = calculix_stored(store, mesh, ALL_RPM)
            whole, how = done["all"]["cpu_s"], "run"
        one = done[f"{ONE_RPM:.0f}"]
        found[name] = {**one, "jobs": done, "cpu_21_s": whole, "how_21": how, "rest": done["0"]}
    fewer = calculix_stored(store, meshes["graded, finer"], [ONE_RPM], FEWER_MODES)
    return {"meshes": found, "fewer_modes": {**fewer, "modes": FEWER_MODES}}


def exudyn_all(store: Store, meshes: dict) -> dict:
    """Reduction of two meshes; matrices by CalculiX, not charged to Exudyn."""
    script = BENCH / "peers_exudyn.py"
    stamp = (EXUDYN.parents[1] / ".installed").read_text()
    found = {}
    for name in ("graded, between", "even"):
        mesh = meshes[name]
        stem = OUT / mesh["stem"]

        def measure(mesh=mesh, stem=stem):
            deck = (OUT / f"{mesh['stem']}.mesh").read_text() + calculix.MATRICES
            stem.with_suffix(".inp").write_text(deck)
            run([calculix.program()[0], mesh["stem"]])
            run([EXUDYN, script, "matrices", stem])
            for suffix in (".mas", ".sti", ".dof", ".inp"):
                stem.with_suffix(suffix).unlink()
            written = stem.with_name(f"{stem.name}_exudyn.json")
            return measured([EXUDYN, script, "reduce", stem], written)

        key = key_of(mesh["sha256"], script.read_text(), stamp)
        found[name] = store.get(f"exudyn_{mesh['stem']}", key, measure)
    return found


def ross_all(store: Store) -> dict:
    """Campbell diagram with the wheel as a rigid disk, and as steps of the shaft."""
    script = BENCH / "peers_ross.py"
    stamp = (ROSS.parents[1] / ".installed").read_text()
    found = {}
    for wheel in ("disk", "steps"):
        written = OUT / f"ross_{wheel}.json"
        command = [ROSS, script, wheel, written]
        found[wheel] = store.get(
            f"ross_{wheel}",
            key_of(script.read_text(), stamp, wheel),
            lambda command=command, written=written: measured(command, written, REPEATS),
        )
    return found


def ours_at(level: str) -> dict:
    """`solidwhirl run` of the scene on a level at several accuracies."""
    scene = OUT / "reference.toml"
    scene.write_text(SCENE)
    found = {}
    for accuracy in ACCURACIES[level]:
        folder = OUT / f"run_{level}_{accuracy}"
        command = [SOLIDWHIRL, "run", scene, "--out", folder, "--level", level, "--fresh"]
        command += ["--accuracy", accuracy, "--quiet", "--no-pictures"]
        print(f"measuring solidwhirl, {level}, {accuracy}", flush=True)
        run(command)  # compiles kernels that are not there yet
        done = measured(command, folder / "results.json", REPEATS)
        campbell, body = done["campbell"], done["bodies"]["rotor"]
        found[accuracy] = {
            **{k: done[k] for k in ("cpu_s", "cpu_all_s", "peak_gib")},
            "speed_rpm": campbell["speed_rpm"],
            "frequency_hz": [
                sorted(f for f in column if f is not None)  # a branch may begin at speed
                for column in zip(*campbell["frequency_hz"], strict=True)
            ],
            "unknowns": body["full_dofs"],
            "free_hz": body["free_frequencies_hz"],
        }
    return found


def ours(task: str, mesh: dict, *more: str) -> dict:
    """A task of peers_ours.py on a mesh."""
    written = OUT / f"ours_{task}.json"
    pickled = OUT / f"{mesh['stem']}.pickle"
    print(f"measuring solidwhirl, {task} {' '.join(more)}, {mesh['unknowns']} unknowns", flush=True)
    command = [PYTHON, BENCH / "peers_ours.py", task, written, pickled, *more]
    return measured(command, written)


def ours_solid(meshes: dict) -> dict:
    """Sectors of CalculiX's meshes, reduced bodies of Exudyn's."""
    smallest = meshes["graded"]
    ours("solid", smallest, "1")  # compiles kernels that are not there yet
    found = {"one": {}, "all": {}, "reduced": {}}
    for name in ("graded", "graded, finer", "even"):
        found["one"][name] = ours("solid", meshes[name], "1")
        found["all"][name] = ours("solid", meshes[name], "all")
    for name in ("graded, between", "even"):
        six = ours("reduced", meshes[name], "six")
        lateral = ours("reduced", meshes[name], "lateral")
        found["reduced"][name] = {"six": six, "lateral": lateral}
    return found


def main() -> None:
    """Run everything, write JSON, print tables."""
    (OUT / "calculix").mkdir(parents=True, exist_ok=True)
    store = Store(fresh="--fresh" in sys.argv[1:])
    run([PYTHON, BENCH / "peers_mesh.py", OUT])
    meshes = read(OUT / "meshes.json")
    print("measuring the converged figures", flush=True)
    reference = measured(
        [PYTHON, BENCH / "peers_ours.py", "reference", OUT / "reference.json"],
        OUT / "reference.json",
    )
    document = {
        "date": time.strftime("%Y-%m-%d"),
        "machine": machine(),
        "meshes": meshes,
        "reference": reference,
        "calculix": {"version": calculix.program()[1], **calculix_all(store, meshes)},
        "exudyn": exudyn_all(store, meshes),
        "ross": ross_all(store),
    }
    if "--peers-only" not in sys.argv[1:]:
        document["accuracies"] = {level: ours_at(level) for level in ACCURACIES}
        document["solid"] = ours_solid(meshes)
    document["stored_before"] = store.reused
    (OUT / "peers.json").write_text(json.dumps(document, indent=1))
    print(tables(document))


if __name__ == "__main__":
    main()
