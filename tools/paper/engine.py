"""Section 5 of Müller and Hennings: the geared engine on its casing."""

from __future__ import annotations

from typing import Any

from paper.complexity import complexity_sections, peak_sections
from paper.rows import Row, words
from paper.runs import PICTURES

from solidwhirl.analyses.kinds.rotating_campbell import own_branches
from solidwhirl.core.blocks import numbers
from solidwhirl.drawing.bodies import silhouettes
from solidwhirl.pictures.engine import draw_engine


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
        "### Figure 17: run-up of the engine",
        engine.picture("run_up.png", "Speeds and mount force over time"),
        _run_up_text(engine),
        "### Figure 18: response of the interface point",
        *peak_sections(engine),
        engine.picture("run_up_spectrogram.png", "Spectrogram of the mount force"),
        "### Section 5.8: required complexity",
        *complexity_sections(engine),
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
        f"constant, {found['steps']} steps. With the unbalances of section 5.8 "
        f"the largest mount force is {found['largest_mount_force_n']:.4g} N; the energy balance "
        f"closes to {energy['largest_error_j']:.1e} J beside {work:.1e} J of work. Without any "
        "unbalance, and without gravity as in the paper, it is "
        f"{alone['largest_mount_force_n']:.1e} N beside the torque that speeds the shafts up: a "
        "linear engine that is the same in all directions passes no lateral force on then, "
        "whichever units bend, so that there is nothing to compare models by. The paper does not "
        "state where the force of its Figure 17 b comes from. A mesh that is not quite symmetric "
        "would be a small unbalance, and section 5.8 compares models by that of the fan alone."
    )
