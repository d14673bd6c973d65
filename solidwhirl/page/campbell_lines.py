"""Branches of the Campbell diagram in `results.json` as arrays, and what they say on hover."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from solidwhirl.page.traces import FloatArray, numbers, percent

# Decrements below this are those of no damping.
UNDAMPED = 1e-9


class Lines(NamedTuple):
    """Branches of a document as arrays: speeds (s,), the others (b, s).

    Where a branch does not exist its frequency is nan. `damped` tells where it is critically
    damped, that is no resonance; there it has no error.
    """

    rpm: FloatArray
    hertz: FloatArray
    decrement: FloatArray
    error: FloatArray | None
    whirl: list[list[str | None]]
    damped: NDArray[np.bool_]

    @property
    def top_hz(self) -> float:
        """Highest frequency of what is a resonance; of all branches where nothing is."""
        counting = np.where(self.damped, np.nan, self.hertz)
        return float(np.nanmax(counting if np.isfinite(counting).any() else self.hertz))


def branches(document: Mapping[str, Any]) -> Lines:
    """Return the branches of the Campbell diagram in `results.json`."""
    found = document["campbell"]
    rpm = numbers(found["speed_rpm"])
    hertz = numbers(found["frequency_hz"]).reshape(-1, rpm.size)
    errors = found.get("frequency_error_estimate")
    damped = np.array(found.get("critically_damped", np.zeros(hertz.shape)), dtype=bool)
    damped = damped.reshape(hertz.shape)
    return Lines(
        rpm,
        hertz,
        numbers(found["log_decrement"]).reshape(hertz.shape),
        None if errors is None else np.where(damped, np.nan, numbers(errors).reshape(hertz.shape)),
        [list(branch) for branch in found["whirl"]],
        damped,
    )


def point_texts(lines: Lines, *, with_frequency: bool = False) -> list[list[str]]:
    """Return what stands at every point on hover, beside its coordinates, b × s.

    Parameters
    ----------
    lines
        The branches.
    with_frequency
        Give the frequency instead of decrement and error.
    """
    out = []
    for b, (hertz, decrement) in enumerate(zip(lines.hertz, lines.decrement, strict=True)):
        row = []
        for s, (f, d) in enumerate(zip(hertz, decrement, strict=True)):
            words = [f"branch {b + 1}, {lines.whirl[b][s] or 'none'}"]
            if with_frequency:
                words.append(f"{f:.6g} Hz")
            elif abs(d) > UNDAMPED:
                words.append(f"log. decrement {d:.4g}")
            if lines.damped[b, s]:
                words.append("critically damped: no resonance")
            elif lines.error is not None and not with_frequency:
                words.append(f"error {percent(float(lines.error[b, s]))}")
            row.append("<br>".join(words))
        out.append(row)
    return out
