"""Section 5 of Müller and Hennings: the geared engine on its casing."""

from __future__ import annotations

from typing import Any

import numpy as np
from paper.rows import Row, markdown, words
from paper.runs import PICTURES, SOURCE

from solidwhirl.analyses.kinds.rotating_campbell import own_branches
from solidwhirl.core.blocks import numbers
from solidwhirl.drawing.bodies import silhouettes
from solidwhirl.pictures.engine import draw_engine

# Peaks of the response that are listed.
_PEAKS = 8
# Peaks nearer than this (relative) are told as one.
_NEAR = 0.05


def engine_sections(runs: dict[str, Any], told: dict[str, list[Row]]) -> list[str]:
    """Sections of the page on the engine."""
    engine = runs["uhbr_engine"]
    found = engine.analysis("rotating_campbell")
    counts = " + ".join(str(n) for n in found["branches"])
    return [
        "## Section 5: the geared engine",
        "Scene `uhbr_engine`: fan, low and high pressure unit on a rigid casing, fan and low "
        "pressure unit geared.",
        "### Figure 7: layout and nodes",
        _layout(engine),
        "**The paper** draws the cross-section of the engine and the nodes of the units. **Ours**: "
        "stages after Table 7; shafts, cones, webs and places of nodes are identified or assumed. "
        "Only the nodes that joints, forces and results need are kept in the engine.",
        "### Figure 11: Campbell diagram in the frames of the units",
        engine.picture("rotating_campbell.png", "Campbell diagram in the frames of the units"),
        f"**The paper** draws the first {found['branches'][0]} branches of the low pressure unit "
        f"and the first {found['branches'][1]} of the others, each over the speed of its unit, in "
        f"its rotating frame. **Ours** draws the lowest {counts} branches that bend and whose "
        "kinetic energy is mostly that of the unit, in colour; all others that a unit takes part "
        "in are faint on paper, and wait in the legend of the [run's own page](../README.md). "
        f"{_order_0(found)} Whether the lines cross where the paper's do can't be told without its "
        "figure's numbers.",
        engine.picture("campbell.png", "The same in the inertial frame"),
        "### Figure 17: run-up of the engine",
        engine.picture("run_up.png", "Speeds and mount force over time"),
        _run_up_text(engine),
        "### Figure 18: response of the interface point",
        engine.picture("run_up_response.png", "Force at the interface per force of the unbalance"),
        engine.picture("run_up_spectrogram.png", "Spectrogram of the mount force"),
        _response_text(engine),
        "### Section 5.8: required complexity",
        engine.picture("complexity_complexity.png", "Response of models of less complexity"),
        _complexity_table(engine),
        _complexity_text(engine),
        "### Appendices B and C",
        "Frames: `solidwhirl.rotordyn.campbell.body_frames`, tested against equations 15 to 17 and "
        "equations of motion in the rotating frame. Stage factors: `solidwhirl.geometry.TABLE_7` "
        "and `stage_group_sections`.",
    ]


def _order_0(found: dict[str, Any]) -> str:
    told = [
        f"{body} {words(numbers(found['bodies'][body]['frequency_hz'])[0, own, 0], '.1f')} Hz"
        for body, (_, own) in own_branches(found["bodies"]).items()
        if own.size
    ]
    return f"Torsion and axial motion are left out: {'; '.join(told)} at rest."


def _layout(engine: Any) -> str:
    """The engine to scale with its nodes."""
    parts = engine.saved.reduced
    scene = parts.job.scene
    bodies = silhouettes(scene, parts.elements, parts.geometry)
    draw_engine(scene, bodies, PICTURES / "figure_7.png", scene.title)
    return "![Layout of the engine and its nodes](paper/figure_7.png)"


def _run_up_text(engine: Any) -> str:
    found, alone = engine.analysis("run_up"), engine.analysis("start_up")
    energy = found["energy"]
    work = max(abs(v) for key, v in energy.items() if key != "largest_error_j")
    return (
        "**The paper** runs the engine up and then holds its speed, without an unbalance in part b "
        f"of the figure. **Ours**: {found['ramp_s']:.0f} s linear, {found['hold_s']:.0f} s "
        f"constant, {found['steps']} steps in {found['wall_time_s']:.0f} s of computing "
        f"({1e6 * found['wall_time_per_step_s']:.0f} µs each). With the unbalances of section 5.8 "
        f"the largest mount force is {found['largest_mount_force_n']:.4g} N; the energy balance "
        f"closes to {energy['largest_error_j']:.1e} J beside {work:.1e} J of work. Without any "
        f"unbalance it is {alone['largest_mount_force_n']:.1e} N, beside the torque that speeds "
        "the shafts up: a linear engine that is the same in all directions passes no lateral "
        "force on then, with whatever modes. The paper does not state where the force of its "
        "Figure 17 b comes from; a mesh that is not quite symmetric would be a small unbalance."
    )


def _response_text(engine: Any) -> str:
    found = engine.analysis("run_up")["normalised_response"]
    high = sorted(found["peaks"], key=lambda p: -p["force_per_force"])[:_PEAKS]
    peaks = sorted(p["frequency_hz"] for p in high)
    top = found["excited_hz"][1]
    printed = SOURCE["figure_18"]["peaks_hz"]
    within = [f for f in printed if f <= top]
    near = sum(np.abs(np.array(peaks) / f - 1.0).min() <= _NEAR for f in within)
    return (
        f"**The paper** finds peaks at {words(printed, 'g')} Hz, and gives no formula for its "
        f"response. **Ours** is the force at the mount over the force of all unbalances at each "
        f"frequency; its {len(peaks)} highest peaks lie at {words(peaks, '.0f')} Hz. "
        f"{len(printed) - len(within)} of the paper's lie above the highest 1/rev frequency, "
        f"{top:.0f} Hz: unbalances can't excite them in a linear model. Of the other "
        f"{len(within)}, {near} have one of ours within {_NEAR:.0%}. The paper withholds the "
        "stiffness of the casing's joints and of the units, which set these peaks."
    )


def _complexity_table(engine: Any) -> str:
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


def _complexity_text(engine: Any) -> str:
    said = SOURCE["section_5_8"]
    found = engine.analysis("complexity")["complexity"]
    errors = {m["name"]: np.array(m["response_error_by_band"]) for m in found["models"]}
    peak = max(abs(m["peak_force_error"]) for m in found["models"])
    bands = [list(band) for band in found["bands_hz"]]
    (low, high), *_ = bands
    listed = ", ".join(f"{name} {errors[name][0]:.1%}" for name in said["with_difference"])
    alone = (*said["with_difference"], said["without"])
    best = [min(alone, key=lambda name: errors[name][k]) for k in range(len(bands))]
    by_band = ", ".join(
        f"{name} from {low:g} to {high:g} Hz ({errors[name][k]:.1%})"
        for k, (name, (low, high)) in enumerate(zip(best, bands, strict=True))
    )
    fair, good = (
        f"{errors[own['model']][bands.index(own['band_hz'])]:.0%}"
        for own in (said["moderate"], said["excellent"])
    )
    return (
        "**The paper** compares the transmitted force: "
        f"{said['difference_percent']} % off with no modes or those of LP or HP alone, while the "
        "fan alone corresponds to the reference. **Ours**, errors by band as root mean square "
        f"differences of the response, on the same comparison from {low:.0f} to {high:.0f} Hz, "
        f"where the fan turns: {listed}, but {said['without']} {errors[said['without']][0]:.1%}. "
        "The paper does not say by what measure, so this is a parallel and not the same number. "
        f"Peak forces differ by {peak:.1%} at most. By spectrum the paper "
        f"finds {said['best']} best, and {said['moderate']['model']} moderate from "
        f"{said['moderate']['band_hz'][0]} to {said['moderate']['band_hz'][1]} Hz and excellent "
        f"above. Ours of one unit alone are best with {by_band}; {said['moderate']['model']} miss "
        f"{fair} and {good} there."
    )
