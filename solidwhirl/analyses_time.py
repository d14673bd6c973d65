"""Run-up of the engine of a scene and the model complexity it requires."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from solidwhirl.analyses_response import RPM, end_of, unbalance_of
from solidwhirl.outcome import Outcome, Write
from solidwhirl.rotordyn import AssembledSystem
from solidwhirl.rotordyn.atomic import replacing
from solidwhirl.rotordyn.complexity import (
    ComplexityComparison,
    compare_complexity,
    rigid_bodies_system,
)
from solidwhirl.rotordyn.force_spectrum import amplitude_spectrum, spectrogram, spectrum_peaks
from solidwhirl.rotordyn.invariants import Invariant, compared
from solidwhirl.rotordyn.pictures_run_up import (
    draw_normalised_responses,
    draw_run_up,
    draw_spectrogram,
)
from solidwhirl.rotordyn.run_up import run_up
from solidwhirl.rotordyn.run_up_record import Divergence, EnergyBalance, RunUp
from solidwhirl.rotordyn.run_up_response import NormalisedResponse, normalised_response
from solidwhirl.rotordyn.speed_profile import ramp_and_hold
from solidwhirl.rotordyn.unbalance_peaks import ResonancePeak, resonance_peaks
from solidwhirl.scene_analyses import RunUpSpec

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


def run_run_up(spec: RunUpSpec, system: AssembledSystem, title: str) -> Outcome:
    """Run-up with the force through the mount, its spectrum, and models of less complexity."""
    profile = ramp_and_hold(spec.to_rpm * RPM, spec.ramp_s, spec.hold_s)
    unbalances = [unbalance_of(u) for u in spec.unbalances]
    every = max(1, round(spec.sampling_hz / spec.record_hz))
    start = time.perf_counter()
    run = run_up(
        system,
        profile,
        unbalances,
        step_s=1.0 / spec.sampling_hz,
        record_every=every,
        outputs=[end_of(place) for place in spec.observe],
        bearings=[spec.mount],
        gravity_m_per_s2=spec.gravity_m_per_s2,
        drives=[end_of(place) for place in spec.drives],
    )
    spent = time.perf_counter() - start
    files: dict[str, Write] = {
        f"{spec.label}.png": lambda path: draw_run_up(run, spec.mount, path, title),
        f"{spec.label}.npz": lambda path: _write_record(run, path),
    }
    document = _document(spec, run, spent)
    if run.stopped is not None:  # spectra of growing motion tell nothing
        return Outcome(
            kind=spec.kind,
            document=document,
            files=files,
            headline=f"DIVERGED at {run.stopped.speed_rad_s / RPM:.6g} rpm after "
            f"{run.stopped.time_s:.4g} s, {run.stopped.amplitude_m:.3g} m; stopped there",
        )
    force = run.bearing_force_n(spec.mount)
    if np.abs(force[0]).max() > 0.0 and _long_enough(spec):
        pieces = spectrogram(run.time_s, force[0], _PIECE_S)
        files[f"{spec.label}_spectrogram.png"] = lambda path: draw_spectrogram(
            pieces, run, path, title, 2.0 * document["fastest_excitation_hz"]
        )
    if unbalances:
        response = normalised_response(run, spec.mount)
        document["normalised_response"] = _response_document(response)
        if np.isfinite(response.ratio).any():
            files[f"{spec.label}_response.png"] = lambda path: draw_normalised_responses(
                {"all modes": response}, path, title
            )
    if spec.compare_flexible:
        compared = _compare(spec, system)
        document["complexity"] = _complexity_document(compared)
        curves = dict(zip(compared.names, compared.responses, strict=True))
        files[f"{spec.label}_complexity.png"] = lambda path: draw_normalised_responses(
            curves, path, title
        )
    return Outcome(
        kind=spec.kind,
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
        "speed_rpm": found.speed_rad_s / RPM,
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
        ramp_and_hold(spec.to_rpm * RPM, spec.ramp_s, spec.hold_s),
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
