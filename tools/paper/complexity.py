"""Figure 18 and section 5.8 of Müller and Hennings: what sets the peaks of the mount's force.

How far they move with what the paper withholds, and which units of the engine have to be flexible.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from paper.rows import markdown, words
from paper.runs import SOURCE, STORE, Run, drawn

from solidwhirl.analyses.unbalances import unbalance_of
from solidwhirl.core.stages import silent
from solidwhirl.pipeline.cached_stages import StageCache
from solidwhirl.rotordyn import AssembledSystem, assemble
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM
from solidwhirl.rotordyn.plots import chart as charts
from solidwhirl.rotordyn.plots.run_up import normalised_chart
from solidwhirl.rotordyn.response.unbalance import Unbalance
from solidwhirl.rotordyn.response.unbalance_peaks import resonance_peaks
from solidwhirl.rotordyn.run_up.complexity import (
    ComplexityComparison,
    compare_complexity,
    rigid_bodies_system,
    system_with,
)
from solidwhirl.rotordyn.run_up.response import NormalisedResponse
from solidwhirl.rotordyn.run_up.speed_profile import ramp_and_hold

SAID = SOURCE["section_5_8"]
# Bearings of the fan that are changed for the sensitivity: factors on stiffness and damping.
_CHANGES = {
    "as in the scene": (1.0, 1.0),
    "half the stiffness of A, B": (0.5, 1.0),
    "twice the stiffness of A, B": (2.0, 1.0),
    "half the damping of A, B": (1.0, 0.5),
    "twice the damping of A, B": (1.0, 2.0),
}
_COARSER = "with steps twice as long"
_FAN, _MOUNT = "fan", "mount"
# Steps of a second for the unbalance of the fan, which is slow, and records.
_STEPS_HZ, _RECORDS_HZ = 4000, 2000
# The same for all unbalances, whose fastest turns at 1.32 times the speed of the LP unit.
_ALL_STEPS_HZ = 6000
# What is changed for the peaks: factors on the stiffness of bearings, of units, and whether the
# mount is as stiff across as bearing A in place of rigid.
_WITHHELD = {
    "as in the scene": (1.0, 1.0, False),
    "half the stiffness of all bearings": (0.5, 1.0, False),
    "twice the stiffness of all bearings": (2.0, 1.0, False),
    "half the stiffness of the units": (1.0, 0.5, False),
    "twice the stiffness of the units": (1.0, 2.0, False),
    "mount as stiff as bearing A": (1.0, 1.0, True),
}
# Width over which the response is averaged, Hz, and prominence and number of peaks that are told.
_BAND_HZ, _PROMINENT, _PEAKS = 1.0, 1.5, 8
# Peaks nearer than this (relative) are told as one.
_NEAR = 0.05


def complexity_sections(engine: Run) -> list[str]:
    """Models of less complexity: all unbalances by band, and that of the fan alone."""
    changed = _cached(engine, "fan_alone", _CHANGES, _fan_alone)
    return [
        engine.picture("complexity_complexity.png", "Response of models of less complexity"),
        _complexity_table(engine),
        _complexity_text(engine),
        _fan_table(changed),
        _fan_text(changed, engine.analysis("complexity")["complexity"]["bands_hz"][0]),
    ]


# -- Figure 18 -------------------------------------------------------------------------------------


def peak_sections(engine: Run) -> list[str]:
    """Response at the mount, as computed and with what the paper withholds changed."""
    found = _cached(engine, "withheld", _WITHHELD, _withheld)
    top = engine.analysis("run_up")["normalised_response"]["excited_hz"][1]
    printed = SOURCE["figure_18"]["peaks_hz"]
    within = [f for f in printed if f <= top]
    peaks = {name: _peaks(response) for name, response in found.items()}
    ours, *others = peaks.values()
    near = [f for f in within if np.abs(np.array(ours) / f - 1.0).min() <= _NEAR]
    met = {
        f: [name for name, own in peaks.items() if np.abs(np.array(own) / f - 1.0).min() <= _NEAR]
        for f in within
    }
    moved = [max(min(abs(f / p - 1.0) for f in own) for own in others) for p in ours]
    away = [min(abs(f / p - 1.0) for p in ours) for f in within]
    return [
        _response_picture(found, within),
        markdown(("engine", "peaks [Hz]"), ((n, words(p, ".0f")) for n, p in peaks.items())),
        f"**The paper** finds peaks at {words(printed, 'g')} Hz, and gives no formula for its "
        "response. **Ours** is the force at the mount over the force of all unbalances at each "
        f"frequency, a mean over {_BAND_HZ:g} Hz: peaks are known to ± {0.5 * _BAND_HZ:g} Hz. "
        f"{len(printed) - len(within)} of the paper's lie above the highest 1/rev frequency, "
        f"{top:.0f} Hz: unbalances can't excite them in a linear model. Of the other "
        f"{len(within)}, {len(near)} have one of ours within {_NEAR:.0%}. The paper withholds the "
        "stiffness of the units and of the casing's joints, and that of its bearings at speed can "
        "be read in two ways (Table 5). How much do they decide? In the "
        f"{len(others)} engines with other ones our {len(ours)} peaks move by up to "
        f"{words((100 * m for m in moved), '.0f')} %, and the paper's {len(within)} are "
        f"{words((100 * a for a in away), '.0f')} % from the nearest of ours. "
        + "; ".join(f"{f:g} Hz {_where(names)}" for f, names in met.items())
        + ".",
    ]


def _where(names: Sequence[str]) -> str:
    told = f"is met within {_NEAR:.0%} with {', '.join(names)}"
    return told if names else f"is met within {_NEAR:.0%} by none of them"


def _response_picture(found: dict[str, NormalisedResponse], printed: Sequence[float]) -> str:
    first = next(iter(found.values()))
    chart = normalised_chart(first.frequency_hz, {name: r.ratio for name, r in found.items()})
    rules = [charts.Rule(at=f, name="the paper's peaks") for f in printed]
    chart = replace(chart, parts=[*chart.parts, *rules])
    text = "Force at the mount per force of the unbalances"
    return drawn([chart], "figure_18.png", "Figure 18", text)


def _peaks(response: NormalisedResponse) -> list[float]:
    """Highest peaks of a response, Hz."""
    known = np.isfinite(response.ratio)
    at, ratio = 2.0 * np.pi * response.frequency_hz[known], response.ratio[known]
    found = sorted(resonance_peaks(at, ratio, _PROMINENT), key=lambda p: -p.amplitude)
    return sorted(p.position_rad_s / (2.0 * np.pi) for p in found[:_PEAKS])


def _withheld(engine: Run) -> dict[str, NormalisedResponse]:
    """Responses of engines with other stiffnesses."""
    (spec,) = (a for a in engine.scene.analyses if a.label == "run_up")
    variants = {
        text: _with_stiffness(engine.saved.system, *change) for text, change in _WITHHELD.items()
    }
    compared = _compared(engine, variants, [unbalance_of(u) for u in spec.unbalances])
    return dict(zip(compared.names, compared.responses, strict=True))


def _with_stiffness(
    assembled: AssembledSystem, bearings: float, units: float, sprung: bool
) -> AssembledSystem:
    """The engine with other bearings, units and mount."""
    rotors = assembled.system.rotors
    softer = {
        name: replace(rotor.element, stiffness=units * rotor.element.stiffness)
        for name, rotor in rotors.items()
        if rotor.speed_ratio
    }
    changed = _with_bearings(system_with(assembled, softer), tuple(softer), bearings, 1.0)
    if not sprung:
        return changed
    parts: Any = changed.system
    across = next(b for b in parts.bearings if b.first.body == _FAN).stiffness_n_per_m
    joints = [
        replace(
            b, rigid=tuple(r for r in b.rigid if r not in ("ux", "uy")), stiffness_n_per_m=across
        )
        if b.name == _MOUNT
        else b
        for b in parts.bearings
    ]
    return assemble(parts.rotors, joints, parts.reference, parts.gears)


# -- section 5.8 -----------------------------------------------------------------------------------


def _cached(engine: Run, name: str, asked: Any, compute: Callable[[Run], Any]) -> Any:
    """What is computed from the engine, kept in a file."""
    stage_cache = StageCache(store=STORE, progress=silent)
    steps = _STEPS_HZ, _ALL_STEPS_HZ
    key = stage_cache.key(name, engine.document["scene"]["sha256"], asked, steps)
    return stage_cache.stage("models", key, lambda: compute(engine))


def _models(engine: Run, system: AssembledSystem) -> dict[str, AssembledSystem]:
    """All models of an engine: with all modes, and with those of some units."""
    turning = [n for n, r in system.system.rotors.items() if r.speed_ratio]
    units = [name.removeprefix("modes of ").split(" and ") for name in _names(engine)[2:]]
    kept = dict(zip(_names(engine)[1:], ([], *units), strict=True))
    return {"all modes": system} | {
        name: rigid_bodies_system(system, [b for b in turning if b not in own])
        for name, own in kept.items()
    }


def _compared(
    engine: Run,
    variants: dict[str, AssembledSystem],
    unbalances: Sequence[Unbalance],
    steps_hz: int = _ALL_STEPS_HZ,
) -> ComplexityComparison:
    """Run up models, the first of which the others are measured by."""
    (spec,) = (a for a in engine.scene.analyses if a.label == "complexity")
    return compare_complexity(
        variants,
        ramp_and_hold(spec.to_rpm * RAD_S_PER_RPM, spec.ramp_s, spec.hold_s),
        unbalances,
        bearing=_MOUNT,
        step_s=1.0 / steps_hz,
        bands_hz=spec.bands_hz,
        record_every=steps_hz // _RECORDS_HZ,
        band_hz=_BAND_HZ,
    )


def _fan_alone(engine: Run) -> dict[str, dict[str, float]]:
    """Errors of the models by the unbalance of the fan alone, with its bearings changed.

    The last row is the first one with half the steps of a second.
    """
    (spec,) = (a for a in engine.scene.analyses if a.label == "complexity")
    own = [unbalance_of(u) for u in spec.unbalances if u.at.startswith(f"{_FAN}.")]
    found = {}
    runs = {text: (change, _STEPS_HZ) for text, change in _CHANGES.items()}
    runs[_COARSER] = (_CHANGES["as in the scene"], _STEPS_HZ // 2)
    for text, (change, steps_hz) in runs.items():
        system = _with_bearings(engine.saved.system, (_FAN,), *change)
        compared = _compared(engine, _models(engine, system), own, steps_hz)
        errors = compared.band_error[:, 0].tolist()
        found[text] = dict(zip(compared.names, errors, strict=True))
    return found


def _names(engine: Run) -> list[str]:
    return [m["name"] for m in engine.analysis("complexity")["complexity"]["models"]]


def _with_bearings(
    assembled: AssembledSystem, bodies: Sequence[str], stiffness: float, damping: float
) -> AssembledSystem:
    """The engine with the bearings of some bodies changed by factors."""
    parts: Any = assembled.system
    changed = [
        replace(
            b,
            stiffness_n_per_m=stiffness * b.stiffness_n_per_m,
            damping_n_s_per_m=damping * b.damping_n_s_per_m,
        )
        if b.first.body in bodies
        else b
        for b in parts.bearings
    ]
    return assemble(parts.rotors, changed, parts.reference, parts.gears)


def _fan_table(changed: dict[str, dict[str, float]]) -> str:
    names = list(changed["as in the scene"])[1:]
    rows = [
        (text, *(f"{own[n]:.1%}" for n in names))
        for text, own in changed.items()
        if text != _COARSER
    ]
    return markdown(("unbalance of the fan alone", *names), rows)


def _fan_text(changed: dict[str, dict[str, float]], band: Sequence[float]) -> str:
    first, coarser = changed["as in the scene"], changed[_COARSER]
    step = max(abs(coarser[name] - error) for name, error in first.items())
    ours, *others = ([own[name] for name in SAID["with_difference"]] for own in changed.values())
    every = [error for own in others for error in own]
    alone = max(own[SAID["without"]] for own in changed.values())
    low, high = band
    return (
        "**The paper's own comparison** is by the force of its Figure 17 b, before it places "
        f"unbalances: {SAID['difference_percent']} % in the amplitude for each of "
        f"{', '.join(SAID['with_difference'])}, none for {SAID['without']}. **Ours**, by the "
        f"unbalance of the fan alone and from {low:g} to {high:g} Hz: {min(ours):.1%} to "
        f"{max(ours):.1%} for these, {alone:.1%} at most for {SAID['without']}, with the bearings "
        "of the scene and with changed ones. The number is one of the fan's bearings: by "
        f"half and twice their stiffness and damping it goes from {min(every):.1%} to "
        f"{max(every):.1%}. Steps twice as long move it by {100 * step:.1g} points at most. Which "
        "units matter and the size of the difference agree, then; the exact value tells nothing, "
        "since the paper names neither measure nor excitation, and Table 5 gives the fan's "
        "bearings another stiffness at speed than its polynomial."
    )


def _complexity_table(engine: Run) -> str:
    found = engine.analysis("complexity")["complexity"]
    bands = [f"{low:.0f} to {high:.0f} Hz" for low, high in found["bands_hz"]]
    head = ("model", "coordinates", *bands, "peak force [N]", "its error")
    rows = [
        (
            m["name"],
            str(m["coordinates"]),
            *(f"{e:.1%}" for e in m["response_error_by_band"]),
            f"{m['peak_force_n']:.4g}",
            f"{m['peak_force_error']:+.1%}",
        )
        for m in found["models"]
    ]
    return markdown(head, rows)


def _complexity_text(engine: Run) -> str:
    found = engine.analysis("complexity")["complexity"]
    errors = {m["name"]: np.array(m["response_error_by_band"]) for m in found["models"]}
    peak = max(abs(m["peak_force_error"]) for m in found["models"])
    bands = [list(band) for band in found["bands_hz"]]
    (low, high), *_ = bands
    listed = ", ".join(f"{name} {errors[name][0]:.1%}" for name in SAID["with_difference"])
    alone = (*SAID["with_difference"], SAID["without"])
    best = [min(alone, key=lambda name: errors[name][k]) for k in range(len(bands))]
    by_band = ", ".join(
        f"{name} from {low:g} to {high:g} Hz ({errors[name][k]:.1%})"
        for k, (name, (low, high)) in enumerate(zip(best, bands, strict=True))
    )
    fair, good = (
        f"{errors[own['model']][bands.index(own['band_hz'])]:.0%}"
        for own in (SAID["moderate"], SAID["excellent"])
    )
    return (
        "**The paper** compares the transmitted force: "
        f"{SAID['difference_percent']} % off with no modes or those of LP or HP alone, while the "
        "fan alone corresponds to the reference. **Ours**, errors by band as root mean square "
        f"differences of the response, on the same comparison from {low:.0f} to {high:.0f} Hz, "
        f"where the fan turns: {listed}, but {SAID['without']} {errors[SAID['without']][0]:.1%}. "
        "The paper does not say by what measure, so this is a parallel and not the same number. "
        f"Peak forces differ by {peak:.1%} at most. By spectrum the paper "
        f"finds {SAID['best']} best, and {SAID['moderate']['model']} moderate from "
        f"{SAID['moderate']['band_hz'][0]} to {SAID['moderate']['band_hz'][1]} Hz and excellent "
        f"above. Ours of one unit alone are best with {by_band}; {SAID['moderate']['model']} miss "
        f"{fair} and {good} there."
    )
