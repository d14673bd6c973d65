"""Where modules of earlier releases went: importing an old path says the new one.

For one release; remove this module, and its call in `solidwhirl/__init__.py`, in the next.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType

# Documented modules by their name in release 0.1, and where they are.
MOVED = {
    "batch_journal": "batch.journal",
    "batch_rows": "batch.rows",
    "batch_table": "batch.table",
    "cost_scale_table": "bench/scale_table.py",
    "results": "output.documents",
    "rotordyn.body_frames": "rotordyn.campbell.body_frames",
    "rotordyn.complexity": "rotordyn.run_up.complexity",
    "rotordyn.coordinates": "rotordyn.assembly.coordinates",
    "rotordyn.critical_speed_map": "rotordyn.critical_speeds.map",
    "rotordyn.differences": "rotordyn.estimates.differences",
    "rotordyn.eigen": "rotordyn.modes.eigen",
    "rotordyn.exchange.exudyn": "rotordyn.exchange.python.exudyn",
    "rotordyn.files": "rotordyn.storage.files",
    "rotordyn.force_spectrum": "rotordyn.run_up.force_spectrum",
    "rotordyn.frames": "rotordyn.campbell.body_frames",
    "rotordyn.harmonic_response": "rotordyn.response.harmonic_response",
    "rotordyn.invariants": "rotordyn.superelement.invariants",
    "rotordyn.modal_truncation": "rotordyn.modes.modal_truncation",
    "rotordyn.mode_shapes": "rotordyn.modes.mode_shapes",
    "rotordyn.participation": "rotordyn.modes.participation",
    "rotordyn.parts": "rotordyn.assembly.parts",
    "rotordyn.picture_frame": "rotordyn.plots.frame",
    "rotordyn.pictures": "rotordyn.plots.campbell",
    "rotordyn.pictures_errors": "rotordyn.plots.errors",
    "rotordyn.response_maps": "rotordyn.response.maps",
    "rotordyn.response_maps_peaks": "rotordyn.response.map_peaks",
    "rotordyn.response_maps_stiffness": "rotordyn.response.stiffness_maps",
    "rotordyn.run_up_response": "rotordyn.run_up.response",
    "rotordyn.separation_margins": "rotordyn.response.separation_margins",
    "rotordyn.state_channels": "rotordyn.state_space.channels",
    "rotordyn.state_space_file": "rotordyn.state_space.file",
    "rotordyn.system": "rotordyn.assembly.system",
    "rotordyn.unbalance": "rotordyn.response.unbalance",
    "rotordyn.unbalance_peaks": "rotordyn.response.unbalance_peaks",
    "run_folder": "files.run_folder",
    "scene_file": "scene_reading.reader",
    "store_stages": "pipeline.cached_stages",
    "surface_files": "files.surface_files",
    "sweep_analysis": "sweep.analysis",
    "sweep_records": "sweep.records",
}


class MovedModules(MetaPathFinder):
    """Refuses the import of a moved module with its new path."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Raise ModuleNotFoundError for moved modules, and leave all others to Python."""
        new = MOVED.get(fullname.removeprefix("solidwhirl."))
        if new is None or not fullname.startswith("solidwhirl."):
            return None
        place = new if "/" in new else f"solidwhirl.{new}"
        raise ModuleNotFoundError(f"{fullname} is now {place}", name=fullname)


def point_to_moved_modules() -> None:
    """Make imports of moved modules say where they are."""
    if not any(isinstance(finder, MovedModules) for finder in sys.meta_path):
        sys.meta_path.append(MovedModules())
