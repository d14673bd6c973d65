"""What the model of a problem's scene says for values of the parameters, remembered."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from solidwhirl.cache.files import StageStore
from solidwhirl.core.errors import SceneError
from solidwhirl.geometry import GeometryError, mass_properties
from solidwhirl.identify.problem import DIGITS, Problem
from solidwhirl.identify.rows import scaled_to
from solidwhirl.identify.targets import TargetSpec, is_mass_target
from solidwhirl.model.bodies import build_bodies
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.scene.records import Scene
from solidwhirl.scene_reading.reader import parse_scene

if TYPE_CHECKING:
    from solidwhirl.rotordyn import AssembledSystem

Progress = Callable[[str], None]
# What a scene asks for beyond its model.
_ANALYSES = ("speeds", "campbell", "analyses")


class InfeasibleError(ValueError):
    """Values of the parameters for which there is no model; the message says why."""


class BudgetError(RuntimeError):
    """The problem's maximum number of evaluations is used up."""


class Model:
    """Quantities of the targets for points of the unit cube of the parameters.

    A point u in [0, 1]^n stands for the values lower + u (upper - lower), rounded to `DIGITS`
    significant digits. Evaluations of the whole model are remembered, and kept in a store if one is
    given, so that a search that repeats the same points continues where it was interrupted.

    `progress`: called with one line per evaluation.
    `given`: the problem's own start, (n,). `mass_rows`, `fit_rows`: which numbers of the targets
    have closed forms, and which decide the result, (rows,). `limit`: evaluations of the whole model
    that are allowed; None for any number. `infeasible`: messages of the points without a model, in
    order, mass evaluations included.
    """

    def __init__(
        self,
        problem: Problem,
        store: StageStore | None = None,
        progress: Progress = lambda text: None,
    ) -> None:
        spec = problem.spec
        self.problem = problem
        self.infeasible: list[str] = []
        self.limit: int | None = spec.settings.maximum_evaluations
        self.mass_rows, self.fit_rows = problem.rows.is_mass, problem.rows.is_fitted
        self._progress = progress
        self._lower = np.array([p.lower for p in spec.parameters])
        self._range = np.array([p.upper - p.lower for p in spec.parameters])
        self.given = self.point({p.name: p.start for p in spec.parameters})
        self._store = store
        self._known: dict[tuple[Any, ...], list[float] | str] = {}
        self._asked: set[tuple[Any, ...]] = set()

    @property
    def evaluations(self) -> int:
        """Evaluations of the whole model, those of an interrupted run that were repeated too."""
        return len(self._asked)

    def values(self, point: FloatArray) -> dict[str, float]:
        """Return the values of the parameters by name."""
        names = [p.name for p in self.problem.spec.parameters]
        found = self._lower + point * self._range
        return {n: float(f"{v:.{DIGITS}g}") for n, v in zip(names, found, strict=True)}

    def point(self, values: Mapping[str, float]) -> FloatArray:
        """Return the point of the unit cube for values of the parameters by name."""
        found = np.array([values[p.name] for p in self.problem.spec.parameters])
        return np.asarray((found - self._lower) / self._range)

    def deviations(self, quantities: FloatArray) -> FloatArray:
        """Return the deviations of the targets in units of their tolerances, (rows,)."""
        return self.problem.rows.deviations(quantities)

    def masses(self, point: FloatArray) -> FloatArray:
        """Return the targets' quantities with nan for those that are not in closed form.

        Raises InfeasibleError: no body with these values.
        """
        try:
            return _masses(self.problem, self.problem.scene_at(self.values(point)))
        except (GeometryError, SceneError) as error:
            self.infeasible.append(str(error))
            raise InfeasibleError(str(error)) from error

    def whole(self, point: FloatArray, accuracy: float) -> FloatArray:
        """Return all targets' quantities, at a relative accuracy of the model.

        Interfaces that nothing uses are left out; see `complete`.

        Raises InfeasibleError: no model with these values; BudgetError: after the problem's maximum
        number of evaluations.
        """
        values = self.values(point)
        key = (accuracy, *values.values())
        if key in self._asked:
            return self._cached("whole", values, accuracy)
        if self.limit is not None and self.evaluations >= self.limit:
            raise BudgetError
        self._asked.add(key)
        head = f"evaluation {self.evaluations}"
        try:
            found = self._cached("whole", values, accuracy)
        except InfeasibleError as error:
            self.infeasible.append(str(error))
            self._progress(f"{head}: no model: {error}")
            raise
        deviation = np.abs(self.problem.rows.parts(found))
        worst = self.problem.rows.name[int(deviation.argmax())]
        self._progress(
            f"{head} at accuracy {accuracy:g}: {worst} deviates most, by {deviation.max():.2%}"
        )
        return found

    def complete(self, point: FloatArray, accuracy: float) -> FloatArray:
        """Return all targets' quantities of the scene with all of its interfaces, uncounted.

        Raises InfeasibleError: no model with these values.
        """
        return self._cached("complete", self.values(point), accuracy)

    def _cached(self, kind: str, values: Mapping[str, float], accuracy: float) -> FloatArray:
        asked = (kind, accuracy, *values.values())
        if asked not in self._known:
            self._known[asked] = self._kept(kind, values, accuracy)
        found = self._known[asked]
        if isinstance(found, str):
            raise InfeasibleError(found)
        return np.array(found)

    def _kept(self, kind: str, values: Mapping[str, float], accuracy: float) -> list[float] | str:
        if self._store is None:
            return self._computed(values, accuracy, kind)
        key = self._store.key(kind, self.problem.fingerprint, accuracy, values)
        found: list[float] | str | None = self._store.find(key, self._progress)
        if found is None:
            found = self._computed(values, accuracy, kind)
            if not isinstance(found, str):
                self._store.keep(key, "an evaluation", found, self._progress)
        return found

    def _computed(
        self, values: Mapping[str, float], accuracy: float, kind: str
    ) -> list[float] | str:
        """Quantities, or why there is no model."""
        try:
            data = self.problem.scene_at(values)
            seen = [place for target in self.problem.spec.targets for place in target.at]
            data = lean_scene(data, seen) if kind == "whole" else data
            found = _masses(self.problem, data)
            if self.problem.needs_model:
                _fill_frequencies(self.problem, data, accuracy, found)
        except (ValueError, np.linalg.LinAlgError) as error:
            # every stage refuses what it can not do with a ValueError of its own
            return str(error) or type(error).__name__
        return [float(value) for value in found]


def _masses(problem: Problem, data: Mapping[str, Any]) -> FloatArray:
    """Closed-form mass properties; nan for the other targets."""
    bodies = build_bodies(parse_scene(dict(data), problem.path, folder=problem.folder))
    targets, rows = problem.spec.targets, problem.rows
    wanted = {t.body for t in targets if is_mass_target(t)}
    properties = {name: mass_properties(bodies[name]) for name in bodies if name in wanted}
    found = np.full(len(rows.target), np.nan)
    for row, k in enumerate(rows.target):
        if rows.is_mass[row]:
            quantity = getattr(properties[str(targets[k].body)], targets[k].quantity)
            found[row] = np.atleast_1d(quantity)[-1]
    return found


def _fill_frequencies(
    problem: Problem, data: Mapping[str, Any], accuracy: float, found: FloatArray
) -> None:
    """Compute the natural frequencies and shapes that targets ask for."""
    from solidwhirl.pipeline.run import run_scene
    from solidwhirl.rotordyn import modes_at_speed

    targets = problem.spec.targets
    asked = sorted({t.speed_rpm for t in targets if not is_mass_target(t)})
    results = run_scene(model_scene(problem, data, accuracy, asked))
    assert results is not None
    for speed in asked:
        frequencies = modes_at_speed(results.system, speed * np.pi / 30.0).frequency_hz
        for k, t in enumerate(targets):
            if is_mass_target(t) or t.speed_rpm != speed or t.mode is None:
                continue
            if t.mode > len(frequencies):
                raise InfeasibleError(
                    f"target {t.name!r}: mode {t.mode} of {len(frequencies)} that the model has"
                )
            rows = np.array(problem.rows.target) == k
            hertz = frequencies[t.mode - 1]
            found[rows] = _shape(results.system, t, hertz) if t.shape else hertz


def _shape(system: AssembledSystem, target: TargetSpec, frequency_hz: float) -> FloatArray:
    """Return the motion of places in a mode at rest, in the scale of the measured shape.

    Of modes in two planes it is the one along the direction of the target.
    """
    from solidwhirl.analyses.unbalances import end_of
    from solidwhirl.rotordyn.modal_test.families import mode_families
    from solidwhirl.rotordyn.modal_test.places import interface_direction

    families = mode_families(system)
    if not families.count:
        raise InfeasibleError(f"target {target.name!r}: the model has no lateral modes")
    direction = np.array([1.0, 0.0, 0.0] if target.direction == "x" else [0.0, 1.0, 0.0])
    ends = [end_of(place) for place in target.at]
    rows = np.array([interface_direction(system, e.body, e.interface, direction) for e in ends])
    nearest = int(np.abs(families.family_hz - frequency_hz).argmin())
    left, singular, _ = np.linalg.svd(families.motion(rows, nearest), full_matrices=False)
    return scaled_to(left[:, 0] * singular[0], np.array(target.shape))


def model_scene(
    problem: Problem, data: Mapping[str, Any], accuracy: float, speeds_rpm: list[float]
) -> Scene:
    """The scene at these speeds without its analyses.

    Meshes follow the rule for the accuracy, not their errors: differences of two models need the
    same choices in both.
    """
    model = {**data.get("model", {}), "accuracy": accuracy, "estimates": "off"}
    kept = {k: v for k, v in data.items() if k not in _ANALYSES}
    data = {**kept, "model": model, "speeds": {"list_rpm": speeds_rpm}}
    return parse_scene(data, problem.path, folder=problem.folder)


def lean_scene(data: Mapping[str, Any], seen: Sequence[str] = ()) -> dict[str, Any]:
    """The scene without interfaces that nothing uses: they add no stiffness, but cost time.

    `seen`: places that are kept all the same.
    """
    joints = [*data.get("bearings", []), *data.get("gears", [])]
    used = {joint.get(end) for joint in joints for end in ("first", "second")} | {*seen}
    lean = copy.deepcopy(dict(data))
    lean.pop("analyses", None)  # they may name the interfaces that go
    for name, body in lean.get("bodies", {}).items():
        disks = {disk["interface"] for disk in body.get("rigid_disks", [])}
        every = body.get("interfaces", [])
        kept = [
            i
            for i in every
            if f"{name}.{i['name']}" in used
            or i["name"] in disks
            or i.get("coupling", "distributing") == "rigid"
        ]
        body["interfaces"] = kept or every[:1]  # a beam needs one
    return lean
