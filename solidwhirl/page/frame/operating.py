"""Operating speeds that a scene names in its analyses, for charts over the speed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from solidwhirl.analyses.base import Operating
from solidwhirl.analyses.kinds.separation_margins import margin_words
from solidwhirl.scene_checks.operating import margin_of
from solidwhirl.scene_checks.operating import operating_speeds as scene_operating

if TYPE_CHECKING:
    from solidwhirl.pipeline.run import Results


def operating_speeds(
    document: Mapping[str, Any], ratios: Mapping[str, float]
) -> tuple[Operating, ...]:
    """Return the operating speeds of shafts, each once, of `results.json`."""
    return tuple(
        Operating(o["shaft"], o["from_rpm"], o["to_rpm"], abs(ratios[o["shaft"]]))
        for o in document["operating"]
    )


def operating_rad_s(results: Results) -> dict[str, tuple[float, float]]:
    """Return lowest and highest operating Ω of the reference shaft, by what a legend says."""
    return {o.text: o.reference_rad_s for o in scene_operating(results.scene)}


def margin_text(
    speed_rpm: float, shafts: Sequence[str], operating: Sequence[Operating]
) -> str | None:
    """Return the distance of `margin_of` in words; arguments as there."""
    found = margin_of(speed_rpm, shafts, operating)
    if found is None:
        return None
    margin, shaft = found
    return f"**inside** {shaft}" if margin == 0.0 else f"{margin_words(margin)} {shaft}"
