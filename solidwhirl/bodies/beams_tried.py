"""Whether a run looks at beams before it meshes anything."""

from __future__ import annotations

from collections.abc import Mapping

from solidwhirl.geometry import Body
from solidwhirl.scene.records import Scene
from solidwhirl.scene_checks.recovery_references import meshes_for

# Beams are looked at from this accuracy on.
_COARSE_ENOUGH = 5e-3


def beams_are_tried(scene: Scene, bodies: Mapping[str, Body]) -> bool:
    """Whether the level of the bodies is chosen by what beams show.

    They can't be tried in an engine with meshes before these are reduced, hold no stress, know no
    joints between sections, and are no choice where the scene says how to mesh.
    """
    model = scene.model
    given = (model.order, model.size_m, model.corner_size_m, model.growth)
    meshed = (
        scene.mesh_bodies
        or meshes_for(scene)
        or any(b.features or b.joints for b in bodies.values())
    )
    wanted = model.level == "auto" and model.estimates == "on" and model.accuracy >= _COARSE_ENOUGH
    return bool(bodies and wanted and not meshed and given == (None,) * 4)
