"""States of the engine whose fields are recovered: modes, responses, instants, steady spin."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solidwhirl.analyses.base import Analysis, Sweep, number_text
from solidwhirl.analyses.recovery.records import SPIN, RecoveryStateSpec
from solidwhirl.analyses.responses.run_up import RunUpSpec
from solidwhirl.analyses.responses.unbalance_response import UnbalanceResponseSpec
from solidwhirl.analyses.unbalances import end_of, unbalance_of
from solidwhirl.rotordyn import AnalysisError, AssembledSystem, End, modes_at_speed
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM, RPM_PER_RAD_S
from solidwhirl.rotordyn.response.harmonic_response import harmonic_response, independent_loads
from solidwhirl.rotordyn.response.unbalance import (
    ExciterResponse,
    Unbalance,
    resolving_speeds,
    turning_load,
    unbalance_response,
)
from solidwhirl.rotordyn.response.unbalance_peaks import resonance_peaks, summit
from solidwhirl.rotordyn.run_up.integration import run_up
from solidwhirl.rotordyn.run_up.record import MotionState, RunUp
from solidwhirl.rotordyn.run_up.speed_profile import SpeedProfile, ramp_and_hold

# Largest displacement of a mode whose amplitude nobody gave.
_MODE_AMPLITUDE_M = 1e-3


@dataclass(frozen=True, kw_only=True, eq=False)
class EngineState:
    """One state of the engine."""

    #: Name in results and files
    label: str
    #: "mode", "response", "run_up" or "spin"
    source: str
    #: Independent coordinates of the system: complex amplitudes of a vibration, or real ones of an
    #: instant
    motion: NDArray[Any]
    #: Of the reference shaft
    speed_rad_s: float
    #: What else results.json tells of it
    facts: dict[str, Any]
    #: Largest displacement that a mode is scaled to; None: the motion has its own size
    scaled_to_m: float | None = None
    #: Whether its stress may be added to that of the centrifugal load
    has_size: bool = True
    #: Of an instant of a run-up
    time_s: float | None = None

    @property
    def is_spin(self) -> bool:
        """Whether nothing moves but the spin."""
        return self.source == SPIN


def engine_states(
    spec: RecoveryStateSpec, analyses: Mapping[str, Analysis], system: AssembledSystem
) -> Iterator[EngineState]:
    """Yield the states that an entry of a recovery stands for.

    `spec`: the entry. `analyses`: those it may refer to, by name. `system`: the assembled engine.
    Raises AnalysisError: there is no such mode or no peak.
    """
    if spec.mode is not None:
        yield _mode(spec, system)
        return
    if spec.is_spin:
        yield _spin(spec, system)
        return
    found = analyses[spec.response or spec.run_up or ""]
    if isinstance(found, UnbalanceResponseSpec):
        yield from _responses(spec, found, system)
    elif isinstance(found, RunUpSpec):
        yield from _instants(spec, found, system)


def _mode(spec: RecoveryStateSpec, system: AssembledSystem) -> EngineState:
    assert spec.mode is not None and spec.speed_rpm is not None
    modes = modes_at_speed(system, spec.speed_rpm * RAD_S_PER_RPM, spec.mode)
    if modes.frequency_hz.size < spec.mode:
        raise AnalysisError(
            f"state {spec.label!r}: there are {modes.frequency_hz.size} modes at "
            f"{spec.speed_rpm:g} rpm, not {spec.mode}"
        )
    k = spec.mode - 1
    return EngineState(
        label=spec.label,
        source="mode",
        motion=modes.shapes[:, k],
        speed_rad_s=spec.speed_rpm * RAD_S_PER_RPM,
        facts={
            "frequency_hz": float(modes.frequency_hz[k]),
            "log_decrement": float(modes.log_decrement[k]),
        },
        scaled_to_m=spec.amplitude_m or _MODE_AMPLITUDE_M,
        has_size=spec.amplitude_m is not None,
    )


def _spin(spec: RecoveryStateSpec, system: AssembledSystem) -> EngineState:
    """No motion but the spin: the centrifugal load alone."""
    assert spec.speed_rpm is not None
    return EngineState(
        label=spec.label,
        source=SPIN,
        motion=np.zeros(system.size),
        speed_rad_s=spec.speed_rpm * RAD_S_PER_RPM,
        facts={},
    )


def _responses(
    spec: RecoveryStateSpec, found: UnbalanceResponseSpec, system: AssembledSystem
) -> Iterator[EngineState]:
    """One state for each frequency; motions of different frequency have no common phase."""
    unbalances = [unbalance_of(u) for u in found.unbalances]
    if spec.speed_rpm is not None:
        speed = spec.speed_rpm * RAD_S_PER_RPM
    else:
        assert spec.peak is not None
        speed = response_peak(system, unbalances, _speeds(spec, found), end_of(spec.peak))
    exciters = unbalance_response(system, unbalances, [speed]).exciters
    for exciter in exciters:
        own = [u for u in unbalances if u.body in exciter.bodies]
        suffix = "" if len(exciters) == 1 else f"_by_{'_'.join(exciter.bodies)}"
        yield EngineState(
            label=spec.label + suffix,
            source="response",
            motion=response_motion(system, own, exciter.frequency_ratio, speed),
            speed_rad_s=speed,
            facts={
                "excited_by": list(exciter.bodies),
                "frequency_hz": float(exciter.frequency_ratio * speed / (2.0 * np.pi)),
            },
        )


def response_motion(
    system: AssembledSystem, unbalances: list[Unbalance], ratio: float, speed_rad_s: float
) -> NDArray[np.complex128]:
    """Return the coordinates of the steady response to unbalances of one frequency, (n,).

    `system`: the engine. `unbalances`: on bodies of one |speed ratio|. `ratio`: that ratio.
    `speed_rad_s`: of the reference shaft.
    """
    patterns: dict[str, Any] = {}
    for unbalance in unbalances:
        load = turning_load(system, unbalance)
        patterns[unbalance.body] = patterns.get(unbalance.body, 0.0) + load
    omega = ratio * speed_rad_s
    loads = omega**2 * independent_loads(system, patterns)
    solved = harmonic_response(system, speed_rad_s, omega, loads[None, :, None])
    return np.asarray(solved.displacement[0, :, 0])


def response_peak(
    system: AssembledSystem,
    unbalances: list[Unbalance],
    speeds_rad_s: NDArray[np.float64],
    place: End,
) -> float:
    """Return the speed of the highest peak of the response to unbalance at a place.

    `system`, `unbalances`: the engine and what excites it. `speeds_rad_s`: samples, rising; the
    peak is sought between them. `place`: interface. Raises AnalysisError: there is no peak inside.
    """
    speeds_rad_s = resolving_speeds(system, unbalances, speeds_rad_s)
    response = unbalance_response(system, unbalances, speeds_rad_s)

    def height(exciter: ExciterResponse) -> NDArray[np.float64]:
        return np.asarray(exciter.orbits().major_m[:, exciter.nodes.index(place)])

    curves = [height(exciter) for exciter in response.exciters]
    found = [
        (peak.amplitude, peak.position_rad_s, k)
        for k, curve in enumerate(curves)
        for peak in resonance_peaks(speeds_rad_s, curve)
    ]
    if not found:
        low, high = (rate * RPM_PER_RAD_S for rate in speeds_rad_s[[0, -1]])
        raise AnalysisError(
            f"the response at {place.label} has no peak from {low:g} to {high:g} rpm"
        )
    _, position, which = max(found)
    near = int(np.abs(speeds_rad_s - position).argmin())
    low, high = speeds_rad_s[max(near - 1, 0)], speeds_rad_s[min(near + 1, len(speeds_rad_s) - 1)]

    def curve(speed: float) -> float:
        return float(height(unbalance_response(system, unbalances, [speed]).exciters[which])[0])

    return summit(curve, float(low), float(high), system.knots_rad_s)


def _speeds(spec: RecoveryStateSpec, found: Sweep) -> NDArray[np.float64]:
    """Samples of a sweep within the range of a state."""
    speeds = found.speeds_rad_s
    low, high = (v * RAD_S_PER_RPM for v in spec.between_rpm or (0.0, np.inf))
    inside = speeds[(speeds >= low) & (speeds <= high)]
    if len(inside) < 3:
        raise AnalysisError(
            f"state {spec.label!r}: {found.label!r} has {len(inside)} speeds within between_rpm; "
            "3 or more are needed to see a peak"
        )
    return inside


def _instants(
    spec: RecoveryStateSpec, found: RunUpSpec, system: AssembledSystem
) -> Iterator[EngineState]:
    """States at the instants of a run-up; it is run again up to these."""
    profile = ramp_and_hold(found.to_rpm * RAD_S_PER_RPM, found.ramp_s, found.hold_s)
    times = spec.time_s
    if times is None:
        assert spec.peak is not None
        times = (_largest_at(spec, found, system, profile),)
    state: MotionState | None = None
    before = 0.0
    for asked in times:
        # whole steps, so that the break points of the profile are steps
        time = max(round(asked * found.sampling_hz), 1) / found.sampling_hz
        if time > before:
            run = _run(found, system, _piece(profile, before, time), before, profile, state)
            state, before = run.final, time
        assert state is not None
        suffix = "" if len(times) == 1 else f"_{number_text(time)}s"
        yield EngineState(
            label=spec.label + suffix,
            source="run_up",
            motion=state.displacement,
            speed_rad_s=float(profile.speed_rad_s(min(before, profile.duration_s))),
            facts={"time_s": before},
            time_s=before,
        )


def _piece(profile: SpeedProfile, start: float, end: float) -> SpeedProfile:
    """The profile from one time to another, with its own time."""
    end = min(end, profile.duration_s)
    inner = [t for t in profile.times_s.tolist() if start < t < end]
    times = np.array([start, *inner, end])
    return SpeedProfile(times_s=times - start, speeds_rad_s=profile.speed_rad_s(times))


def _run(
    found: RunUpSpec,
    system: AssembledSystem,
    piece: SpeedProfile,
    start: float,
    whole: SpeedProfile,
    state: MotionState | None,
    outputs: tuple[End, ...] = (),
) -> RunUp:
    """Run a piece of a run-up; unbalances go on from the angle that they have reached."""
    angle = float(whole.angle_rad(start))
    unbalances = [
        replace(u, phase_rad=u.phase_rad + system.system.rotors[u.body].speed_ratio * angle)
        for u in (unbalance_of(s) for s in found.unbalances)
    ]
    run = run_up(
        system,
        piece,
        unbalances,
        step_s=1.0 / found.sampling_hz,
        record_every=1,
        outputs=outputs,
        gravity_m_per_s2=found.gravity_m_per_s2,
        drives=[end_of(place) for place in found.drives],
        initial=state,
    )
    if run.stopped is not None:
        raise AnalysisError(
            f"{run.stopped.speed_rad_s * RPM_PER_RAD_S:.6g} rpm: {found.label!r} diverges "
            f"{start + run.stopped.time_s:.4g} s after its begin; ask for earlier instants"
        )
    return run


def _largest_at(
    spec: RecoveryStateSpec, found: RunUpSpec, system: AssembledSystem, profile: SpeedProfile
) -> float:
    """Time at which a place is farthest from the axis."""
    assert spec.peak is not None
    run = _run(found, system, profile, 0.0, profile, None, (end_of(spec.peak),))
    low, high = (v * RAD_S_PER_RPM for v in spec.between_rpm or (0.0, np.inf))
    speed = np.abs(run.speed_rad_s)
    distance = np.hypot(*run.translation_m[0, :2])
    inside = (speed >= low) & (speed <= high) & (run.time_s > 0.0)
    if not distance[inside].any():
        raise AnalysisError(
            f"state {spec.label!r}: {spec.peak} does not move sideways in that part of "
            f"{found.label!r}"
        )
    return float(run.time_s[np.where(inside, distance, -1.0).argmax()])
