"""The level of the bodies of a scene, chosen once and kept: trying beams takes seconds."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from solidwhirl.bodies.beams_tried import beams_are_tried
from solidwhirl.cache.files import StageStore
from solidwhirl.core.machine import user_cache
from solidwhirl.core.stages import silent
from solidwhirl.geometry import Body
from solidwhirl.model.plan_records import Plan
from solidwhirl.pipeline.cached_stages import StageCache, engine_part
from solidwhirl.scene.records import Scene

if TYPE_CHECKING:  # loads the eigenvalue solvers
    from solidwhirl.beams.scene_bodies import BeamBodies
    from solidwhirl.rotordyn import Superelement

_NAME = "choice of the level"
# Room for choices that no plan has asked for lately.
_ROOM_BYTES = 1_000_000


def level_of(
    scene: Scene, bodies: Mapping[str, Body], comm: Any, stage_cache: StageCache
) -> tuple[str, Callable[[], None]]:
    """Return the level of the bodies, and a function that keeps it."""
    if not beams_are_tried(scene, bodies):  # decided in no time
        return _untried(scene), lambda: None
    keys = _keys(scene, bodies, stage_cache)
    kept: str | None = comm.bcast(stage_cache.find(keys[0]) or stage_cache.find(keys[1]))
    if kept is not None:
        stage_cache.say(_NAME, "kept")
        return kept, lambda: None
    keep: list[Callable[[], None]] = []
    level = _chosen(scene, bodies, stage_cache, keep)
    stage_cache.say(_NAME, "computed")
    keep += [
        partial(stage_cache.keep, key, _NAME, level)
        for key in (keys[:1] if level == "beam" else keys)
    ]

    def keep_all() -> None:
        for one in keep:
            one()

    return level, keep_all


def planned_level(scene: Scene, bodies: Mapping[str, Body]) -> str:
    """Return the level for a plan, kept in the user's cache folder from one plan to the next."""
    if not beams_are_tried(scene, bodies):
        return _untried(scene)
    store = StageStore(user_cache() / "levels")
    stage_cache = StageCache(store=store, progress=silent)
    keys = _keys(scene, bodies, stage_cache)
    kept: str | None = stage_cache.find(keys[0]) or stage_cache.find(keys[1])
    if kept is None:
        kept = _chosen(scene, bodies, stage_cache, [])
        for key in keys[:1] if kept == "beam" else keys:
            stage_cache.keep(key, _NAME, kept)
        store.prune(_ROOM_BYTES)
    return kept


def _untried(scene: Scene) -> str:
    return "harmonic" if scene.model.level == "auto" else scene.model.level


def _keys(scene: Scene, bodies: Mapping[str, Body], stage_cache: StageCache) -> tuple[str, str]:
    """Keys of the choice for the engine, and of one for it with any supports.

    Beams that did not do on other supports are not tried again: meridians are never worse.
    """
    return (
        stage_cache.key("level", engine_part(scene), scene.analyses, bodies),
        stage_cache.key("level beyond beams", scene.model, scene.effects, bodies),
    )


def _chosen(
    scene: Scene,
    bodies: Mapping[str, Body],
    stage_cache: StageCache,
    keep: list[Callable[[], None]],
) -> str:
    """Try beams; what keeps their models is added to `keep`, where they do."""
    from solidwhirl.beams.scene_bodies import beam_models, with_finer
    from solidwhirl.bodies.fidelity import chosen_level

    def beams(
        trial: Scene, plan: Plan, own: Mapping[str, Body]
    ) -> Iterator[Mapping[str, Superelement]]:
        of_beams = key_of_beams(stage_cache, trial, plan, own)
        found: BeamBodies | None = stage_cache.find(of_beams)
        if found is not None:
            yield from (found.elements, *found.variants)
            return
        models = []
        for model in beam_models(trial, plan, own):
            models.append(model)
            yield model
        made = with_finer(trial, plan, own, models)
        keep.append(partial(stage_cache.keep, of_beams, "beams", made))

    return chosen_level(scene, bodies, beams)


def key_of_beams(
    stage_cache: StageCache, scene: Scene, plan: Plan, bodies: Mapping[str, Body]
) -> str:
    """Key of beam models of bodies, which no support changes."""
    effects = [(effect.name, effect.on) for effect in plan.effects]
    modes = [scene.model.modes, *(scene.bodies[name].modes for name in bodies)]
    plans = [plan.bodies[name] for name in bodies]
    return stage_cache.key("beams", scene.model.estimates, effects, modes, plans, bodies)
