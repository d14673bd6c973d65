"""Random machines by number, as rotors, bearings and gears, and their laws as plain numbers.

A machine is the same for a number always, whatever else is drawn. Laws are told twice: as records
of the package for the analyses, and as numbers that `truth_oracle` evaluates by itself.
"""

from __future__ import annotations

import dataclasses
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.assembly.magnetic_laws import MagneticLaw
from solidwhirl.rotordyn.asymmetric import assemble_rotating
from solidwhirl.rotordyn.bearings import controllers as ct
from solidwhirl.rotordyn.bearings.magnetic import MagneticBearing

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "rotordyn"))

LATERAL, EVERY = ("ux", "uy", "rx", "ry"), ("ux", "uy", "rx", "ry", "uz", "rz")
Random, Law = np.random.Generator, dict[str, Any]
CROSS = np.array([[0.0, 1.0], [-1.0, 0.0]])


@dataclass(kw_only=True)
class Machine:
    """Parts of a system; `laws`: numbers of the law of a bearing by its name; `top` [rad/s]."""

    top: float
    rotors: dict[str, rd.Rotor] = field(default_factory=dict)
    bearings: list[rd.Bearing] = field(default_factory=list)
    gears: list[rd.Gear] = field(default_factory=list)
    laws: dict[str, dict[str, Any]] = field(default_factory=dict)
    kinds: set[str] = field(default_factory=set)

    def assembled(self) -> rd.AssembledSystem:
        """The system itself."""
        return rd.assemble(self.rotors, tuple(self.bearings), "r0", tuple(self.gears))

    def rotating(self) -> Any:
        """The system in the frame of a body that bends unlike in two planes."""
        return assemble_rotating(self.rotors, tuple(self.bearings), "r0")

    def hold(self, at: str, second: str | None = None, law: Law | None = None, **own: Any) -> None:
        """Add a bearing, perhaps with a law."""
        first, other = (
            None if e is None else rd.End(body=e[:2], interface=e[3:]) for e in (at, second)
        )
        name = f"j{len(self.bearings)}"
        if law is not None:
            ratio = self.rotors[at[:2]].speed_ratio
            turned = ratio < 0 and any(
                np.any(m != np.swapaxes(m, -1, -2)) for key, m in law.items() if np.ndim(m) > 2
            )
            self.laws[name] = {**law, "ratio": ratio, "mirrored": float(turned)}
            own["speed_law"] = _record(name, law)
        self.bearings.append(rd.Bearing(name=name, first=first, second=other, **own))


# --- systems --------------------------------------------------------------------------------------


def system(number: int) -> Machine:
    """One to three shafts or casings, beams or rigid, on constant bearings or tables."""
    rng = np.random.default_rng([36, 1, number])
    machine = Machine(top=float(10 ** rng.uniform(2.5, 3.5)))
    holding = str(rng.choice(["held", "held", "held", "partly", "free", "coupled", "pinned"]))
    geared = rng.random() < 0.12
    count = 2 if geared else int(rng.choice([1, 1, 1, 2, 2, 3]))
    every = geared or rng.random() < 0.15
    for k in range(count):
        ratio = 1.0 if k == 0 else float(rng.choice([1.0, -1.0, 0.0, 1.7, -0.6]))
        ratio = float(rng.choice([-1.0, 2.5, -1.7])) if geared and k else ratio
        machine.rotors[f"r{k}"] = rd.Rotor(
            element=_body(rng, f"r{k}", EVERY if every else LATERAL, machine, count),
            speed_ratio=ratio,
            internal_damping=_inside(rng, machine),
        )
    ground = [f"r{k}.{p}" for k in range(count) for p in "ab"]
    ground = {"partly": ["r0.a"], "free": [], "coupled": ["r0.a", "r0.b"]}.get(holding, ground)
    for at in ground:
        _support(rng, machine, at, holding == "pinned")
    if (
        count > 1
        and not geared
        and (holding in ("partly", "free", "coupled") or rng.random() < 0.3)
    ):
        for k in range(1, count):
            for place in "ab":
                machine.hold(f"r{k - 1}.{place}", f"r{k}.{place}", **_springs(rng, machine))
            machine.kinds.add("between shafts")
    if geared:
        ends = [rd.End(body=f"r{k}", interface="a") for k in (0, 1)]
        elastic: dict[str, Any] = {"base_radius_first_m": 0.1, "line_of_action_rad": 1.2}
        if rng.random() < 0.6:
            elastic |= {"mesh_stiffness_n_per_m": 1e8, "mesh_damping_n_s_per_m": 100.0}
        ratio = machine.rotors["r1"].speed_ratio
        machine.gears.append(
            rd.Gear(name="g", first=ends[0], second=ends[1], ratio=ratio, **elastic)
        )
        machine.kinds.add("gear")
    machine.kinds |= {holding, f"{count} bodies"}
    return machine


def _body(
    rng: Random, name: str, components: tuple[str, ...], machine: Machine, count: int
) -> rd.Superelement:
    if rng.random() < 0.15:
        mass, length = 10 ** rng.uniform(0.0, 2.0), rng.uniform(0.3, 1.0)
        across = mass * (length * rng.uniform(0.1, 0.5)) ** 2
        inertia = [across, across, across * rng.choice([0.3, 1.0, 1.8])]
        seats = {"a": 0.0, "b": length, "c": 0.5 * length}
        machine.kinds.add("rigid body")
        center = [0.0, 0.0, length * rng.uniform(0.1, 0.9)]
        return rd.rigid_superelement(name, mass, center, inertia, seats, components)
    pieces = (
        int(rng.integers(2, 6)) if count > 1 or rng.random() < 0.85 else int(rng.integers(7, 12))
    )
    return _beam(rng, name, pieces, components)


def _beam(
    rng: Random, name: str, pieces: int, components: tuple[str, ...] = LATERAL
) -> rd.Superelement:
    stations = np.cumsum([0.0, *rng.uniform(0.08, 0.3, pieces)])
    radii = rng.uniform(0.012, 0.05, pieces)
    places = {"a": stations[0], "c": stations[len(stations) // 2], "b": stations[-1]}
    disks = []
    for k, at in enumerate(rng.choice(stations, int(rng.integers(0, 3)), replace=False)):
        mass, radius = rng.uniform(1.0, 30.0), rng.uniform(0.05, 0.2)
        polar = 0.5 * mass * radius**2
        across = polar * rng.choice([0.5, 0.6, 1.2])
        disks.append(
            rd.Disk(
                name=f"d{k}", position_m=at, mass_kg=mass, polar_kg_m2=polar, diametral_kg_m2=across
            )
        )
    bore = float(rng.choice([0.0, 0.0, 0.6])) * radii
    steel = (rng.choice([2.1e11, 1.1e11]), 0.3, 7800.0)
    return rd.beam_superelement(name, stations, radii, bore, steel, places, disks, components)


def _inside(rng: Random, machine: Machine) -> rd.InternalDamping | None:
    if rng.random() > 0.15:
        return None
    machine.kinds.add("internal damping")
    return rd.InternalDamping(
        stiffness_coefficient_s=float(rng.choice([0.0, 1e-6, 1e-5])),
        modal_ratio=float(rng.choice([0.0, 0.01])),
    )


def _sizes(rng: Random) -> tuple[float, float]:
    """Stiffness and damping of a bearing, N/m and N s/m."""
    stiffness = 10 ** rng.uniform(5.0, 8.0)
    share = rng.choice(
        [0.0, 10 ** rng.uniform(-3.5, -0.5), rng.uniform(0.5, 4.0)], p=[0.35, 0.5, 0.15]
    )
    return stiffness, float(share) * stiffness / 500.0


def _springs(rng: Random, machine: Machine) -> dict[str, Any]:
    stiffness, damping = _sizes(rng)
    kind = str(rng.choice(["isotropic", "anisotropic", "cross"]))
    machine.kinds |= {kind, "damped" if damping else "undamped"}
    uneven = np.diag([1.0, rng.uniform(0.2, 1.0)]) if kind != "isotropic" else np.eye(2)
    skew = stiffness * 10 ** rng.uniform(-3.5, -0.3) * CROSS if kind == "cross" else 0.0
    if kind == "cross" and rng.random() < 0.5:
        uneven = np.eye(2)
    own = {"stiffness_n_per_m": stiffness * uneven + skew, "damping_n_s_per_m": damping * uneven}
    if rng.random() < 0.1:
        own["tilt_stiffness_n_m_per_rad"] = 0.01 * stiffness * np.eye(2)
    if rng.random() < 0.1:
        own["cross_coupling"] = "as_given"
    return own


def _support(rng: Random, machine: Machine, at: str, pinned: bool) -> None:
    if pinned and rng.random() < 0.5:
        machine.hold(at, rigid=("ux", "uy"))
        return
    draw = rng.random()
    if draw < 0.75 or not machine.rotors[at[:2]].speed_ratio:
        machine.hold(at, **_springs(rng, machine))
    elif draw < 0.93:
        machine.hold(at, law=_speed_table(rng, machine))
    else:
        stiffness, damping = _sizes(rng)
        factors = {
            f"{part}_{axis}": (
                1.0,
                rng.uniform(-0.4, 0.4) / machine.top,
                rng.uniform(0, 0.4) / machine.top**2,
            )
            for part in ("stiffness", "damping")
            for axis in "xy"
        }
        law = {"kind": "polynomial", "k": stiffness, "c": damping, **factors}
        machine.kinds.add("polynomial")
        own = {"stiffness_n_per_m": stiffness * np.eye(2), "damping_n_s_per_m": damping * np.eye(2)}
        machine.hold(at, law=law, **own)


def _speed_table(rng: Random, machine: Machine) -> Law:
    stiffness, damping = _sizes(rng)
    rows = int(rng.integers(2, 7))
    speeds = np.unique(np.round(rng.uniform(0.0, 1.2 * machine.top, rows), 3))
    if rng.random() < 0.25:
        middle = rng.uniform(0.1, 0.9) * machine.top
        speeds = np.array([0.0, middle * 0.998, middle, middle * 1.002, 1.1 * machine.top])
    if speeds.size < 2:
        speeds = np.array([0.0, machine.top])
    k, c = (_matrices(rng, size, (speeds.size,), 2) for size in (stiffness, damping))
    if damping == 0.0:
        k = 0.5 * (k + k.swapaxes(-1, -2))
    machine.kinds.add("table over speed")
    how = str(rng.choice(["linear", "monotone"]))
    return {"kind": "speed", "speeds": speeds, "k": k, "c": c, "interpolation": how}


def _matrices(
    rng: Random,
    size: float,
    rows: tuple[int, ...],
    d: int,
    spread: float = 0.6,
    uneven: str | None = None,
) -> np.ndarray:
    """Coefficients (*rows, d, d) of a film: alike, uneven or cross-coupled, changing row by row."""
    uneven = str(rng.choice(["alike", "uneven", "cross"])) if uneven is None else uneven
    value = size * np.exp(rng.normal(0.0, spread, (*rows, 1, 1))) * np.eye(d)
    if uneven != "alike":
        value = value * (1.0 + 0.3 * rng.uniform(-1.0, 1.0, (*rows, d, d)))
    if uneven == "cross":
        value[..., :2, :2] += size * rng.uniform(-0.3, 0.3, (*rows, 1, 1)) * CROSS
    if d == 4:
        sides = np.array([1.0, 1.0, 0.05, 0.05])
        value = (
            value + 0.1 * size * rng.normal(size=(*rows, 4, 4)) * (uneven != "alike")
        ) * np.outer(sides, sides)
    return value


# --- laws -----------------------------------------------------------------------------------------


def laws(number: int) -> Machine:
    """A small shaft whose bearings change with the speed, the frequency, or have controllers."""
    rng = np.random.default_rng([36, 2, number])
    kind = ("frequency", "controller", "frequency", "speed", "controller")[number % 5]
    machine = Machine(top=float(10 ** rng.uniform(2.6, 3.3)), kinds={kind})
    ratio = -1.0 if kind != "controller" and rng.random() < 0.1 else 1.0
    if rng.random() < 0.4:
        mass, length = rng.uniform(3.0, 30.0), rng.uniform(0.25, 0.5)
        across = mass * (length * rng.uniform(0.2, 0.5)) ** 2
        seats = {"a": 0.0, "b": length, "c": length * 0.4, "s": 0.08 * length, "t": 0.9 * length}
        center = [0.0, 0.0, length * rng.uniform(0.2, 0.8)]
        inertia = [across, across, across * rng.choice([0.3, 1.0, 1.6])]
        element = rd.rigid_superelement("r0", mass, center, inertia, seats, LATERAL)
    else:
        element = _beam(rng, "r0", 3)
    machine.rotors["r0"] = rd.Rotor(element=element, speed_ratio=1.0)
    if ratio < 0:
        machine.rotors["r1"] = rd.Rotor(element=_beam(rng, "r1", 2), speed_ratio=ratio)
        machine.kinds.add("backward")
        for place in "ab":
            machine.hold(f"r0.{place}", **_springs(rng, machine))
    own = "r1" if ratio < 0 else "r0"
    drawn = {"speed": _speed_table, "frequency": _frequency_table, "controller": _controller}[kind]
    first = drawn(rng, machine)
    for k, place in enumerate("ab"):
        if k and rng.random() < 0.3:
            machine.hold(f"{own}.{place}", **_springs(rng, machine))
            continue
        law = first if k and rng.random() < 0.5 else drawn(rng, machine) if k else first
        sensed = {}
        if kind == "controller" and rng.random() < 0.3 and len(element.interfaces) > 3:
            sensed["sensor"] = rd.End(body=own, interface="st"[k])
            machine.kinds.add("sensor apart")
        machine.hold(f"{own}.{place}", law=law, **sensed)
    return machine


def _frequency_table(rng: Random, machine: Machine) -> Law:
    stiffness, damping = 10 ** rng.uniform(5.3, 7.3), 10 ** rng.uniform(1.3, 3.8)
    d = int(rng.choice([2, 2, 2, 4]))
    knots = int(rng.integers(2, 9))
    frequencies = np.unique(np.round(rng.uniform(0.0, 1.5 * machine.top, knots), 3))
    if frequencies.size < 2 or rng.random() < 0.3:
        frequencies = np.append(0.0, machine.top * np.array([0.3, 0.34, 0.8]))
    if rng.random() < 0.15:
        middle = machine.top * rng.uniform(0.2, 0.8)
        frequencies = np.array(
            [0.0, middle * 0.999, middle * 1.001, middle * 1.004, 2 * machine.top]
        )
    speeds = (
        np.array([0.0, machine.top])
        if rng.random() < 0.4
        else np.sort(rng.uniform(0, 1.1, 3)) * machine.top
    )
    rows, spread = (speeds.size, frequencies.size), float(rng.choice([0.3, 0.8, 1.2]))
    uneven = str(rng.choice(["alike", "uneven", "cross"]))
    k, c = (_matrices(rng, size, rows, d, spread, uneven) for size in (stiffness, damping))
    if rng.random() < 0.4:  # the same at all speeds, but for the frequency
        k, c = k[:1] + 0.0 * k, c[:1] + 0.0 * c
    mass = float(rng.choice([0.0, 0.0, 3.0]))
    m = _matrices(rng, mass, rows, d, 0.2, uneven)
    machine.kinds |= {f"{d} motions", uneven} | ({"added mass"} if mass else set())
    how = str(rng.choice(["linear", "monotone"]))
    return {
        "kind": "frequency",
        "speeds": speeds,
        "frequencies": frequencies,
        "k": k,
        "c": c,
        "m": m,
        "interpolation": how,
    }


def _controller(rng: Random, machine: Machine) -> Law:
    """Two chains, [P, I, D, roll-off] and filters [kind, numbers], or a state space of both."""
    negative = 10 ** rng.uniform(5.0, 6.3)
    law: dict[str, Any] = {"kind": "controller", "ki": 200.0, "ks": negative}
    if rng.random() < 0.15:
        pole = 10 ** rng.uniform(2.5, 3.5)
        a = -pole * (np.eye(2) + 0.2 * rng.normal(size=(2, 2)))
        gain = 1.2 * negative / 200.0
        d = gain * (2.0 * np.eye(2) + 0.3 * CROSS) + 0.1 * gain * rng.normal(size=(2, 2))
        machine.kinds.add("state space")
        return law | {
            "a": a,
            "b": np.eye(2) * pole,
            "c": 0.5 * gain * rng.normal(size=(2, 2)),
            "d": d,
        }
    chain = _chain(rng, negative, machine)
    other = chain if rng.random() < 0.6 else _chain(rng, negative, machine)
    return law | {"x": chain, "y": other}


def _chain(rng: Random, negative: float, machine: Machine) -> Law:
    gain = negative / 200.0 * rng.uniform(1.3, 4.0)
    rate = gain * 10 ** rng.uniform(-3.7, -2.3)
    integral = gain * 10 ** rng.uniform(-1.0, 1.5) if rng.random() < 0.45 else 0.0
    roll_off = 10 ** rng.uniform(3.8, 4.8) if rng.random() < 0.85 else 0.0
    if integral:
        machine.kinds.add("integrates")
    filters = []
    if rng.random() < 0.6:
        filters.append(["low_pass", 10 ** rng.uniform(4.2, 5.0), float(rng.choice([0.0, 0.7]))])
    if rng.random() < 0.3:
        filters.append(["notch", machine.top * rng.uniform(0.3, 2.0), rng.uniform(0.05, 0.4), 0.6])
    if rng.random() < 0.35:
        filters.append(["delay", 10 ** rng.uniform(-5.0, -4.0), 3.0])
        machine.kinds.add("delay")
    if rng.random() < 0.25:  # leads, or leaks so slowly that it all but integrates
        slow = 10 ** rng.uniform(-4.0, 1.0) if rng.random() < 0.5 else machine.top
        filters.append(["lag", slow * rng.uniform(1.5, 4.0), slow])
        machine.kinds.add("pole near zero" if slow < 11.0 else "lead")
    return {"pid": [gain, integral, rate, roll_off], "filters": filters}


def _record(name: str, law: Law) -> Any:
    """The law as a record of the package."""
    if law["kind"] == "speed":
        return rd.TableLaw(
            name=name, speeds_rad_s=law["speeds"], stiffness_n_per_m=law["k"],
            damping_n_s_per_m=law["c"], interpolation=law["interpolation"],
        )  # fmt: skip
    if law["kind"] == "frequency":
        return rd.FrequencyTableLaw(
            name=name, speeds_rad_s=law["speeds"], frequencies_rad_s=law["frequencies"],
            stiffness_n_per_m=law["k"], damping_n_s_per_m=law["c"], mass_kg=law["m"],
            interpolation=law["interpolation"],
        )  # fmt: skip
    if law["kind"] == "polynomial":
        own = {key: law[key] for key in law if key.startswith(("stiffness", "damping"))}
        return rd.PolynomialLaw(name=name, argument_unit="rad/s", argument_range=(0.0, 1e5), **own)
    if "a" in law:
        controller = ct.Controller(**{key: law[key] for key in "abcd"})
    else:
        controller = ct.side_by_side(*(_in_series(law[axis]) for axis in "xy"))
    bearing = MagneticBearing(
        current_stiffness_n_per_a=law["ki"],
        negative_stiffness_n_per_m=law["ks"],
        controller=controller,
    )
    return MagneticLaw(name=name, bearing=bearing)


def _in_series(chain: Law) -> ct.Controller:
    p, i, d, roll_off = chain["pid"]
    made = {
        "low_pass": lambda cut, zeta: ct.low_pass(cut, zeta or None),
        "notch": ct.notch,
        "delay": lambda time, order: ct.delay(time, int(order)),
        "lag": lambda zero, pole: ct.transfer((1.0, zero), (1.0, pole)),
    }
    return ct.series(
        ct.pid(p, i, d, roll_off or None), *(made[k](*own) for k, *own in chain["filters"])
    )


# --- asymmetric -----------------------------------------------------------------------------------


def asymmetric(number: int) -> Any:
    """A periodic system of the tests, or a machine with a beam that is softer in one plane."""
    from flat_rotors import in_its_frame
    from random_asymmetric import random_system

    if number % 2:
        return random_system(number)
    rng = np.random.default_rng([36, 3, number])
    machine = Machine(top=float(10 ** rng.uniform(2.3, 3.0)), kinds={"beam"})
    body = in_its_frame(_beam(rng, "r0", int(rng.integers(2, 5))))
    across = np.array([
        c.component in ("uy", "rx") if c.kind == "interface" else k % 2 == 1
        for k, c in enumerate(body.coordinates)
    ])  # fmt: skip
    stiffness = body.stiffness.copy()
    stiffness[np.ix_(across, across)] *= rng.uniform(0.5, 0.95)
    body = dataclasses.replace(body, stiffness=stiffness)
    machine.rotors["r0"] = rd.Rotor(element=body, speed_ratio=1.0)
    for place in "ab":
        machine.hold(f"r0.{place}", **_springs(rng, machine))
    return machine
