"""Peaks of the normalised response of a run-up on a page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from solidwhirl.page.records import Block, Table, Text


def response_peaks(name: str, found: Mapping[str, Any]) -> Block:
    """Return the peaks of the force per excitation force, within what is excited.

    Parameters
    ----------
    name
        Of the analysis.
    found
        `normalised_response` of its part of `results.json`.
    """
    low, high = found["excited_hz"]
    within = f"from {low:.4g} to {high:.5g} Hz, the frequencies that the unbalance passes through"
    if not found["peaks"]:
        return Text(text=f"Normalised response ({name}): no peak {within}.")
    return Table(
        head=["frequency [Hz]", "force per excitation force [N/N]"],
        rows=[[f"{p['frequency_hz']:.5g}", p["force_per_force"]] for p in found["peaks"]],
        folded=f"Peaks of the normalised response ({name})",
        caption=f"Shown {within}: beyond them both spectra are side lobes, and their quotient says "
        "nothing.",
    )
