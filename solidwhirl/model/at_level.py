"""A scene with its bodies on another level."""

from __future__ import annotations

from solidwhirl.scene.records import Scene


def at_level(scene: Scene, level: str, accuracy: float) -> Scene:
    """Return the scene with another level and accuracy, mesh and basis free."""
    model = scene.model.model_copy(
        update={
            "level": level,
            "accuracy": accuracy,
            "order": None,
            "size_m": None,
            "corner_size_m": None,
            "growth": None,
            "modes": None,
        }
    )
    bodies = {n: b.model_copy(update={"modes": None}) for n, b in scene.bodies.items()}
    return scene.model_copy(update={"model": model, "bodies": bodies})


def alone_at_level(scene: Scene, level: str) -> Scene:
    """Return what a comparison of levels computes: the engine to the same accuracy, no more."""
    other = at_level(scene, level, scene.model.accuracy)
    model = other.model.model_copy(update={"compare_coupling": "off"})
    return other.model_copy(update={"analyses": (), "model": model})
