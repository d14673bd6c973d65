"""Transient run-up with a varying speed.

Exponential integration, loads, records, force spectra, and models of less complexity.
In: `AssembledSystem`, a speed profile, loads. Out: `RunUp`.
"""

from __future__ import annotations

from solidwhirl.rotordyn.run_up.integration import (
    EnergyBalance,
    MotionState,
    RunUp,
    SpeedProfile,
    ramp_and_hold,
    run_up,
)

__all__ = ["EnergyBalance", "MotionState", "RunUp", "SpeedProfile", "ramp_and_hold", "run_up"]
