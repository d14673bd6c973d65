"""Hard cases of assembled systems: at resonance, at critical speeds, and through them."""

from __future__ import annotations

import numpy as np
from builders_system import engine, ground, hub, reduced_body, refused, shaft

from solidwhirl.rotordyn import End, campbell, critical_speeds
from solidwhirl.rotordyn.response.unbalance import Unbalance, unbalance_response
from solidwhirl.rotordyn.run_up.integration import run_up
from solidwhirl.rotordyn.run_up.speed_profile import ramp_and_hold

MASS, OMEGA = 10.0, 100.0
ECCENTRICITY = 1e-4
TILT = {"tilt_stiffness_n_m_per_rad": 1e5 * np.eye(2)}


def _disk(ratio: float, unlike: float = 1.0):
    """A disk of 10 kg at 100 rad/s with a damping ratio."""
    stiffness, damping = MASS * OMEGA**2, 2.0 * ratio * MASS * OMEGA
    return engine(
        {"disk": hub(MASS)}, [ground("disk", "hub", stiffness, unlike * stiffness, damping, **TILT)]
    )


def _at(body="disk", interface="hub", moment=MASS * ECCENTRICITY):
    return Unbalance(body=body, interface=interface, moment_kg_m=moment)


def _at_samples(element) -> float:
    """Distance of a diagram from ω = Ω at speeds that are critical speeds, and a wrong count."""
    system = engine({"r": element}, [ground("r", "a", 3e7, 5e7), ground("r", "b", 2e7)])
    found = critical_speeds(system, 1.0, 2500.0)
    speeds = np.union1d(np.linspace(0.0, 2500.0, 26), [c.speed_rad_s for c in found])
    diagram = campbell(system, speeds, branch_count=8)
    plain = campbell(system, np.linspace(0.0, 2500.0, 26), branch_count=8)
    if not found or {n.kind for n in diagram.notes} - {n.kind for n in plain.notes}:
        return np.inf
    error = 0.0
    for critical in found:
        omega = diagram.eigenvalues[:, np.searchsorted(speeds, critical.speed_rad_s)].imag
        error = max(error, float(np.abs(omega / critical.speed_rad_s - 1.0).min()))
    return error


def _light_damping(element) -> float:
    """Critical speeds with damping of 1e-9 against those without; infinite for a wrong number.

    The search begins and ends its steps at the critical speeds without damping.
    """
    lists = []
    for damping in (0.0, 1e-3):
        bearings = [ground("r", "a", 3e7, 5e7, damping), ground("r", "b", 2e7, None, damping)]
        found = critical_speeds(engine({"r": element}, bearings), 1.0, 2500.0)
        lists.append(np.array([c.speed_rad_s for c in found]))
    plain, damped = lists
    if plain.size == 0 or plain.size != damped.size:
        return np.inf
    return float(np.abs(damped / plain - 1.0).max())


def _peak_error() -> float:
    """Amplitude at exact resonance against e/2ζ, isotropic and with k_yy twice as large."""
    worst = 0.0
    for ratio in (1e-2, 1e-4, 1e-6):
        for unlike in (1.0, 2.0):
            response = unbalance_response(_disk(ratio, unlike), [_at()], [OMEGA])
            found = response.exciters[0].at_node("disk", "hub")[0, 0]
            worst = max(worst, abs(found / (-1j * ECCENTRICITY / (2.0 * ratio)) - 1.0))
    return float(worst)


def _scaled_peak(element) -> float:
    """Drift of amplitude times damping at a critical speed, damping ratios about 1e-3 to 1e-7."""
    free = engine({"r": element}, [ground("r", at, 2e7) for at in "ab"])
    critical = next(c for c in critical_speeds(free, 1.0, 2500.0) if c.whirl == "forward")
    sizes = []
    for damping in (10.0, 1.0, 0.1, 0.01, 0.001):
        system = engine({"r": element}, [ground("r", at, 2e7, cx=damping) for at in "ab"])
        response = unbalance_response(system, [_at("r", "a", 1e-4)], [critical.speed_rad_s])
        sizes.append(damping * abs(response.exciters[0].at_node("r", "a")[0, 0]))
    return float(np.ptp(sizes) / sizes[1])


def _undamped_peaks() -> float:
    """Points at an undamped resonance, exactly or to rounding, that are NOT refused."""
    attempts = []
    for unlike in (1.0, 2.0):
        for speed in (OMEGA, np.nextafter(OMEGA, 0.0), np.nextafter(OMEGA, 1e9)):
            system = _disk(0.0, unlike)
            attempts.append(lambda s=system, v=speed: unbalance_response(s, [_at()], [50.0, v]))
    for body in (shaft(), reduced_body("harmonic"), reduced_body("solid")):
        load = _at("r", "a", 1e-4)
        sprung = engine({"r": body}, [ground("r", at, 2e7) for at in "ab"])
        critical = next(c for c in critical_speeds(sprung, 1.0, 2500.0) if c.whirl == "forward")
        attempts.append(
            lambda s=sprung, c=critical, u=load: unbalance_response(s, [u], [c.speed_rad_s])
        )
    return float(refused(attempts))


def _beside_the_peak() -> float:
    """Error of the amplitude 1e-3 to 1e-9 beside an undamped resonance, over 1e-13/distance."""
    worst = 0.0
    for distance in (1e-3, 1e-5, 1e-7, 1e-9):
        for sign in (1.0, -1.0):
            speed = OMEGA * (1.0 + sign * distance)
            found = unbalance_response(_disk(0.0), [_at()], [speed]).exciters[0]
            gap = (OMEGA - speed) * (OMEGA + speed)
            expected = ECCENTRICITY * speed**2 / gap
            error = abs(found.at_node("disk", "hub")[0, 0] / expected - 1.0)
            worst = max(worst, error * distance / 1e-13)
    return float(worst)


def _run(system, step_s, body="disk", interface="hub", top=160.0, ramp_s=2.0, **options):
    return run_up(
        system,
        ramp_and_hold(top, ramp_s),
        [_at(body, interface)],
        step_s=step_s,
        outputs=[End(body=body, interface=interface)],
        **options,
    )


def _long_steps() -> float:
    """Run-ups with steps that can not follow the load or the change of the system, NOT refused."""
    system, gyroscopic = _disk(1e-3), engine({"r": shaft()}, [ground("r", at, 2e7) for at in "ab"])
    fast = {"top": 3000.0, "ramp_s": 1e-2, "body": "r", "interface": "a"}
    attempts = [lambda h=h: _run(system, h) for h in (0.00625001, 0.0625, 0.125, 0.25, 1.0, 2.0)]
    attempts += [lambda h=h: _run(system, h) for h in (0.0, -1e-3, np.nan, np.inf, 3e-3)]
    attempts += [lambda h=h: _run(gyroscopic, h, **fast) for h in (1e-3, 5e-4)]
    attempts += [lambda p=p: _run(system, 1e-3, phase_error_rad=p) for p in (0.0, -1.0, np.nan)]
    return float(refused(attempts))


def _longest_steps(system, place, speeds, ramp_s, step_s) -> float:
    """Error of a passage with the longest step allowed, against steps an eighth of it."""
    profile = ramp_and_hold(speeds[1], ramp_s, start_speed_rad_s=speeds[0])
    options = {"outputs": [End(body=place[0], interface=place[1])]}
    load = [_at(*place)]
    coarse = run_up(system, profile, load, step_s=step_s, **options)
    fine = run_up(
        system, profile, load, step_s=step_s / 8, record_every=8, phase_error_rad=1e-5, **options
    )
    path, expected = coarse.translation_m[0], fine.translation_m[0]
    return float(np.abs(path - expected).max() / np.abs(expected).max())


def _disk_passage(unlike: float) -> float:
    """One radian a step through 100 rad/s with damping of 1e-3."""
    system = _disk(1e-3, unlike)
    return _longest_steps(system, ("disk", "hub"), (60.0, 140.0), 4.0, 1.0 / 140.0)


def _reduced_passage(level: str) -> float:
    """As long a step as the gyroscopic change of the frequencies lets pass."""
    body = reduced_body(level)
    system = engine({"r": body}, [ground("r", at, 2e7, cx=300.0) for at in "ab"])
    return _longest_steps(system, ("r", "a"), (600.0, 1400.0), 0.4, 5e-4)
