"""Run-up of the engine: speed linear from rest, then constant, and what it asks of a model."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import (
    Field,
    model_validator,
)

from solidwhirl.analyses.base import (
    Analysis,
    Engine,
)
from solidwhirl.analyses.unbalances import (
    UnbalanceSpec,
    end_of,
    unbalance_of,
)
from solidwhirl.core.fields import (
    MOST,
    Finite,
    Name,
    NotNegative,
    Place,
    Positive,
)
from solidwhirl.core.outcome import Outcome, Write
from solidwhirl.rotordyn import AssembledSystem
from solidwhirl.rotordyn.core.atomic import replacing
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM, RPM_PER_RAD_S
from solidwhirl.rotordyn.plots.run_up import (
    draw_normalised_responses,
    draw_run_up,
    draw_spectrogram,
)
from solidwhirl.rotordyn.response.unbalance_peaks import ResonancePeak, resonance_peaks
from solidwhirl.rotordyn.run_up.complexity import (
    ComplexityComparison,
    compare_complexity,
    rigid_bodies_system,
)
from solidwhirl.rotordyn.run_up.force_spectrum import (
    amplitude_spectrum,
    spectrogram,
    spectrum_peaks,
)
from solidwhirl.rotordyn.run_up.integration import run_up
from solidwhirl.rotordyn.run_up.record import Divergence, EnergyBalance, RunUp
from solidwhirl.rotordyn.run_up.response import NormalisedResponse, normalised_response
from solidwhirl.rotordyn.run_up.speed_profile import ramp_and_hold
from solidwhirl.rotordyn.superelement.invariants import Invariant, compared

# Forces left over at an instant, over the largest there, and energy over a run.
_BALANCE_LIMIT, _ENERGY_LIMIT = 1e-8, 1e-2
# Length of the pieces of a spectrogram, s.
_PIECE_S = 0.25
# Records in one of them at least.
_FEWEST = 8
# A peak of the normalised response rises above its surroundings by this factor.
_PROMINENT = 1.5
# Lowest frequency of a peak of the force [Hz].
_LOWEST_HZ = 1.0
_MOST_STEPS = 5e7
# Models whose curves can be told apart beside the full one.
_MOST_MODELS = 6
# Numbers of steps must be whole to this.
_WHOLE = 1e-6


class RunUpSpec(Analysis):
    """Run-up of the engine: speed linear from rest, then constant."""

    kind: Literal["run_up"]
    ramp_s: Positive
    hold_s: NotNegative = 0.0
    to_rpm: Positive
    sampling_hz: Positive = 20000.0
    record_hz: Positive = 4000.0
    unbalances: Annotated[tuple[UnbalanceSpec, ...], Field(max_length=MOST)] = ()
    gravity_m_per_s2: tuple[Finite, Finite, Finite] | None = None
    drives: Annotated[tuple[Place, ...], Field(max_length=MOST)] = ()
    observe: Annotated[tuple[Place, ...], Field(max_length=MOST)] = ()
    mount: Name
    compare_flexible: Annotated[
        tuple[Annotated[tuple[Name, ...], Field(max_length=MOST)], ...], Field(max_length=MOST)
    ] = ()
    bands_hz: Annotated[tuple[tuple[NotNegative, Positive], ...], Field(max_length=MOST)] = ()

    @model_validator(mode="after")
    def _whole(self) -> RunUpSpec:
        if self.record_hz > self.sampling_hz:
            raise ValueError(
                f"record_hz = {self.record_hz:g} is above sampling_hz = {self.sampling_hz:g}"
            )
        steps = (self.ramp_s + self.hold_s) * self.sampling_hz
        if steps > _MOST_STEPS:
            raise ValueError(
                f"(ramp_s + hold_s) * sampling_hz is {steps:.6g} steps; at most {_MOST_STEPS:g}"
            )
        every = self.sampling_hz / self.record_hz
        if abs(every - round(every)) > _WHOLE * every:
            near = self.sampling_hz / math.floor(every), self.sampling_hz / math.ceil(every)
            raise ValueError(
                f"sampling_hz / record_hz is {every:.9g} and must be whole; the nearest record_hz "
                f"are {near[1]:.9g} and {near[0]:.9g}"
            )
        for key in ("ramp_s", "hold_s"):
            steps = getattr(self, key) * self.sampling_hz
            if abs(steps - round(steps)) > _WHOLE or (key == "ramp_s" and steps < 0.5):
                raise ValueError(
                    f"{key} * sampling_hz is {steps:.12g}; {key} must be a whole number of steps "
                    f"of 1 / sampling_hz = {1.0 / self.sampling_hz:.9g} s"
                )
        return self

    @model_validator(mode="after")
    def _comparable(self) -> RunUpSpec:
        kept = [frozenset(names) for names in self.compare_flexible]
        for k, names in enumerate(kept):
            if names in kept[:k]:
                raise ValueError(
                    f"compare_flexible[{k}] is the same as compare_flexible[{kept.index(names)}]"
                )
            if len(names) < len(self.compare_flexible[k]):
                raise ValueError(f"compare_flexible[{k}] names a body twice")
        if len(kept) > _MOST_MODELS:
            raise ValueError(f"compare_flexible has {len(kept)} models; at most {_MOST_MODELS}")
        if self.compare_flexible and not self.unbalances:
            raise ValueError("compare_flexible needs unbalances, which the responses refer to")
        if self.compare_flexible and not self.bands_hz:
            raise ValueError("compare_flexible needs bands_hz, in which models are compared")
        for low, high in self.bands_hz:
            if high <= low:
                raise ValueError(f"bands_hz has ({low:g}, {high:g}); the second must be higher")
        return self

    def run(self, engine: Engine) -> Outcome:
        """Run-up with the force through the mount, its spectrum, and models of less complexity."""
        profile = ramp_and_hold(self.to_rpm * RAD_S_PER_RPM, self.ramp_s, self.hold_s)
        unbalances = [unbalance_of(u) for u in self.unbalances]
        every = max(1, round(self.sampling_hz / self.record_hz))
        start = time.perf_counter()
        run = run_up(
            engine.system,
            profile,
            unbalances,
            step_s=1.0 / self.sampling_hz,
            record_every=every,
            outputs=[end_of(place) for place in self.observe],
            bearings=[self.mount],
            gravity_m_per_s2=self.gravity_m_per_s2,
            drives=[end_of(place) for place in self.drives],
        )
        spent = time.perf_counter() - start
        files: dict[str, Write] = {
            f"{self.label}.png": lambda path: draw_run_up(run, self.mount, path, engine.title),
            f"{self.label}.npz": lambda path: _write_record(run, path),
        }
        document = _document(self, run, spent)
        if run.stopped is not None:  # spectra of growing motion tell nothing
            return Outcome(
                kind=self.kind,
                document=document,
                files=files,
                headline=f"DIVERGED at {run.stopped.speed_rad_s * RPM_PER_RAD_S:.6g} rpm after "
                f"{run.stopped.time_s:.4g} s, {run.stopped.amplitude_m:.3g} m; stopped there",
            )
        force = run.bearing_force_n(self.mount)
        if np.abs(force[0]).max() > 0.0 and _long_enough(self):
            pieces = spectrogram(run.time_s, force[0], _PIECE_S)
            files[f"{self.label}_spectrogram.png"] = lambda path: draw_spectrogram(
                pieces, run, path, engine.title, 2.0 * document["fastest_excitation_hz"]
            )
        if unbalances:
            response = normalised_response(run, self.mount)
            document["normalised_response"] = _response_document(response)
            if np.isfinite(response.ratio).any():
                files[f"{self.label}_response.png"] = lambda path: draw_normalised_responses(
                    {"all modes": response}, path, engine.title
                )
        if self.compare_flexible:
            compared = _compare(self, engine.system)
            document["complexity"] = _complexity_document(compared)
            curves = dict(zip(compared.names, compared.responses, strict=True))
            files[f"{self.label}_complexity.png"] = lambda path: draw_normalised_responses(
                curves, path, engine.title
            )
        return Outcome(
            kind=self.kind,
            document=document,
            files=files,
            headline=f"largest mount force {document['largest_mount_force_n']:.4g} N, "
            f"{profile.duration_s:g} s simulated in {spent:.1f} s",
        )


def _long_enough(spec: RunUpSpec) -> bool:
    """Whether a spectrogram has some pieces, and these some records."""
    return spec.ramp_s + spec.hold_s > 4.0 * _PIECE_S and _PIECE_S * spec.record_hz >= _FEWEST


def _document(spec: RunUpSpec, run: RunUp, spent: float) -> dict[str, Any]:
    force = run.bearing_force_n(spec.mount)
    fastest = max([abs(r) for r in run.speed_ratios.values()] or [1.0]) * spec.to_rpm / 60.0
    peaks: Sequence[ResonancePeak] = ()
    if run.stopped is None:
        spectrum = amplitude_spectrum(run.time_s, force[0])
        peaks = spectrum_peaks(spectrum, _LOWEST_HZ, fastest)
    highest = sorted(peaks, key=lambda p: -p.amplitude)[:12]
    steps = run.profile.duration_s / run.step_s
    return {
        "ramp_s": spec.ramp_s,
        "hold_s": spec.hold_s,
        "to_rpm": spec.to_rpm,
        "step_s": run.step_s,
        "steps": round(steps),
        "steps_per_frozen_speed_at_most": run.longest_block,
        "wall_time_s": spent,
        "wall_time_per_step_s": spent / steps,
        "mount": spec.mount,
        "largest_mount_force_n": float(np.linalg.norm(force[:2], axis=0).max()),
        "fastest_excitation_hz": fastest,
        "force_spectrum_peaks": [
            {"frequency_hz": p.position_rad_s / (2.0 * np.pi), "amplitude_n": p.amplitude}
            for p in sorted(highest, key=lambda p: p.position_rad_s)
        ],
        "energy": {
            "load_work_j": float(run.energy.load_work_j[-1]),
            "drive_work_j": float(run.energy.drive_work_j[-1]),
            "dissipated_j": float(run.energy.dissipated_j[-1]),
            "largest_j": _largest(run.energy),
            "largest_error_j": float(np.abs(run.energy.error_j).max()),
        },
        "diverged": None if run.stopped is None else _divergence_document(run.stopped),
        "notes": list(run.notes),
        "checks": [asdict(check) for check in _run_up_checks(spec, run)],
    }


def _divergence_document(found: Divergence) -> dict[str, float]:
    return {
        "speed_rpm": found.speed_rad_s * RPM_PER_RAD_S,
        "time_s": found.time_s,
        "amplitude_m": found.amplitude_m,
        "limit_m": found.limit_m,
    }


def _run_up_checks(spec: RunUpSpec, run: RunUp) -> Iterator[Invariant]:
    """Forces in balance at the records, and energy over the whole run."""
    concerns = "the run-up"
    name, text = "forces are in balance", "in the system straight from its parts"
    yield compared(name, spec.label, run.balance_error, _BALANCE_LIMIT, concerns, text)
    largest = _largest(run.energy)
    if largest > 0.0 and run.stopped is None:
        error = float(np.abs(run.energy.error_j).max()) / largest
        name = "energy is stored, spent or lost"
        yield compared(name, spec.label, error, _ENERGY_LIMIT, concerns, "by the trapezoidal rule")


def _largest(energy: EnergyBalance) -> float:
    """Largest stored energy or work of a run-up [J]."""
    parts = (energy.stored_j, energy.load_work_j, energy.drive_work_j, energy.dissipated_j)
    return float(max(np.abs(part).max() for part in parts))


def _response_document(response: NormalisedResponse) -> dict[str, Any]:
    known = np.isfinite(response.ratio)
    hertz, ratio = response.frequency_hz[known], response.ratio[known]
    peaks = resonance_peaks(2.0 * np.pi * hertz, ratio, _PROMINENT) if hertz.size >= 3 else ()
    return {
        "excited_hz": list(response.excited_hz),
        "peaks": [
            {"frequency_hz": p.position_rad_s / (2.0 * np.pi), "force_per_force": p.amplitude}
            for p in peaks
        ],
    }


def _compare(spec: RunUpSpec, system: AssembledSystem) -> ComplexityComparison:
    """Run models in which only some bodies keep their flexibility."""
    turning = [name for name, rotor in system.system.rotors.items() if rotor.speed_ratio != 0]
    variants = {"all modes": system}
    for kept in spec.compare_flexible:
        name = "modes of " + " and ".join(kept) if kept else "no modes"
        variants[name] = rigid_bodies_system(system, [b for b in turning if b not in kept])
    return compare_complexity(
        variants,
        ramp_and_hold(spec.to_rpm * RAD_S_PER_RPM, spec.ramp_s, spec.hold_s),
        [unbalance_of(u) for u in spec.unbalances],
        bearing=spec.mount,
        step_s=1.0 / spec.sampling_hz,
        bands_hz=spec.bands_hz,
        record_every=max(1, round(spec.sampling_hz / spec.record_hz)),
    )


def _complexity_document(compared: ComplexityComparison) -> dict[str, Any]:
    _, highest = compared.responses[0].excited_hz
    return {
        "bands_hz": compared.bands_hz.tolist(),
        "excited_to_hz": highest,
        "models": [
            {
                "name": name,
                "coordinates": compared.sizes[k],
                "peak_force_n": compared.peak_force_n[k],
                "peak_force_error": compared.peak_error[k],
                "response_error_by_band": [
                    None if np.isnan(error) else float(error) for error in compared.band_error[k]
                ],
                "wall_time_s": compared.wall_time_s[k],
            }
            for k, name in enumerate(compared.names)
        ],
        "diverged": [
            {"name": name, **_divergence_document(found)}
            for name, found in compared.diverged.items()
        ],
    }


def _write_record(run: RunUp, path: Path) -> None:
    with replacing(path) as temporary, temporary.open("wb") as file:
        np.savez_compressed(
            file,
            time_s=run.time_s,
            speed_rad_s=run.speed_rad_s,
            mount_force_n=run.force_n[0],
            mount_moment_n_m=run.moment_n_m[0],
            outputs=np.array([end.label for end in run.outputs]),
            translation_m=run.translation_m,
        )
