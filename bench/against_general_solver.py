"""Random rotor-bearing systems, run by the program and by an independent solver, compared.

    python bench/against_general_solver.py [--count 2000] [--first 0] [--processes 2] [--keep DIR]

Every number that misses by more than 1e-9 (relative, beyond its own rounding) is a disagreement;
one that no check and no accuracy of the run reports is a defect. Cases are numbered: the same
number is the same system always.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
import warnings
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "verify"))

import general_solver as general

RPM = general.RPM
# Relative disagreement that is a defect, and that of a height between samples (the program's own).
ACCURACY, PEAK_ACCURACY = 1e-9, 2e-3
# Amplification below which a root is no critical speed, with room on both sides.
SURELY, POSSIBLY = 2.6, 2.4


@dataclass(frozen=True, kw_only=True)
class Disagreement:
    """What, where [rpm], the general solver's value and the program's (nan: missing)."""

    kind: str
    rpm: float
    expected: float
    found: float

    def __str__(self) -> str:
        return f"{self.kind} at {self.rpm:.9g} rpm: {self.expected:.12g}, found {self.found:.12g}"


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """One case: its classes, disagreements, what the run reported, and seconds."""

    number: int
    classes: tuple[str, ...]
    disagreements: tuple[Disagreement, ...] = ()
    reported: tuple[str, ...] = ()
    refused: str = ""
    seconds: float = field(default=0.0, compare=False)

    @property
    def is_defect(self) -> bool:
        """Whether something is wrong and nothing says so."""
        return bool(self.refused) or (bool(self.disagreements) and not self.reported)


# --- systems --------------------------------------------------------------------------------------


def system(number: int) -> tuple[dict[str, Any], tuple[str, ...]]:
    """A scene of rigid bodies by its number, and the classes it belongs to."""
    rng = np.random.default_rng([17, number])
    top = float(np.round(10 ** rng.uniform(3.0, 5.0)))
    count = int(rng.choice([1, 1, 1, 2, 2, 3]))
    bodies, ratios = {}, [1.0]
    for k in range(count):
        if k:
            ratios.append(float(rng.choice([1.0, -1.0, 0.0, 1.7, -0.6, 2.5])))
        bodies[f"b{k}"] = _body(rng, ratios[k])
    holding = str(rng.choice(["held", "held", "held", "partly", "free", "coupled"]))
    laws: dict[str, Any] = {}
    kinds: list[str] = []
    bearings = []
    for name, first, second in _joints(rng, bodies, holding):
        bearing, kind = _bearing(rng, bodies, first, second, top, laws, name)
        bearings.append(bearing | {"name": name})
        kinds.append(kind)
    scene: dict[str, Any] = {
        "name": f"random_{number}",
        "rigid_bodies": bodies,
        "bearings": bearings,
        "speeds": {"to_rpm": top, "count": int(rng.integers(3, 20))},
        "campbell": {"branches": 40},
        "model": {"estimates": str(rng.choice(["on", "off", "off"]))},
    }
    if rng.random() < 0.1:
        scene["speeds"]["from_rpm"] = float(np.round(0.5 * top * rng.random(), 1))
    if laws:
        scene["speed_laws"] = laws
    gear = count > 1 and ratios[1] != 0.0 and rng.random() < 0.2
    if gear:
        scene["gears"] = [_gear(rng, ratios[1])]
    unbalances = [
        {"at": f"b{k}.{rng.choice(['a', 'b', 'c'])}", "moment_kg_m": 1e-5, "phase_deg": 30.0 * k}
        for k, ratio in enumerate(ratios)
        if ratio
    ]
    scene["analyses"] = [
        {
            "kind": "stability",
            "name": "stability",
            "to_rpm": top,
            "count": int(rng.choice([7, 31])),
        },
        {
            "kind": "unbalance_response",
            "name": "response",
            "from_rpm": 0.0,
            "to_rpm": top,
            "count": int(rng.choice([11, 51])),
            "unbalances": unbalances,
            "observe": [f"b{k}.{place}" for k in range(count) for place in ("a", "b")],
        },
    ]
    classes = {holding, f"{count} bodies", *kinds}
    classes |= {"backward"} if min(ratios) < 0 else set()
    classes |= {"gear"} if gear else set()
    return scene, tuple(sorted(classes))


def _body(rng, ratio):
    mass, length = 10 ** rng.uniform(-1.0, 2.0), 10 ** rng.uniform(-1.0, 0.3)
    across = mass * (length * rng.uniform(0.1, 0.6)) ** 2
    polar = across * float(rng.choice([0.01, 0.3, 1.0, 1.3, 1.9])) * rng.uniform(0.9, 1.0)
    places = {"a": 0.0, "b": length, "c": 0.5 * length}
    return {
        "speed_ratio": ratio,
        "mass_kg": mass,
        "center_of_gravity_m": [0.0, 0.0, length * rng.uniform(-0.2, 1.2)],
        "inertia_kg_m2": [across, across, polar],
        "interfaces": places,
    }


def _joints(rng, bodies, holding):
    """Names and ends of the bearings."""
    names = list(bodies)
    ground = {
        "held": [(n, p) for n in names for p in ("a", "b")],
        "partly": [(names[0], "a")],
        "free": [],
        "coupled": [(names[0], "a"), (names[0], "b")],
    }[holding]
    joints = [(f"{n}.{p}", "ground") for n, p in ground]
    if holding != "held" or rng.random() < 0.3:
        joints += [
            (f"{n}.{p}", f"{m}.{p}")
            for m, n in pairwise(names)
            for p in ("a", "b")[: 2 if holding != "partly" else int(rng.integers(1, 3))]
        ]
    return [(f"j{k}", first, second) for k, (first, second) in enumerate(joints)]


def _bearing(rng, bodies, first, second, top, laws, name):
    """A bearing and what it is: size by the mass and the range of speeds."""
    body = bodies[first.split(".")[0]]
    rate = top * RPM * 10 ** rng.uniform(-1.3, 0.5)
    k = body["mass_kg"] * rate**2
    zeta = float(rng.choice([0.0, 10 ** rng.uniform(-4.0, -0.5), rng.uniform(0.5, 5.0)]))
    zeta = zeta if rng.random() < 0.8 else 0.0
    c = 2.0 * zeta * np.sqrt(k * body["mass_kg"])
    kind = str(
        rng.choice(
            ["isotropic", "anisotropic", "cross", "table", "table", "polynomial", "constant table"]
        )
    )
    bearing: dict[str, Any] = {"first": first, "second": second}
    if not body["speed_ratio"] and kind not in ("isotropic", "anisotropic"):
        kind = "cross"
    if rng.random() < 0.15:
        bearing["tilt_stiffness_n_m_per_rad"] = _eye(k * 0.01)
    if rng.random() < 0.1 and second == "ground":
        bearing["torsion_stiffness_n_m_per_rad"] = float(k * 0.01)
    if kind in ("isotropic", "anisotropic", "cross"):
        bearing["stiffness_n_per_m"] = _pair(rng, k, kind)
        bearing["damping_n_s_per_m"] = _pair(rng, c, "isotropic" if kind == "cross" else kind)
    elif kind == "polynomial":
        bearing |= {"stiffness_n_per_m": _eye(k), "damping_n_s_per_m": _eye(c), "speed_law": name}
        laws[name] = _polynomial(rng, top)
    else:
        bearing["speed_law"] = name
        laws[name] = _table(rng, k, c, top, kind)
    return bearing, kind + (" damped" if zeta else "") + (" overdamped" if zeta > 1 else "")


def _eye(value):
    return [[float(value), 0.0], [0.0, float(value)]]


def _pair(rng, size, kind):
    if kind == "isotropic" or size == 0.0:
        return _eye(size)
    if kind == "anisotropic":
        cross = size * float(rng.choice([0.0, 0.1])) * rng.random()
        return [[float(size), cross], [cross, float(size * rng.uniform(0.2, 1.0))]]
    cross = float(size * 10 ** rng.uniform(-4.0, 0.0))
    return [[float(size), cross], [-cross, float(size)]]


def _table(rng, k, c, top, kind):
    """Rows that cluster, lie far above the range, or hold one odd entry."""
    count = int(rng.integers(2, 7))
    rows = np.sort(rng.uniform(0.0, 1.2 * top, count))
    style = str(rng.choice(["even", "clustered", "far", "kink"]))
    if style == "clustered":
        middle = rng.uniform(0.05, 0.9) * top
        rows = np.concatenate(([0.0], middle + top * 1e-3 * np.arange(count), [1.5 * top]))
    elif style == "far":
        rows = np.concatenate((rows, [1e3 * top * rng.uniform(1.0, 10.0)]))
    elif style == "kink":
        middle = rng.uniform(0.1, 0.9) * top
        rows = np.array([0.0, middle * (1 - 1e-3), middle, middle * (1 + 1e-3), 1.1 * top])
    rows = np.unique(np.round(rows, 6))
    if rows.size < 2:
        rows = np.array([0.0, top])
    factors = np.ones(rows.size) if kind == "constant table" else rng.uniform(0.3, 1.5, rows.size)
    stiffness = np.array([_eye(k * f) for f in factors])
    damping = np.array([_eye(c * f) for f in factors])
    if rng.random() < 0.6:  # one odd entry
        at = int(rng.integers(rows.size))
        odd = str(rng.choice(["xx", "cross", "skew", "damping"]))
        if odd == "xx":
            stiffness[at, 0, 0] *= 1.0 + 10 ** rng.uniform(-6.0, 0.0)
        elif odd == "cross":
            stiffness[at, 0, 1] = stiffness[at, 1, 0] = 0.3 * k * rng.random()
        elif odd == "skew":
            stiffness[at, 0, 1] = 0.9 * k * rng.random()
            stiffness[at, 1, 0] = -stiffness[at, 0, 1]
        else:
            damping[at, 1, 1] += 0.1 * k / (top * RPM)
    return {
        "kind": "table",
        "interpolation": str(rng.choice(["linear", "monotone"])),
        "speed_rpm": rows.tolist(),
        "stiffness_n_per_m": stiffness.tolist(),
        "damping_n_s_per_m": damping.tolist(),
    }


def _polynomial(rng, top):
    """Factors of the speed over the top speed, some the same in both planes, some near zero."""
    own = lambda: [  # noqa: E731
        1.0,
        *(float(v / top**k) for k, v in enumerate(rng.uniform(-0.5, 0.5, 2), 1)),
    ]
    touching = [1.0, -2.0 / (0.7 * top), 1.0 / (0.7 * top) ** 2]
    x = touching if rng.random() < 0.2 else own()
    y = x if rng.random() < 0.5 else own()
    return {
        "kind": "polynomial",
        "argument_unit": "rpm",
        "argument_range": [0.0, 2.0 * top],
        "stiffness_x": x,
        "stiffness_y": y,
    }


def _gear(rng, ratio):
    gear = {"name": "g", "first": "b0.c", "second": "b1.c", "ratio": ratio}
    if rng.random() < 0.5:
        gear |= {"mesh_stiffness_n_per_m": 1e6, "base_radius_first_m": 0.1}
    return gear


# --- comparison -----------------------------------------------------------------------------------


def compare(number: int, samples: int = 2000) -> Outcome:
    """Run one case by both and compare; stability by so many samples."""
    scene, classes = system(number)
    begin = time.perf_counter()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            results = _run(scene)
            found, reported = disagreements(scene, results, samples), reports(results)
    except Exception as error:
        text = f"{type(error).__name__}: {error}"
        return Outcome(number=number, classes=classes, refused=text)
    seconds = time.perf_counter() - begin
    return Outcome(
        number=number,
        classes=classes,
        disagreements=tuple(found),
        reported=reported,
        seconds=seconds,
    )


def _run(scene):
    from solidwhirl.pipeline.run import run_scene
    from solidwhirl.scene_reading.reader import parse_scene

    return run_scene(parse_scene(scene))


def reports(results) -> tuple[str, ...]:
    """What the run says of itself: failed checks, accuracy that is not met."""
    return tuple(f"{c.where}: {c.name}" for c in results.checks if c.passed is False)


def disagreements(scene, results, samples=2000) -> list[Disagreement]:
    """Campbell diagram, critical speeds, stability and responses of a run that are not right."""
    system = general.general(scene)
    return [
        *_campbell(system, results.campbell),
        *_critical(system, scene, results, samples // 5),
        *_stability(system, scene, results.analyses["stability"].document, samples),
        *_responses(system, scene, results),
    ]


def _campbell(system, diagram):
    for column, speed in enumerate(diagram.speeds_rad_s):
        found = general.spectrum(system, speed)
        allowed = ACCURACY * np.abs(found.values) + found.rounding
        kept = general.motions(found)
        largest = np.abs(found.values).max(initial=0.0)
        listed = diagram.eigenvalues[:, column]
        listed = listed[np.isfinite(listed)]
        listed = listed[np.abs(listed) > 3.0 * general.ZERO * largest]
        sure = found.values.imag > 3.0 * allowed + 3.0 * general.ZERO * largest
        # nearly equal real roots: rounding makes them a pair, or not
        sure &= kept & (found.values.imag > 1e-5 * np.abs(found.values))
        pairs = np.full(len(found.values), np.nan, dtype=complex)
        if listed.size:
            first, second = general.matched(found.values, listed)
            pairs[first] = listed[second]
            for value in np.delete(listed, second):
                yield _hertz("mode twice or invented", speed, np.nan, value)
        for value, own, limit, expected in zip(found.values, pairs, allowed, sure, strict=True):
            if np.isnan(own):
                if expected:
                    yield _hertz("mode missing", speed, value, np.nan)
            elif abs(own - value) > limit:
                yield _hertz("mode wrong", speed, value, own)


def _hertz(kind, speed, expected, found):
    part = (expected.imag, found.imag) if np.isfinite(expected + found) else (expected, found)
    if np.isfinite(expected + found) and abs(np.diff(part)[0]) < 0.5 * abs(expected - found):
        kind, part = f"{kind} (damping)", (expected.real, found.real)
    expected, found = (float(np.imag(p) if np.iscomplexobj(p) else p) for p in part)
    return Disagreement(
        kind=kind, rpm=speed / RPM, expected=expected / (2 * np.pi), found=found / (2 * np.pi)
    )


def _critical(system, scene, results, samples):
    top = scene["speeds"]["to_rpm"] * RPM
    for ratio in sorted({abs(r) for r in system.ratios.values() if r}):
        expected = general.critical_speeds(system, ratio, top, samples)
        listed = [
            c.critical.speed_rad_s
            for c in results.critical_speeds
            if ratio == abs(system.ratios[c.shafts[0]])
        ]
        for speed, value, rounding in expected:
            factor = abs(value) / (2.0 * abs(value.real)) if value.real else np.inf
            near = min(listed, key=lambda s: abs(s - speed), default=np.nan)
            if abs(near - speed) <= ACCURACY * speed + 10.0 * _slope(
                system, ratio, speed, rounding
            ):
                listed.remove(near)
            elif factor > SURELY or value.real > 0:
                yield Disagreement(
                    kind="critical speed missing",
                    rpm=speed / RPM,
                    expected=speed / RPM,
                    found=near / RPM,
                )
        for speed in listed:  # two within one interval of the scan, or not there
            values = general.spectrum(system, speed)
            misses = np.abs(values.values.imag - ratio * speed)
            at = int(np.argmin(misses))
            if misses[at] > ACCURACY * abs(values.values[at]) + 10.0 * values.rounding[at]:
                yield Disagreement(
                    kind="critical speed invented",
                    rpm=speed / RPM,
                    expected=np.nan,
                    found=speed / RPM,
                )


def _slope(system, ratio, speed, rounding):
    """Error of a critical speed from that of its root."""
    step = 1e-5 * speed
    ends = [general.spectrum(system, s).values for s in (speed - step, speed + step)]
    near = [v[np.argmin(np.abs(v.imag - ratio * speed))] for v in ends]
    slope = abs((near[1].imag - near[0].imag) / (2.0 * step) - ratio)
    return rounding / max(slope, 1e-9)


def _stability(system, scene, document, samples):
    top = scene["analyses"][0]["to_rpm"] * RPM
    expected = general.unstable_intervals(system, top, samples)
    listed = _listed_intervals(document, top)
    tolerance = lambda s: 1e-6 * s + 1e-9 * top  # noqa: E731
    for low, high in expected:
        inside = [
            i for i in listed if i[0] <= high + tolerance(high) and i[1] >= low - tolerance(low)
        ]
        if not inside and high - low > 1e-3 * top:
            yield Disagreement(
                kind="unstable interval missing", rpm=low / RPM, expected=low / RPM, found=np.nan
            )
        elif not inside:
            yield Disagreement(
                kind="narrow unstable interval missing",
                rpm=low / RPM,
                expected=low / RPM,
                found=np.nan,
            )
        for at in (0, 1) if inside and len(listed) == len(expected) else ():
            right = (low, high)[at]
            if at == 1 and high >= top * (1 - 1e-12):
                continue
            found = min((i[at] for i in inside), key=lambda end: abs(end - right))
            if abs(found - right) <= tolerance(right):
                continue
            # between the two ends it must be beyond doubt that something grows, or does not
            middle = 0.5 * (found + right)
            surely, possibly = general.growth(system, middle)
            if surely == possibly:
                yield Disagreement(
                    kind="end of an unstable interval",
                    rpm=right / RPM,
                    expected=right / RPM,
                    found=found / RPM,
                )
    for low, high in listed:
        if not any(
            e[0] <= high + tolerance(high) and e[1] >= low - tolerance(low) for e in expected
        ):
            middle = 0.5 * (low + high)
            if not general.growth(system, middle)[1]:
                yield Disagreement(
                    kind="unstable interval invented",
                    rpm=middle / RPM,
                    expected=np.nan,
                    found=low / RPM,
                )


def _listed_intervals(document, top):
    if "unstable_intervals" in document:
        rows = document["unstable_intervals"]
        return [(r["from_rpm"] * RPM, min(r["to_rpm"] * RPM, top)) for r in rows]
    first = document["threshold"]
    return [] if first is None else [(first["speed_rpm"] * RPM, top)]


def _responses(system, scene, results):
    spec, document = scene["analyses"][1], results.analyses["response"].document
    speeds = np.array(document["speed_rpm"]) * RPM
    expected = general.response(system, spec["unbalances"], speeds)
    critical = np.array([c.critical.speed_rad_s for c in results.critical_speeds])
    knots = system.knots_rad_s
    further = np.union1d(critical, knots)
    further = np.union1d(
        further[(further > 1e-4 * speeds[-1]) & (further <= speeds[-1])],
        np.linspace(0, speeds[-1], 301)[1:],
    )
    beside = general.response(system, spec["unbalances"], further)
    for exciter in document["exciters"]:
        motion, bounds = expected[exciter["frequency_ratio"]]
        for place, found in exciter["places"].items():
            rows = system.seats[place][:2]
            own = motion @ rows.T
            size = np.abs(motion).max(axis=1) * np.abs(rows).max()
            for axis, key in enumerate(("amplitude_x_m", "amplitude_y_m")):
                miss = np.abs(np.abs(own[:, axis]) - np.array(found[key]))
                ratio = miss / np.maximum(size * (ACCURACY + 100.0 * bounds), 1e-300)
                at = int(np.nanargmax(ratio)) if np.isfinite(ratio).any() else 0
                if ratio[at] > 1.0:
                    yield Disagreement(
                        kind="response wrong",
                        rpm=speeds[at] / RPM,
                        expected=float(np.abs(own[at, axis])),
                        found=found[key][at],
                    )
            yield from _peaks(
                beside[exciter["frequency_ratio"]][0] @ rows.T,
                further,
                speeds,
                found,
                exciter,
                float(np.abs(beside[exciter["frequency_ratio"]][0]).max()),
                system,
            )


def _peaks(between, further, speeds, found, exciter, floor, system):
    """A response between the samples far above those beside it."""
    major = general_major(between)
    listed = np.array(found["major_m"])
    if listed.max() <= 1e-12 * floor:
        return
    after = np.clip(np.searchsorted(speeds, further), 1, speeds.size - 1)
    near = np.maximum(listed[after], listed[after - 1])
    wide = np.array([listed[max(0, a - 3) : a + 3].max() for a in after])
    at = int(np.argmax(major / np.maximum(wide, 1e-300)))
    highest = listed.max()
    values = general.spectrum(system, further[at]).values
    value = values[np.argmin(np.abs(values.imag - exciter["frequency_ratio"] * further[at]))]
    if abs(value.real) < 1e-7 * abs(value):
        return  # no height without damping
    if major[at] > 1.5 * wide[at] and major[at] > 1e-3 * highest:
        yield Disagreement(
            kind="response peak missed", rpm=further[at] / RPM, expected=major[at], found=near[at]
        )


def general_major(motion):
    """Major half axes of ellipses of complex ux, uy."""
    forward, backward = motion[:, 0] + 1j * motion[:, 1], motion[:, 0] - 1j * motion[:, 1]
    return 0.5 * (np.abs(forward) + np.abs(backward))


# --- script ---------------------------------------------------------------------------------------


def main() -> int:
    """Run the cases and print counts by class, and the first failing ones."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--keep", type=Path, help="write scenes that fail to this folder as JSON")
    parser.add_argument("--show", type=int, default=40)
    asked = parser.parse_args()
    numbers = range(asked.first, asked.first + asked.count)
    with ProcessPoolExecutor(asked.processes) as pool:
        found = list(pool.map(partial(compare), numbers, chunksize=4))
    print(summary(found, asked.show))
    for one in found if asked.keep else ():
        if one.is_defect:
            asked.keep.mkdir(parents=True, exist_ok=True)
            (asked.keep / f"{one.number}.json").write_text(
                json.dumps(system(one.number)[0], indent=1)
            )
    return int(any(one.is_defect for one in found))


def summary(found: list[Outcome], show: int) -> str:
    """Counts of disagreements by kind, by class of system, and the first cases."""
    silent = [o for o in found if o.is_defect]
    kinds = Counter(k for o in found for k in {d.kind for d in o.disagreements})
    unsaid = Counter(k for o in silent for k in {d.kind for d in o.disagreements})
    refused = Counter(o.refused[:90] for o in found if o.refused)
    total = Counter(c for o in found for c in o.classes)
    classes = Counter(c for o in silent for c in o.classes)
    right = sum(1 for o in found if not o.disagreements and o.reported)
    lines = [
        f"{len(found)} systems, {sum(1 for o in found if o.disagreements)} with a disagreement, "
        f"{len(silent)} in silence or refused; {right} right ones reported as wrong",
        f"{sum(o.seconds for o in found):.0f} s of processor time",
        "",
        f"{'disagreement':40} cases silent",
        *(f"{kind:40} {n:5} {unsaid[kind]:6}" for kind, n in kinds.most_common()),
        *(f"refused: {text} {n}" for text, n in refused.most_common()),
        "",
        f"{'class':40} cases silent",
        *(f"{kind:40} {n:5} {classes[kind]:6}" for kind, n in total.most_common()),
        "",
    ]
    for one in silent[:show]:
        first = one.refused or "; ".join(str(d) for d in one.disagreements[:3])
        lines.append(f"{one.number}: {', '.join(one.classes)}: {first}")
    for one in [o for o in found if not o.disagreements and o.reported][:show]:
        lines.append(f"{one.number}: right, but {'; '.join(one.reported[:2])}")
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
