"""The cases of a study: one scene with ladders of `[model]` settings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from solidwhirl.meshing import CORNER_RATE
from solidwhirl.model.bodies import build_bodies
from solidwhirl.scene.records import Scene

# Fixed meshes: the estimates' own comparison models follow this accuracy.
_FIXED_ACCURACY = 5e-3
# Sizes over the thinnest section: largest element, element at corners, uniform elements.
_LARGEST, _CORNER, _UNIFORM, _SOLID_CORNER = 4.0, 0.3, 2.0, 1.0
# One rung of the graded ladder divides the largest size by this.
_STEP = 2.0**0.5


@dataclass(frozen=True, kw_only=True)
class Ladders:
    """How much a study runs.

    `reference_accuracy` (of the truth) and `adaptive` are accuracies of harmonic runs;
    `graded` and `uniform` are rungs (refinements) by element order; `solid` are sizes
    over those of the first graded rung; `modes` are numbers of fixed-interface modes on one fine
    graded mesh of order 4. The mesh ladders have so many modes that the mesh's error shows. Cases
    with a longer predicted processor time [s], which is also longer than that of the reference, are
    skipped.
    """

    reference_accuracy: float
    graded: Mapping[int, Sequence[int]]
    uniform: Mapping[int, Sequence[int]]
    solid: Sequence[float]
    adaptive: Sequence[float]
    modes: Sequence[int]
    ladder_modes: int
    solid_modes: int
    longest_s: float
    solid_longest_s: float


FULL = Ladders(
    reference_accuracy=1e-6,
    graded={2: range(-1, 6), 3: range(-1, 5), 4: range(4)},
    uniform={2: range(4), 3: range(3), 4: range(2)},
    solid=(2.0, 0.7, 0.4, 0.25, 0.15, 0.1, 0.07, 0.05),
    adaptive=(1e-1, 1e-2, 1e-3, 1e-4, 1e-5),
    modes=(2, 4, 8, 16),
    ladder_modes=24,
    solid_modes=8,
    longest_s=600.0,
    solid_longest_s=7200.0,
)
QUICK = Ladders(
    reference_accuracy=1e-4,
    graded={2: (-1, 0, 2, 5)},
    uniform={},
    solid=(),
    adaptive=(1e-2,),
    modes=(),
    ladder_modes=6,
    solid_modes=4,
    longest_s=20.0,
    solid_longest_s=20.0,
)


@dataclass(frozen=True, kw_only=True)
class StudyCase:
    """One case: the scene with another `[model]` table, run in a process of its own."""

    name: str  #: Unique in the study
    ladder: str  #: "reference", "graded", "uniform", "adaptive", "modes" or "beam"
    settings: Mapping[str, Any]  #: The `[model]` keys that are set
    scene: Scene  #: What is run
    #: "both" runs it without and with error estimates, "on" and "off" once; an adaptive mesh needs
    #: them
    estimates: Literal["both", "on", "off"] = "both"

    @property
    def level(self) -> str:
        """The model level."""
        return str(self.settings["level"])

    @property
    def series(self) -> str:
        """Name of the line it is drawn on and fitted with, such as "harmonic, order 3, graded"."""
        if self.ladder in ("beam", "reference"):
            return self.ladder
        order = [f"order {self.settings['order']}"] if "order" in self.settings else []
        return ", ".join([self.level, *order, self.ladder])


def study_cases(scene: Scene, ladders: Ladders) -> tuple[StudyCase, ...]:
    """Return the cases of a study, the reference first; analyses of the scene are left out."""
    bodies = {name: b.model_copy(update={"modes": None}) for name, b in scene.bodies.items()}
    base = scene.model_copy(update={"analyses": (), "bodies": bodies})
    spec = type(scene.model)
    return tuple(
        StudyCase(
            name=name,
            ladder=ladder,
            settings=settings,
            estimates="on" if ladder in ("adaptive", "reference") else "both",
            scene=base.model_copy(
                update={"model": spec.model_validate({"compare_coupling": "off", **settings})}
            ),
        )
        for name, ladder, settings in _settings(thinnest_m(scene), ladders)
    )


def thinnest_m(scene: Scene) -> float:
    """Return the smallest dimension of all sections of all bodies, m: it sets the sizes."""
    return min(
        min(
            s.end_m - s.start_m,
            max(o - i for i, o in zip(s.inner_radius_m, s.outer_radius_m, strict=True)),
        )
        for body in build_bodies(scene).values()
        for s in body.sections
    )


def graded_sizes(thinnest: float, order: int, rung: int) -> dict[str, float]:
    """Return the sizes of a graded mesh, m.

    Each rung divides largest size and growth by √2 and the size at corners by √2 to the power
    2p / 1.089, so that the error of the corners falls as fast as that of smooth fields would.
    """
    factor = _STEP**-rung
    corner = _CORNER * thinnest * factor ** (2.0 * order / CORNER_RATE)
    size = _LARGEST * thinnest * factor
    return {
        "size_m": size,
        "corner_size_m": min(max(corner, 1e-5 * thinnest), size),
        "growth": factor,
    }


def _settings(thinnest: float, ladders: Ladders) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Name, ladder and `[model]` settings of every case."""
    harmonic = {"level": "harmonic"}
    yield "reference", "reference", {**harmonic, "accuracy": ladders.reference_accuracy}
    for accuracy in ladders.adaptive:
        name = f"harmonic, accuracy {accuracy:g}"
        yield name, "adaptive", {**harmonic, "accuracy": accuracy}
    yield "beam", "beam", {"level": "beam"}
    fixed = {**harmonic, "accuracy": _FIXED_ACCURACY, "modes": ladders.ladder_modes}
    for order, rungs in ladders.graded.items():
        for rung in rungs:
            name = f"harmonic, order {order}, graded, rung {rung}"
            sizes = graded_sizes(thinnest, order, rung)
            yield name, "graded", {**fixed, "order": order, **sizes}
    for order, rungs in ladders.uniform.items():
        for rung in rungs:
            size = _UNIFORM * thinnest * 0.5**rung
            name = f"harmonic, order {order}, uniform, rung {rung}"
            sizes = {"size_m": size, "corner_size_m": size, "growth": 1.0}
            yield name, "uniform", {**fixed, "order": order, **sizes}
    for modes in ladders.modes:
        sizes = {"order": 4, **graded_sizes(thinnest, 4, 2)}
        yield f"harmonic, order 4, {modes} modes", "modes", {**fixed, **sizes, "modes": modes}
    for factor in ladders.solid:
        settings = {
            "level": "solid", "accuracy": _FIXED_ACCURACY, "order": 2, "growth": 0.8,
            "modes": ladders.solid_modes, "size_m": _LARGEST * thinnest * factor,
            "corner_size_m": _SOLID_CORNER * thinnest * factor,
        }  # fmt: skip
        yield f"solid, order 2, graded, sizes times {factor:g}", "graded", settings
