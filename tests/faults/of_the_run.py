"""Keys of results.json that depend on the run and not on the scene."""

from __future__ import annotations

# Times, counts and memory, and where stages came from.
OF_THE_RUN = frozenset(
    {
        "timings_s",
        "dense_problems",
        "body_problems",
        "peak_memory_gib",
        "predicted_cost",
        "stages",
    }
)
