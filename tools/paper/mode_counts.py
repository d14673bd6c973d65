"""Section 5.1 of Müller and Hennings: how many modes each unit has, and what a second one could."""

from __future__ import annotations

from functools import partial

import numpy as np
from paper.rows import markdown, with_error, words
from paper.runs import SOURCE, STORE
from paper.variants import (
    CLIMBED,
    Counted,
    Reached,
    counted,
    highest_pair,
    on_bearings,
    with_nodes_held,
    with_rigid_stages,
)

SAID = SOURCE["section_5_1"]
BRANCHES = SOURCE["figure_11"]["branches"]
# Readings of what is counted.
_READINGS = {
    "all on the bearings": on_bearings,
    "stages rigid": with_rigid_stages,
    "all nodes held": with_nodes_held,
}
_HIGHEST = {
    unit: partial(highest_pair, unit, pair, SAID["design_rpm"][unit], STORE)
    for unit, pair in SAID["modes"].items()
}
#: What is computed beside the scenes, and kept in files
SEARCHES = tuple(_HIGHEST.values())


def mode_count_sections() -> list[str]:
    """Numbers of modes in three readings, how high a pair can be, and what that changes."""
    counts = {
        unit: {
            name: counted(unit, pair, SAID["highest_hz"][unit], change)
            for name, change in _READINGS.items()
        }
        for unit, pair in SAID["modes"].items()
    }
    rows = [
        (
            unit,
            f"{SAID['modes'][unit]} to {SAID['highest_hz'][unit]:.0f} Hz",
            *(f"{found.below} ± {found.near}" for found in own.values()),
        )
        for unit, own in counts.items()
    ]
    found = {unit: search() for unit, search in _HIGHEST.items()}
    targets = [
        (
            unit,
            f"pair {SAID['modes'][unit]} at {SAID['highest_hz'][unit]:.0f} Hz",
            _with_error(counts[unit]["all on the bearings"]),
            f"{min(own.drawn_hz):.0f} to {max(own.drawn_hz):.0f} Hz of {len(own.drawn_hz)}",
            f"{own.highest_hz:.0f} Hz ({own.highest_hz / SAID['highest_hz'][unit] - 1.0:+.0%})",
            _with_error(counts[unit]["all nodes held"]),
        )
        for unit, own in found.items()
    ]
    head = ("unit", "the target", "identified", "units drawn", "highest", "nodes held")
    return [
        markdown(("unit", "paper", *(f"ours, {name}" for name in _READINGS)), rows),
        _reading_text(counts),
        markdown(head, targets),
        _target_text(counts),
        markdown(("unit", "quantity", "identified", "second variant"), _changes(found)),
        _change_text(found),
    ]


def _with_error(found: Counted) -> str:
    return f"{with_error(found.pair_hz, found.pair_hz * found.error, '.0f')} Hz"


def _reading_text(counts: dict[str, dict[str, Counted]]) -> str:
    """What is counted, and where the paper's numbers lie."""
    below = {unit: [own[name].below for name in _READINGS] for unit, own in counts.items()}
    between = [u for u, (most, fewest, _) in below.items() if fewest <= SAID["modes"][u] <= most]
    same = [u for u, (_, fewest, _) in below.items() if fewest == SAID["modes"][u]]
    exact = f", and is that with rigid stages for {', '.join(same)}" if same else ""
    return (
        "**The paper** keeps so many bending modes of each unit up to a highest frequency, without "
        "saying how they are held or what it takes for bending. **Ours** counts pairs with one "
        "nodal diameter below that frequency: all of the unit on its bearings; with the stages "
        "next to rigid, so that only the shaft bends; and with all nodes held, as fixed-interface "
        "modes of Craig and Bampton are, which leaves stages and pieces of shaft between nodes. "
        f"The paper's number lies from the second to the first reading for {', '.join(between)}"
        f"{exact}. What the "
        "first reading has beyond are modes of disks, drums and cones with their blades as rings; "
        "who selects *bending modes* leaves them out. ± are pairs that are no further from that "
        "frequency than models for two accuracies are from each other."
    )


def _target_text(counts: dict[str, dict[str, Counted]]) -> str:
    held = {unit: own["all nodes held"].pair_hz for unit, own in counts.items()}
    low = [unit for unit, hertz in held.items() if hertz < SAID["highest_hz"][unit]]
    return (
        "Taken as a target for the first reading, the pair of the paper's number should be at its "
        "highest frequency. Units were drawn over the bounds of all "
        "parameters and brought to the masses of Table 4; from the one whose pair is highest, "
        f"a climb of {CLIMBED} models followed the directions that the masses leave free. To "
        "hold every node only raises frequencies. Where the pair is below the target even then, "
        f"as in the identified {', '.join(low)}, it is of the stages or of walls between nodes: "
        "a stiffer line of shaft does not bring it there. Frequencies of units drawn and searched, "
        "here and at Table 6, are of models for the coarser accuracy; those of the identified "
        f"units move by {_apart(counts)} with the finer one, which ± tells of them."
    )


def _apart(counts: dict[str, dict[str, Counted]]) -> str:
    found = ((unit, own["all on the bearings"].error) for unit, own in counts.items())
    return ", ".join(f"{unit} {error:.1%}" for unit, error in found)


def _changes(found: dict[str, Reached]) -> list[tuple[str, ...]]:
    """First branches at rest and, in the frame of the unit, at its design speed."""
    rows = []
    for unit, own in found.items():
        both = (own.first, own.best)
        rest = [words(u.rest_hz[: BRANCHES[unit]], ".1f") for u in both]
        speed = SAID["design_rpm"][unit]
        seen = [words(np.sort(u.seen_by(speed))[: BRANCHES[unit]], ".1f") for u in both]
        rows.append((unit, "at rest [Hz]", *rest))
        rows.append((unit, f"at {speed:.0f} rpm, rotating frame [Hz]", *seen))
    return rows


def _change_text(found: dict[str, Reached]) -> str:
    printed = SOURCE["table_6"]["at_rest"][::2]
    low = found["lp"].best.rest_hz
    missed = [f / wanted - 1.0 for f, wanted in zip(low, printed, strict=False)]
    away = ", ".join(f"{unit} {own.best.away:.2f}" for unit, own in found.items())
    told = words((100.0 * m for m in missed), "+.0f")
    return (
        "The second variants are the highest of that search; their parameters moved by up to "
        f"{away} of their ranges. The table has the branches that Figure 11 draws. Fan and high "
        "pressure unit still meet all that is printed as a result. The low pressure unit then "
        f"misses its frequencies at rest in Table 6 by {told} %, "
        "so it is no unit of the paper, and none of what follows takes it. What equally good "
        "units change is told at Table 6."
    )
