"""The least damped mode over the speed on a page: how much it is damped and which one it is."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from solidwhirl.page.campbell_lines import UNDAMPED, Lines
from solidwhirl.page.traces import FloatArray, Trace, hertz_text, line, series_style


class LeastDamped(NamedTuple):
    """Smallest decrement at each speed, the frequency of its mode, and what else is known of it."""

    rpm: FloatArray
    decrement: FloatArray
    hertz: FloatArray
    texts: list[str]

    @property
    def said(self) -> str:
        """The least of all speeds in words."""
        at = int(np.nanargmin(self.decrement))
        return (
            f"{hertz_text(float(self.hertz[at]))} "
            f"(decrement {self.decrement[at]:.3g} at {self.rpm[at]:g} rpm)"
        )


def least_of_branches(lines: Lines) -> LeastDamped | None:
    """Return the least damped branch of the Campbell diagram at each of its speeds.

    Parameters
    ----------
    lines
        The branches; those that nothing damps at any speed are left out, as torsion often is.

    Returns
    -------
    LeastDamped or None
        None where nothing is damped.
    """
    with np.errstate(invalid="ignore"):
        damped = (np.abs(lines.decrement) > UNDAMPED).any(axis=1)
    values = np.where(damped[:, None], lines.decrement, np.nan)
    known = np.isfinite(values).any(axis=0)
    if not known.any():
        return None
    columns = np.flatnonzero(known)
    rows = np.nanargmin(values[:, columns], axis=0)
    order = np.argsort(lines.rpm[columns], kind="stable")
    rows, columns = rows[order], columns[order]
    return LeastDamped(
        rpm=lines.rpm[columns],
        decrement=values[rows, columns],
        hertz=lines.hertz[rows, columns],
        texts=[
            f"branch {b + 1}, {lines.whirl[b][s] or 'no whirl'}, "
            f"{hertz_text(float(lines.hertz[b, s]))}"
            for b, s in zip(rows.tolist(), columns.tolist(), strict=True)
        ],
    )


def undamped_branches(lines: Lines) -> int:
    """Return how many branches have no damping at any speed.

    Parameters
    ----------
    lines
        The branches.
    """
    with np.errstate(invalid="ignore"):
        return int((~(np.abs(lines.decrement) > UNDAMPED).any(axis=1)).sum())


def least_traces(found: LeastDamped) -> list[Trace]:
    """Return the smallest decrement and, on the right axis, the frequency of its mode.

    Parameters
    ----------
    found
        The least damped mode at each speed.
    """
    hover = "%{x:,.0f} rpm<br><b>%{y:.4g}</b><br>%{text}<extra></extra>"
    which = series_style(6)._replace(color="@muted", dash="dot")
    return [
        line(
            found.rpm,
            found.decrement,
            "smallest logarithmic decrement",
            series_style(0),
            mode="lines+markers",
            text=found.texts,
            hovertemplate=hover,
        ),
        line(
            found.rpm,
            found.hertz,
            "frequency of that mode (right axis)",
            which,
            yaxis="y2",
            hovertemplate="%{x:,.0f} rpm<br>%{y:.5g} Hz<extra></extra>",
        ),
    ]
