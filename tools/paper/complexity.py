"""Section 5.8 of Müller and Hennings: which units of the engine have to be flexible."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from paper.rows import markdown
from paper.runs import SOURCE, STORE, Run

from solidwhirl.analyses.unbalances import unbalance_of
from solidwhirl.core.stages import silent
from solidwhirl.pipeline.cached_stages import StageCache
from solidwhirl.rotordyn import AssembledSystem, assemble
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM
from solidwhirl.rotordyn.run_up.complexity import compare_complexity, rigid_bodies_system
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
_FAN, _MOUNT = "fan", "mount"
# Steps of a second for the unbalance of the fan, which is slow, and records.
_STEPS_HZ, _RECORDS_HZ = 4000, 2000


def complexity_sections(engine: Run) -> list[str]:
    """Models of less complexity: all unbalances by band, and that of the fan alone."""
    changed = _fan_alone(engine)
    return [
        engine.picture("complexity_complexity.png", "Response of models of less complexity"),
        _complexity_table(engine),
        _complexity_text(engine),
        _fan_table(changed),
        _fan_text(changed, engine.analysis("complexity")["complexity"]["bands_hz"][0]),
    ]


def _fan_alone(engine: Run) -> dict[str, dict[str, float]]:
    """Errors of the models by the unbalance of the fan alone, with its bearings changed."""
    stage_cache = StageCache(store=STORE, progress=silent)
    asked = engine.document["scene"]["sha256"], _CHANGES, _STEPS_HZ
    key = stage_cache.key("fan_alone", *asked)
    return stage_cache.stage("models", key, lambda: _compared(engine))


def _compared(engine: Run) -> dict[str, dict[str, float]]:
    (spec,) = (a for a in engine.scene.analyses if a.label == "complexity")
    turning = [n for n, r in engine.saved.system.system.rotors.items() if r.speed_ratio]
    units = [name.removeprefix("modes of ").split(" and ") for name in _names(engine)[2:]]
    found = {}
    for text, (stiffness, damping) in _CHANGES.items():
        system = _with_bearings(engine.saved.system, stiffness, damping)
        kept = dict(zip(_names(engine)[1:], ([], *units), strict=True))
        variants = {"all modes": system} | {
            name: rigid_bodies_system(system, [b for b in turning if b not in own])
            for name, own in kept.items()
        }
        compared = compare_complexity(
            variants,
            ramp_and_hold(spec.to_rpm * RAD_S_PER_RPM, spec.ramp_s, spec.hold_s),
            [unbalance_of(u) for u in spec.unbalances if u.at.startswith(f"{_FAN}.")],
            bearing=_MOUNT,
            step_s=1.0 / _STEPS_HZ,
            bands_hz=spec.bands_hz[:1],
            record_every=_STEPS_HZ // _RECORDS_HZ,
        )
        errors = compared.band_error[:, 0].tolist()
        found[text] = dict(zip(compared.names, errors, strict=True))
    return found


def _names(engine: Run) -> list[str]:
    return [m["name"] for m in engine.analysis("complexity")["complexity"]["models"]]


def _with_bearings(assembled: AssembledSystem, stiffness: float, damping: float) -> AssembledSystem:
    """The engine with the bearings of the fan changed by factors."""
    parts: Any = assembled.system
    changed = [
        replace(
            b,
            stiffness_n_per_m=stiffness * b.stiffness_n_per_m,
            damping_n_s_per_m=damping * b.damping_n_s_per_m,
        )
        if b.first.body == _FAN
        else b
        for b in parts.bearings
    ]
    return assemble(parts.rotors, changed, parts.reference, parts.gears)


def _fan_table(changed: dict[str, dict[str, float]]) -> str:
    names = list(changed["as in the scene"])[1:]
    rows = [(text, *(f"{own[n]:.1%}" for n in names)) for text, own in changed.items()]
    return markdown(("unbalance of the fan alone", *names), rows)


def _fan_text(changed: dict[str, dict[str, float]], band: Sequence[float]) -> str:
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
        f"{max(every):.1%}. Which units matter and the "
        "size of the difference agree, then; the exact value tells nothing, since the paper names "
        "neither measure nor excitation, and Table 5 gives the fan's bearings another stiffness at "
        "speed than its polynomial."
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
