"""Run-up of the engine: speed linear from rest, then constant, and what it asks of a model."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from solidwhirl.analyses.base import UNBALANCE_TURNS, Analysis, Charts, Engine, Found, Scalars
from solidwhirl.analyses.unbalances import UnbalanceSpec, end_of, unbalance_of
from solidwhirl.analyses.work import EngineSize, Work
from solidwhirl.core.blocks import AnalysisBlock, Table, Text, numbers
from solidwhirl.core.fields import MOST, Finite, Name, NotNegative, Place, Positive
from solidwhirl.core.outcome import Outcome, PageSection
from solidwhirl.core.plain_data import Labels
from solidwhirl.rotordyn import AssembledSystem
from solidwhirl.rotordyn.asymmetric import growth_end, run_up_rotating
from solidwhirl.rotordyn.core.arrays import IntArray
from solidwhirl.rotordyn.core.atomic import replacing
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM, RPM_PER_RAD_S
from solidwhirl.rotordyn.plots import run_up as plots
from solidwhirl.rotordyn.plots.chart import Axis, Bars, Chart, Look, series_look
from solidwhirl.rotordyn.response.unbalance import Unbalance
from solidwhirl.rotordyn.response.unbalance_peaks import ResonancePeak, resonance_peaks
from solidwhirl.rotordyn.run_up.complexity import (
    ComplexityComparison,
    compare_complexity,
    rigid_bodies_system,
)
from solidwhirl.rotordyn.run_up.force_spectrum import (
    Spectrogram,
    amplitude_spectrum,
    spectrogram,
    spectrum_peaks,
)
from solidwhirl.rotordyn.run_up.integration import RunSettings, parts_to_run, run_up
from solidwhirl.rotordyn.run_up.record import Divergence, EnergyBalance, RunUp
from solidwhirl.rotordyn.run_up.response import NormalisedResponse, normalised_response
from solidwhirl.rotordyn.run_up.speed_profile import SpeedProfile, ramp_and_hold
from solidwhirl.rotordyn.superelement.invariants import Invariant, compared

# Forces left over at an instant, over the largest there, and energy over a run.
_BALANCE_LIMIT, _ENERGY_LIMIT = 1e-8, 1e-2
# Length of the pieces of a spectrogram, s, and how many pieces and lines of it are drawn.
_PIECE_S = 0.25
_PIECES, _ROWS = 240, 260
# Spectra of a waterfall.
_SPECTRA = 48
# Records in one of them at least.
_FEWEST = 8
# A peak of the normalised response rises above its surroundings by this factor.
_PROMINENT = 1.5
# Lowest frequency of a peak of the force [Hz].
_LOWEST_HZ = 1.0
_MOST_STEPS = 5e7
# Time of a step in the frame of a body beside one in fixed axes, where parts are stepped apart.
_TOGETHER = 15.0
# Models whose curves can be told apart beside the full one.
_MOST_MODELS = 6
# Numbers of steps must be whole to this.
_WHOLE = 1e-6


class RunUpSpec(Analysis):
    """Run-up of the engine: speed linear from rest, then constant."""

    section = PageSection(
        "run-up",
        "Run-up",
        "Motion in time while the speed rises from rest and then holds.",
        90,
    )
    has_record = True
    turning: ClassVar = {
        "at": UNBALANCE_TURNS,
        "compare_flexible": "bodies at rest stay flexible in all models",
    }
    suffixes = (
        *(".png", ".npz", "_spectrogram.png", "_waterfall.png", "_response.png"),
        "_complexity.png",
    )

    of_bodies = "any"

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
            raise ValueError(
                "compare_flexible needs unbalances: models are compared by the force through the "
                "mount over theirs, and neither weight nor drives have one"
            )
        if self.compare_flexible and not self.bands_hz:
            raise ValueError("compare_flexible needs bands_hz, in which models are compared")
        for low, high in self.bands_hz:
            if high <= low:
                raise ValueError(f"bands_hz has ({low:g}, {high:g}); the second must be higher")
        return self

    def work(self, size: EngineSize) -> Work:
        """Records and spectra of each model; what is stepped is of its parts (`parts_of`)."""
        models = 1 + len(self.compare_flexible)
        held = self.steps / self.sampling_hz * self.record_hz * (3 * len(self.observe) + 10.0)
        steps = _TOGETHER * self.steps if size.kind in ("asymmetric", "periodic") else 0.0
        return Work(steps=steps, results=100.0 * models, values=held)

    @property
    def steps(self) -> float:
        """Steps of time."""
        return (self.ramp_s + self.hold_s) * self.sampling_hz

    def parts_of(
        self, system: AssembledSystem, known: dict[Hashable, RunSettings]
    ) -> Iterator[tuple[AssembledSystem, IntArray]]:
        """Yield the parts that are stepped, each with its model and the coordinates that move.

        `known`: parts of run-ups of this engine that came before; see `parts_to_run`.
        """
        profile, unbalances, step = self._profile, self._unbalances, self._step
        for at in parts_to_run(system, profile, unbalances, known=known, **step, **self._beside):
            yield system, at
        for model in self._models(system).values():
            compared = {**step, "bearings": [self.mount]}
            for at in parts_to_run(model, profile, unbalances, known=known, **compared):
                yield model, at

    @property
    def _profile(self) -> SpeedProfile:
        return ramp_and_hold(self.to_rpm * RAD_S_PER_RPM, self.ramp_s, self.hold_s)

    @property
    def _unbalances(self) -> list[Unbalance]:
        return [unbalance_of(u) for u in self.unbalances]

    @property
    def _step(self) -> dict[str, Any]:
        """How every model is stepped."""
        every = max(1, round(self.sampling_hz / self.record_hz))
        return {"step_s": 1.0 / self.sampling_hz, "record_every": every}

    @property
    def _beside(self) -> dict[str, Any]:
        """What is recorded of the engine, and what acts on it beside the unbalance."""
        return {
            "outputs": [end_of(place) for place in self.observe],
            "bearings": [self.mount],
            "gravity_m_per_s2": self.gravity_m_per_s2,
            "drives": [end_of(place) for place in self.drives],
        }

    def _models(self, system: AssembledSystem) -> dict[str, AssembledSystem]:
        """Models in which only some bodies keep their flexibility, the full one first."""
        if not self.compare_flexible:
            return {}
        turning = [name for name, rotor in system.system.rotors.items() if rotor.speed_ratio != 0]
        variants = {"all modes": system}
        for kept in self.compare_flexible:
            name = "modes of " + " and ".join(kept) if kept else "no modes"
            variants[name] = rigid_bodies_system(system, [b for b in turning if b not in kept])
        return variants

    def run(self, engine: Engine) -> Outcome:
        """Run-up with the force through the mount, its spectrum, and models of less complexity."""
        profile, unbalances = self._profile, self._unbalances
        settings = {**self._step, **self._beside}
        if engine.rotating is None:
            run = run_up(engine.system, profile, unbalances, known=engine.run_ups, **settings)
        else:
            run = run_up_rotating(engine.rotating, profile, unbalances, **settings)
        document = _document(self, run)
        if engine.rotating is not None:
            document["growth_ends"] = _growth_document(run)
        record = {f"{self.label}.npz": partial(_write_record, run, {})}
        if run.stopped is not None:  # spectra of growing motion tell nothing
            return Outcome(
                kind=self.kind,
                document=document,
                files=record,
                headline=f"DIVERGED at {run.stopped.speed_rad_s * RPM_PER_RAD_S:.6g} rpm after "
                f"{run.stopped.time_s:.4g} s, {run.stopped.amplitude_m:.3g} m; stopped there",
            )
        responses: dict[str, NormalisedResponse] = {}
        if unbalances:
            responses["all modes"] = normalised_response(run, self.mount)
            document["normalised_response"] = _response_document(responses["all modes"])
        if self.compare_flexible:
            # models are compared without what acts beside the unbalance
            compared = compare_complexity(
                self._models(engine.system),
                profile,
                unbalances,
                bearing=self.mount,
                bands_hz=self.bands_hz,
                known=engine.run_ups,
                **self._step,
            )
            document["complexity"] = _complexity_document(compared)
            responses |= dict(zip(compared.names, compared.responses, strict=True))
        return Outcome(
            kind=self.kind,
            document=document,
            files={f"{self.label}.npz": partial(_write_record, run, responses)},
            headline=f"largest mount force {document['largest_mount_force_n']:.4g} N, "
            f"{_growth_text(document)}{profile.duration_s:g} s simulated in "
            f"{run.wall_time_s:.1f} s",
        )

    def pictures(self, found: Found) -> Mapping[str, Charts]:
        """Speeds and force over the time, its spectra, and the normalised responses."""
        document = found.document
        pictures: dict[str, Charts] = {"": partial(self._time_charts, found)}
        stopped, moved = document["diverged"], document["largest_mount_force_n"] > 0.0
        if not stopped and moved and self._is_long_enough:
            pictures["_spectrogram"] = lambda: [self._spectrogram(found)]
            pictures["_waterfall"] = lambda: [self._waterfall(found)]
        if "normalised_response" in document:
            pictures["_response"] = lambda: [_normalised(found, 1)]
        if "complexity" in document:
            pictures["_complexity"] = lambda: [_normalised(found)]
        return pictures

    def blocks(self, found: Found) -> Sequence[AnalysisBlock]:
        """Facts, force, motion, spectra, and what simpler models miss."""
        document, record = found.document, found.record
        blocks: list[AnalysisBlock] = [_facts(document)]
        if record["time_s"].size > _FEWEST:
            blocks += self._charts(found)
        if "normalised_response" in document:
            blocks.append(response_peaks(document["normalised_response"]))
        if "complexity" in document:
            compared = document["complexity"]
            blocks += [complexity_chart(compared), _complexity_table(compared)]
        return [*blocks, *(Text(text=note, kind="note") for note in document["notes"])]

    @property
    def _is_long_enough(self) -> bool:
        """Whether a spectrogram has some pieces, and these some records."""
        return self.ramp_s + self.hold_s > 4.0 * _PIECE_S and _PIECE_S * self.record_hz >= _FEWEST

    def _time_charts(self, found: Found) -> list[Chart]:
        """Speeds of all spools, and the force along x and along y."""
        record = found.record
        speeds = plots.speed_chart(
            record["time_s"], record["speed_rad_s"], found.engine.speed_ratios
        )
        both = plots.force_chart(record["time_s"], record["mount_force_n"], self.mount)
        forces = (
            replace(both, parts=[part], y=replace(both.y, label=f"{both.y.label} along {axis}"))
            for axis, part in zip("xy", both.parts, strict=True)
        )
        return [speeds, *forces]

    def _charts(self, found: Found) -> list[Chart]:
        """Force, motion of places, spectrum and spectrogram."""
        document, record = found.document, found.record
        time_s, speed, force = (record[key] for key in ("time_s", "speed_rad_s", "mount_force_n"))
        drawn = [plots.force_chart(time_s, force, self.mount, speed)]
        if len(record["translation_m"]):
            places = [str(place) for place in record["outputs"]]
            drawn.append(plots.motion_chart(time_s, record["translation_m"][:, 0], places, speed))
        if not np.abs(force[0]).max() > 0.0:
            return drawn
        spectrum = amplitude_spectrum(time_s, force[0])
        hertz = spectrum.frequency_hz
        top = min(2.0 * document["fastest_excitation_hz"], float(hertz[-1]))
        inside = (hertz > 0.0) & (hertz <= max(top, hertz[1]))
        peaks = [(p["frequency_hz"], p["amplitude_n"]) for p in document["force_spectrum_peaks"]]
        shown = [peak for peak in peaks if peak[0] <= top]
        drawn.append(plots.spectrum_chart(hertz[inside], spectrum.amplitude[inside], shown))
        if time_s[-1] > 4.0 * _PIECE_S and _PIECE_S / float(time_s[1] - time_s[0]) >= _FEWEST:
            drawn.append(self._spectrogram(found))
        return drawn

    def _spectrogram(self, found: Found) -> Chart:
        record, wanted = found.record, 2.0 * found.document["fastest_excitation_hz"]
        every = spectrogram(record["time_s"], record["mount_force_n"][0], _PIECE_S, overlap=0.9)
        pieces = _fewer(every, wanted, _PIECES, _ROWS)
        top = min(wanted, float(pieces.frequency_hz[-1]))
        times, speeds = record["time_s"], record["speed_rad_s"]
        return plots.spectrogram_chart(pieces, times, speeds, found.engine.speed_ratios, top)

    def _waterfall(self, found: Found) -> Chart:
        """Spectra one behind the other."""
        record, wanted = found.record, 2.0 * found.document["fastest_excitation_hz"]
        every = spectrogram(record["time_s"], record["mount_force_n"][0], _PIECE_S)
        pieces = _fewer(every, wanted, _SPECTRA, every.frequency_hz.size)
        speeds = np.interp(pieces.time_s, record["time_s"], np.abs(record["speed_rad_s"]))
        turns = speeds / (2.0 * np.pi)
        return plots.waterfall_chart(pieces, turns)

    @classmethod
    def record_labels(cls, record: Mapping[str, Any], document: Mapping[str, Any]) -> Labels:
        """Force and moment of the mount and motion of the places over the time."""
        return Labels(
            {
                "mount_force_n": (("axis", "time_s"), record["mount_force_n"]),
                "mount_moment_n_m": (("axis", "time_s"), record["mount_moment_n_m"]),
                "translation_m": (("place", "axis", "time_s"), record["translation_m"]),
            },
            {
                "time_s": ("time_s", record["time_s"]),
                "speed_rpm": ("time_s", record["speed_rad_s"] * RPM_PER_RAD_S),
                "axis": ("axis", ["x", "y", "z"]),
                "place": ("place", np.asarray(record["outputs"], dtype=str)),
            },
            {"mount": document["mount"]},
        )

    @classmethod
    def scalars(cls, document: Mapping[str, Any]) -> Scalars:
        """Yield the largest force."""
        yield f"{document['mount']}.largest_force_n", document["largest_mount_force_n"]


def _growth_document(run: RunUp) -> dict[str, float] | None:
    """When and where the motion of an asymmetric rotor is largest; None: not inside the run."""
    end = growth_end(run)
    return end and {
        "time_s": end.time_s,
        "speed_rpm": end.speed_rad_s * RPM_PER_RAD_S,
        "amplitude_m": end.amplitude_m,
    }


def _growth_text(document: Mapping[str, Any]) -> str:
    end = document.get("growth_ends")
    return f"motion grows until {end['speed_rpm']:.0f} rpm, " if end else ""


def _document(spec: RunUpSpec, run: RunUp) -> dict[str, Any]:
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
        "wall_time_s": run.wall_time_s,
        "wall_time_per_step_s": run.wall_time_s / steps,
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
    if run.balance_error is not None:
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


def _write_record(run: RunUp, responses: Mapping[str, NormalisedResponse], path: Path) -> None:
    """Write the record; normalised responses of all models have the same frequencies."""
    found = list(responses.values())
    with replacing(path) as temporary, temporary.open("wb") as file:
        np.savez_compressed(
            file,
            time_s=run.time_s,
            speed_rad_s=run.speed_rad_s,
            mount_force_n=run.force_n[0],
            mount_moment_n_m=run.moment_n_m[0],
            outputs=np.array([end.label for end in run.outputs]),
            translation_m=run.translation_m,
            response_models=np.array(list(responses), dtype=str),
            response_hz=found[0].frequency_hz if found else np.empty(0),
            response_n_per_n=np.array([r.ratio for r in found]),
        )


def _normalised(found: Found, most: int | None = None) -> Chart:
    """Normalised responses of the first or of all models."""
    names, hertz, ratios = (found.record[f"response_{key}"] for key in ("models", "hz", "n_per_n"))
    return plots.normalised_chart(hertz, dict(zip(names[:most].tolist(), ratios, strict=False)))


def _fewer(found: Spectrogram, top_hz: float, most_pieces: int, most_lines: int) -> Spectrogram:
    """Some of the spectra and lines up to a frequency."""
    rows = np.flatnonzero(found.frequency_hz <= top_hz)
    rows = rows[:: max(1, -(-rows.size // most_lines))]
    columns = np.arange(0, found.time_s.size, max(1, -(-found.time_s.size // most_pieces)))
    return replace(
        found,
        time_s=found.time_s[columns],
        frequency_hz=found.frequency_hz[rows],
        amplitude=found.amplitude[np.ix_(rows, columns)],
    )


def _facts(entry: Mapping[str, Any]) -> Table:
    energy = entry["energy"]
    return Table(
        title="In short",
        head=["quantity", "value"],
        rows=[
            [
                "speed",
                f"0 to {entry['to_rpm']:g} rpm in {entry['ramp_s']:g} s, "
                f"then held for {entry['hold_s']:g} s",
            ],
            [
                f"largest lateral force through {entry['mount']}",
                f"{entry['largest_mount_force_n']:.5g} N",
            ],
            ["fastest excitation", f"{entry['fastest_excitation_hz']:.5g} Hz"],
            ["steps", f"{entry['steps']} of {entry['step_s']:.4g} s"],
            [
                "energy: work of the loads, of the drives, dissipated",
                f"{energy['load_work_j']:.4g} J, {energy['drive_work_j']:.4g} J, "
                f"{energy['dissipated_j']:.4g} J",
            ],
            [
                "largest error of the energy balance",
                f"{energy['largest_error_j']:.2g} J of {energy['largest_j']:.4g} J",
            ],
            ["time of computation", f"{entry['wall_time_s']:.3g} s"],
        ],
    )


def complexity_chart(entry: Mapping[str, Any]) -> Chart:
    """Return errors of simpler models by band of frequency, from `complexity` of a document."""
    bands = [f"{low:g} to {high:g} Hz" for low, high in entry["bands_hz"]]
    bars = [
        Bars(
            values=100.0 * numbers([model["peak_force_error"], *model["response_error_by_band"]]),
            name=model["name"],
            look=Look(series_look(k).color),
        )
        for k, model in enumerate(entry["models"][1:])
    ]
    return Chart(
        name="complexity",
        title="What simpler models miss",
        caption="Difference from the model with all modes: of the largest force, and of the "
        "normalised response by band of frequency." + beyond(entry) + _stopped(entry),
        alt="Bars of the errors of simpler models; the table has the numbers.",
        x=Axis(label="quantity", places=["largest force", *bands]),
        y=Axis(label="difference from all modes", unit="%", digits=".4g"),
        parts=bars,
        height_px=360,
    )


def beyond(found: Mapping[str, Any]) -> str:
    """Return a sentence on the bands that reach beyond what is excited; empty without any."""
    top = found["excited_to_hz"]
    cut = [f"{low:g} to {high:g} Hz" for low, high in found["bands_hz"] if high > top]
    if not cut:
        return ""
    return (
        f" Nothing is excited above {top:.5g} Hz: the {'bands' if len(cut) > 1 else 'band'} "
        f"{', '.join(cut)} {'are' if len(cut) > 1 else 'is'} compared up to there only."
    )


def _stopped(found: Mapping[str, Any]) -> str:
    """A sentence on the models that diverged; empty without any."""
    said = ", ".join(
        f"{m['name']} at {m['speed_rpm']:.6g} rpm, {m['amplitude_m']:.3g} m"
        for m in found.get("diverged", ())
    )
    return f" Diverged, stopped and not compared: {said}." if said else ""


def _complexity_table(found: Mapping[str, Any]) -> Table:
    return Table(
        head=[
            "model",
            "coordinates",
            "largest force [N]",
            "its difference [%]",
            *[f"{low:g} to {high:g} Hz [%]" for low, high in found["bands_hz"]],
            "time [s]",
        ],
        rows=[
            [
                m["name"],
                m["coordinates"],
                m["peak_force_n"],
                _hundredfold(m["peak_force_error"]),
                *[_hundredfold(e) for e in m["response_error_by_band"]],
                f"{m['wall_time_s']:.3g}",
            ]
            for m in found["models"]
        ],
    )


def _hundredfold(value: float | None) -> str | None:
    return None if value is None else f"{100.0 * value:.3g}"


def response_peaks(found: Mapping[str, Any]) -> Table | Text:
    """Return the peaks of the force per excitation force, within what is excited."""
    low, high = found["excited_hz"]
    within = f"from {low:.4g} to {high:.5g} Hz, the frequencies that the unbalance passes through"
    if not found["peaks"]:
        return Text(text=f"Normalised response: no peak {within}.")
    return Table(
        head=["frequency [Hz]", "force per excitation force [N/N]"],
        rows=[[f"{p['frequency_hz']:.5g}", p["force_per_force"]] for p in found["peaks"]],
        folded="Peaks of the normalised response",
        caption=f"Shown {within}: beyond them both spectra are side lobes, and their quotient says "
        "nothing.",
    )
