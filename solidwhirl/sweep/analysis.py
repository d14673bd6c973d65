"""All that pictures of a sweep show, computed from its rows, and the same as plain data."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

import numpy as np

from solidwhirl.core.plain_data import plain_data
from solidwhirl.sweep import bands as band
from solidwhirl.sweep.bands import LEVELS, CampbellBands, Quantiles
from solidwhirl.sweep.design import SweepDesign, SweepPictureError, sweep_designs
from solidwhirl.sweep.margins import MarginMap, margin_maps, parameter_pairs, searched_rpm
from solidwhirl.sweep.records import BatchRow, distinct_warnings
from solidwhirl.sweep.sensitivity import Sensitivity, sensitivity
from solidwhirl.sweep.tracks import CriticalTrack, Quantity, critical_tracks, quantities

SCHEMA = "solidwhirl-sweep-1"


@dataclass(frozen=True, kw_only=True)
class SweepPictureSettings:
    """What a reader of a sweep asks for."""

    # Lowest and highest operating speed of the reference shaft; equal for a single one. Needed for
    # margin maps, unless the rows hold margins.
    operating_rpm: tuple[float, float] | None = None
    # The two parameters of the margin map; None for the most influential ones
    map_parameters: tuple[str, str] | None = None
    # What the cases are; "auto" goes by the method of the sweep, see `sweep_designs`
    design: Literal["auto", "grid", "samples"] = "auto"
    confidence: float = 0.95  # of all confidence limits
    # Labels by parameter or response, with their unit, in the place of those made of the name
    labels: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.operating_rpm is not None:
            low, high = self.operating_rpm
            if not (0.0 < low <= high and math.isfinite(high)):
                raise SweepPictureError(
                    f"operating_rpm is {low} to {high}; allowed is 0 < low <= high, finite"
                )
        if not 0.5 <= self.confidence < 1.0:
            raise SweepPictureError(f"confidence is {self.confidence}; allowed is 0.5 to below 1")
        if self.map_parameters is not None and len(set(self.map_parameters)) != 2:
            raise SweepPictureError(
                f"map_parameters are {self.map_parameters}; two different names are needed"
            )


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class SweepAnalysis:
    """What the cases of one scene say."""

    # design, tracks, quantities, sensitivities: cases, critical speeds, all single numbers, and how
    # the latter depend on the parameters
    design: SweepDesign
    tracks: tuple[CriticalTrack, ...]
    quantities: tuple[Quantity, ...]
    sensitivities: tuple[Sensitivity, ...]
    # bands, critical_quantiles: of a sampled sweep: branches of the Campbell diagram, and speeds of
    # the tracks (levels, tracks) in rpm; None otherwise
    bands: CampbellBands | None
    critical_quantiles: Quantiles | None
    maps: tuple[MarginMap, ...]
    # notes, band_notes: sentences on cases and results that are left out or in doubt; those on the
    # bands apart
    notes: tuple[str, ...]
    band_notes: tuple[str, ...]


def analyse_sweep(
    rows: Sequence[BatchRow], settings: SweepPictureSettings
) -> tuple[SweepAnalysis, ...]:
    """Return what the rows of every scene say that has a sweep.

    Raises SweepPictureError: if rows of one scene have different parameters, or a parameter asked
    for does not vary.
    """
    designs = sweep_designs(rows, settings.design)
    return tuple(_analysis(d, settings) for d in designs if d.parameters and len(d.rows) > 1)


def sweep_document(
    rows: Sequence[BatchRow], *, settings: SweepPictureSettings | None = None
) -> dict[str, Any]:
    """Return the numbers behind the pictures as plain data, schema `solidwhirl-sweep-1`."""
    chosen = settings or SweepPictureSettings()
    return document_of(rows, analyse_sweep(rows, chosen), chosen)


def document_of(
    rows: Sequence[BatchRow], found: Sequence[SweepAnalysis], settings: SweepPictureSettings
) -> dict[str, Any]:
    """Return the document of analyses that are done; absent numbers are null."""
    content = {
        "schema": SCHEMA,
        "cases": dict(Counter(row.status for row in rows)),
        "operating_rpm": settings.operating_rpm,
        "confidence": settings.confidence,
        "quantile_levels": LEVELS,
        "scenes": [_document(a) for a in found],
    }
    plain: dict[str, Any] = plain_data(content)
    return plain


def _analysis(design: SweepDesign, settings: SweepPictureSettings) -> SweepAnalysis:
    tracks = critical_tracks(design)
    numbers = quantities(design, tracks)
    effects = [sensitivity(design, q, settings.confidence) for q in numbers]
    known = tuple(e for e in effects if e is not None)
    bands = band.campbell_bands(design, settings.confidence)
    spread = None
    if design.kind == "samples" and tracks:
        spread = band.quantiles(np.array([t.speed_rpm for t in tracks]).T, settings.confidence)
    pairs = parameter_pairs(design, ranking(known))
    if settings.map_parameters is not None:
        for name in settings.map_parameters:
            design.number(name)
        pairs = (settings.map_parameters,)
    return SweepAnalysis(
        design=design,
        tracks=tracks,
        quantities=numbers,
        sensitivities=known,
        bands=bands,
        critical_quantiles=spread,
        maps=margin_maps(design, tracks, numbers, settings.operating_rpm, pairs),
        notes=_notes(design, tracks, settings),
        band_notes=() if bands is None else _band_notes(bands, settings.confidence),
    )


def ranking(found: Sequence[Sensitivity]) -> list[str]:
    """Return parameters by their largest effect on any result, the strongest first."""
    strength: dict[str, float] = {}
    for item in found:
        for effect in item.one_at_a_time:
            size = (effect.largest - effect.smallest) / (abs(effect.at_baseline) or 1.0)
            strength[effect.parameter] = max(strength.get(effect.parameter, 0.0), size)
        for sampled in item.regressions:
            size = abs(sampled.coefficient)
            strength[sampled.parameter] = max(strength.get(sampled.parameter, 0.0), size)
    return sorted(strength, key=lambda name: -strength[name])


def _notes(
    design: SweepDesign, tracks: Sequence[CriticalTrack], settings: SweepPictureSettings
) -> tuple[str, ...]:
    notes = [
        f"{count} of {len(design.rows) + len(design.left_out)} cases left out: {status}"
        for status, count in Counter(r.status for r in design.left_out).items()
    ]
    if design.missing:
        notes.append(
            f"{design.missing} cases left out: no row yet; those with one are no fair "
            "sample, as the costly ones come first"
        )
    for track in tracks:
        found = np.isfinite(track.speed_rpm)
        if not found.all():
            notes.append(
                f"{track.name}: a resonance in {found.sum()} of {found.size} cases; in others it "
                "is critically damped, or not in their range"
            )
        doubtful = np.flatnonzero(track.doubtful)
        if doubtful.size:
            where = ", ".join(design.rows[k].case for k in doubtful[:3])
            more = f" and {doubtful.size - 3} more" if doubtful.size > 3 else ""
            notes.append(f"{track.name}: matched ambiguously in {where}{more}")
    if settings.operating_rpm is not None:
        short = int((~(searched_rpm(design) > settings.operating_rpm[1])).sum())
        if short:
            notes.append(
                f"no margin is known of {short} cases: diagrams end below the operating speeds"
            )
    return tuple(notes)


def _band_notes(bands: CampbellBands, confidence: float) -> tuple[str, ...]:
    notes = []
    least = band.least_samples(LEVELS[0], confidence)
    if bands.cases < least:
        notes.append(
            f"{bands.cases} samples do not limit the 5 and 95 % quantiles on their outer sides; "
            f"{least} do"
        )
    if bands.other_speeds:
        notes.append(f"{bands.other_speeds} diagrams over other speeds left out of the bands")
    return tuple(notes)


def _document(found: SweepAnalysis) -> dict[str, Any]:
    design, bands = found.design, found.bands
    return {
        "scene": design.scene,
        "design": design.kind,
        "baseline": design.rows[design.baseline].case if design.baseline >= 0 else None,
        "notes": [*found.notes, *found.band_notes],
        "warnings": distinct_warnings(design.every_row),
        "parameters": [
            {
                "name": p.name,
                "choices": p.choices,
                "logarithmic": p.logarithmic,
                "lowest": None if p.choices else design.values[:, k].min(),
                "highest": None if p.choices else design.values[:, k].max(),
            }
            for k, p in enumerate(design.parameters)
        ],
        "cases": [{"case": r.case, "values": dict(r.values)} for r in design.rows],
        "left_out": [
            {"case": r.case, "status": r.status, "message": r.message, "values": dict(r.values)}
            for r in design.left_out
        ],
        "critical_speeds": [_track_document(found, k) for k in range(len(found.tracks))],
        "responses": {
            q.name: q.values
            for q in found.quantities
            if q.name not in {t.name for t in found.tracks}
        },
        "sensitivities": [asdict(s) for s in found.sensitivities],
        "campbell": bands
        and {
            "speed_rpm": bands.speed_rpm,
            "cases": bands.cases,
            "left_out_other_speeds": bands.other_speeds,
            "doubtful_cases_of_branches": bands.doubtful,
            "frequency_hz": _quantiles(bands.frequency_hz),
        },
        # without the interpolated places, which follow from the cases
        "margin_maps": [
            {
                "of": m.title,
                "x": m.x_name,
                "y": m.y_name,
                "least_over": m.least_over,
                "interpolated": bool(m.margin.size),
                "cases": [row.case for row in design.rows],
                "least_margin": m.case_margin,
                "notes": m.notes,
            }
            for m in found.maps
        ],
    }


def _track_document(found: SweepAnalysis, number: int) -> dict[str, Any]:
    track, spread = found.tracks[number], found.critical_quantiles
    keys = ("name", "whirl", "excitation_ratio", "speed_rpm", "frequency_hz", "error_estimate")
    return {
        **{key: getattr(track, key) for key in (*keys, "doubtful")},
        "quantiles_rpm": None if spread is None else _quantiles(spread, (number,)),
    }


def _quantiles(spread: Quantiles, where: tuple[int, ...] = ()) -> dict[str, Any]:
    return {
        "samples": spread.count[where],
        "value": [level[where] for level in spread.value],
        "lower_limit": [level[where] for level in spread.low],
        "upper_limit": [level[where] for level in spread.high],
    }
