"""Published or measured values beside the results of a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from solidwhirl.scene.records import ReferenceSpec
from solidwhirl.scene_reading.paths import leading_steps


def value_at(document: Mapping[str, Any], path: str) -> float | None:
    """Return the number at a place such as "critical_speeds[0].frequency_hz"; None for none."""
    found: Any = document
    for step in leading_steps(path)[0]:
        try:
            found = found[int(step[1:-1]) if step.startswith("[") else step]
        except (KeyError, IndexError, TypeError, ValueError):
            return None
    number = isinstance(found, int | float) and not isinstance(found, bool)
    return float(found) if number else None


def compared(
    references: Sequence[ReferenceSpec], document: Mapping[str, Any]
) -> list[dict[str, Any]]:
    """Compare the contents of `results.json` with the references of a scene.

    Returns
    -------
    list of dict
        Of each: what the scene says, `result`, `relative_difference` from the reference
        (None where either is missing or the reference is 0), and `met` (None without tolerance; a
        result that is missing meets none).
    """
    return [_compared(reference, value_at(document, reference.quantity))
            for reference in references]  # fmt: skip


def _compared(reference: ReferenceSpec, found: float | None) -> dict[str, Any]:
    difference = None
    if found is not None and reference.value != 0.0:
        difference = (found - reference.value) / abs(reference.value)
    met = None
    if reference.tolerance is not None:
        met = difference is not None and abs(difference) <= reference.tolerance
    return {
        "quantity": reference.quantity,
        "title": reference.title,
        "source": reference.source,
        "value": reference.value,
        "result": found,
        "relative_difference": difference,
        "tolerance": reference.tolerance,
        "met": met,
    }
