"""Hard cases of assembled systems: spools that turn against each other, and one that stands."""

from __future__ import annotations

import numpy as np
from builders_system import engine, ground, joint, refused, shaft

from solidwhirl.rotordyn import (
    LEE_ANISOTROPIC,
    InternalDamping,
    Rotor,
    assemble,
    critical_speeds,
    modes_at_speed,
)
from solidwhirl.rotordyn.response.unbalance import Unbalance, unbalance_response
from solidwhirl.rotordyn.stability.intervals import stability_chart

SPEEDS = (1.0, 100.0, 1000.0, 3000.0)


def _spools(element, ratios=(1.0, -1.0), coupling=3e7, cx=0.0, outer=4e7):
    """Two equal shafts, each on its own supports, joined by an inter-shaft bearing."""
    bearings = [
        ground(name, at, k, cx=cx) for name, k in (("inner", 4e7), ("outer", outer)) for at in "ab"
    ]
    bearings.append(joint(("inner", "b"), ("outer", "b"), coupling))
    speeds = {"inner": ratios[0], "outer": ratios[1]}
    return engine({"inner": element, "outer": element}, bearings, speeds)


def _mirrored(element) -> float:
    """Difference of forward and backward frequencies of equal spools with opposite speeds."""
    system, worst = _spools(element), 0.0
    for speed in SPEEDS:
        modes = modes_at_speed(system, speed)
        omega = modes.eigenvalues.imag
        forward, backward = omega[::2], omega[1::2]
        if modes.family is not None:
            forward, backward = omega[modes.family == 1], omega[modes.family == -1]
        if forward.size != backward.size:
            return np.inf
        worst = max(worst, float(np.abs(forward / backward - 1.0).max()))
    return worst


def _wrong_resonances(element) -> float:
    """Critical speeds at which a spool excites the other whirl, or not its own.

    With a tenth of the damping the response at a resonance grows tenfold, elsewhere it stays.
    """
    undamped, wrong = _spools(element, outer=9e7), 0
    found = critical_speeds(undamped, 1.0, 3000.0)
    for body, own in (("inner", "forward"), ("outer", "backward")):
        load = Unbalance(body=body, interface="a", moment_kg_m=1e-4)
        for critical in found:
            sizes = []
            for cx in (1e-2, 1e-3):
                system = _spools(element, cx=cx, outer=9e7)
                response = unbalance_response(system, [load], [critical.speed_rad_s])
                sizes.append(np.abs(response.exciters[0].translation_m).max())
            expected = 10.0 if critical.whirl == own else 1.0
            wrong += int(abs(sizes[1] / sizes[0] / expected - 1.0) > 1e-3)
    return float(wrong) if {c.whirl for c in found} == {"forward", "backward"} else np.inf


def _standing_frequencies(element) -> float:
    """Change with Ω of the frequencies of a shaft that stands still beside a turning one."""
    system = _spools(element, (1.0, 0.0), coupling=0.0)
    alone = engine({"r": element}, [ground("r", at, 4e7) for at in "ab"], {"r": 0.0})
    expected = modes_at_speed(alone, 0.0).eigenvalues.imag
    worst = 0.0
    for speed in SPEEDS:
        omega = modes_at_speed(system, speed).eigenvalues.imag
        nearest = np.abs(omega[None] / expected[:, None] - 1.0)
        worst = max(worst, float(np.sort(nearest, axis=1)[:, 0].max()))
    return worst


def _standing_requests() -> float:
    """Requests that make no sense for a shaft that stands still, NOT refused."""
    system = _spools(shaft(), (1.0, 0.0))
    load = Unbalance(body="outer", interface="a", moment_kg_m=1e-4)
    attempts = [
        lambda: unbalance_response(system, [load], SPEEDS),
        lambda: critical_speeds(system, 0.0, 1000.0),
        lambda: critical_speeds(system, np.nan, 1000.0),
        lambda: critical_speeds(system, np.inf, 1000.0),
    ]
    return float(refused(attempts))


def _standing_damping() -> float:
    """Growth of a shaft that stands still with internal damping, over 30 times its frequency."""
    beta = InternalDamping(stiffness_coefficient_s=1e-5)
    rotor = Rotor(element=shaft(), speed_ratio=0.0, internal_damping=beta)
    system = assemble({"r": rotor}, tuple(ground("r", at, 4e7) for at in "ab"))
    chart = stability_chart(system, np.linspace(0.0, 20_000.0, 6))
    drift = np.ptp(chart.log_decrement) / chart.log_decrement[0]
    return float(drift + chart.unstable_count.sum())


def _standing_law() -> float:
    """Change with Ω of a bearing whose law follows the speed of a shaft that stands still."""
    bearing = ground("r", "a", 1e8, cx=1e3, speed_law=LEE_ANISOTROPIC)
    system = engine({"r": shaft()}, [bearing, ground("r", "b", 1e8)], {"r": 0.0})
    at_rest = modes_at_speed(system, 0.0).eigenvalues
    return float(
        max(np.abs(modes_at_speed(system, v).eigenvalues / at_rest - 1.0).max() for v in SPEEDS)
    )
