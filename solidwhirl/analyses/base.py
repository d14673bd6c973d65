"""What all analyses of a scene share: the base of their records, and what they look at."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import Field, field_validator, model_validator

from solidwhirl.analyses.work import EngineSize, Work
from solidwhirl.core.blocks import AnalysisBlock, Table
from solidwhirl.core.fields import MOST, Count, FileName, Name, NotNegative, Place, Positive, Record
from solidwhirl.core.outcome import OTHERS, Drawing, Outcome, PageSection, Write
from solidwhirl.core.plain_data import Labels, plain_data, tabled
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM, RPM_PER_RAD_S
from solidwhirl.rotordyn.modes.damping import DampingRule
from solidwhirl.rotordyn.plots.chart import Chart

if TYPE_CHECKING:
    from solidwhirl.rotordyn import AssembledSystem, Campbell
    from solidwhirl.rotordyn.asymmetric import RotatingSystem
    from solidwhirl.rotordyn.run_up.integration import PartRun
    from solidwhirl.rotordyn.stability.intervals import StabilityChart, UnstableInterval

Points = Annotated[Count, Field(ge=2, le=20001)]
Places = Annotated[tuple[Place, ...], Field(min_length=1, max_length=MOST)]
Names = Annotated[tuple[Name, ...], Field(min_length=1, max_length=MOST)]

# Files and folders of a run that are no analysis.
_TAKEN = (
    *("campbell", "campbell_errors", "critical_speeds", "report", "results", "bodies", "meshes"),
    "verdict",
)
# Speeds at which shapes are drawn.
MOST_SPEEDS = 200
# Points of a map, steps of a run-up.
_MOST_POINTS = 2e6

#: Sections of a page that several kinds share; the page itself begins the first two.
CRITICAL_SPEEDS = PageSection(
    "critical-speeds",
    "Critical speeds",
    "Speeds at which the unbalance of a shaft turns as fast as the engine vibrates.",
    50,
)
MODE_SHAPES = PageSection(
    "mode-shapes", "Mode shapes", "How the engine moves in its modes, much enlarged.", 60
)
RESPONSE_MAPS = PageSection(
    "response-maps",
    "Response maps",
    "Where the engine is sensitive: over the place of an unbalance, the motion of the ground, the "
    "stiffness of supports.",
    70,
)
STABILITY = PageSection(
    "stability",
    "Stability and bearing laws",
    "Where the system is unstable, how its first modes are damped, and how bearings change with "
    "the speed.",
    100,
)
#: Why a body that stands still has no unbalance.
UNBALANCE_TURNS = "an unbalance needs a turning body"
#: Makes the charts of one picture, from top to bottom.
Charts = Callable[[], Sequence[Chart]]
Scalars = Iterator[tuple[str, float | None]]


def number_text(value: float) -> str:
    """A number as in the names of files: to 1e-6, without zeros at the end."""
    return f"{value:.6f}".rstrip("0").rstrip(".")


class OperatingSpec(Record):
    """Operating speeds of one shaft itself."""

    shaft: Name
    from_rpm: Positive
    to_rpm: Positive

    @model_validator(mode="after")
    def _rising(self) -> OperatingSpec:
        if self.to_rpm < self.from_rpm:
            raise ValueError(f"to_rpm = {self.to_rpm:g} is below from_rpm = {self.from_rpm:g}")
        return self


class Operating(NamedTuple):
    """Speeds of a shaft itself between which it runs, rpm, and its ratio to the reference.

    `bodies`: all that turn as it does, itself included; `follows`: the shaft whose given speeds
    these follow from; empty of those that are given.
    """

    shaft: str
    from_rpm: float
    to_rpm: float
    ratio: float
    bodies: tuple[str, ...] = ()
    follows: str = ""

    @property
    def text(self) -> str:
        """What a legend says."""
        return f"operating speed of {self.shaft}, {self.speeds_text}"

    @property
    def speeds_text(self) -> str:
        """Its speed, or the ends of their range."""
        low, high = self.from_rpm, self.to_rpm
        return f"{high:g} rpm" if low == high else f"{low:g} to {high:g} rpm"

    @property
    def reference_rpm(self) -> tuple[float, float]:
        """Lowest and highest speed of the reference shaft, rpm."""
        return self.from_rpm / self.ratio, self.to_rpm / self.ratio

    def is_of(self, bodies: Iterable[str]) -> bool:
        """Whether one of the bodies turns as the shaft does."""
        return not {self.shaft, *self.bodies}.isdisjoint(bodies)


def given_speeds(operating: Iterable[Operating]) -> tuple[Operating, ...]:
    """Return the operating speeds that are given; others are the same of the reference shaft."""
    return tuple(own for own in operating if not own.follows)


def judged_text(operating: Sequence[Operating], speed_ratios: Mapping[str, float]) -> str:
    """Say which of the bodies that turn were judged, at which speeds; empty if there is one."""
    turning = [name for name, ratio in speed_ratios.items() if ratio != 0.0]
    own: dict[str, list[str]] = {}
    for one in operating:
        own.setdefault(" and ".join(one.bodies or (one.shaft,)), []).append(one.speeds_text)
    others = [name for name in turning if not any(one.is_of([name]) for one in operating)]
    if len(turning) < 2:
        return ""
    said = "; ".join(f"{names} at {', '.join(speeds)}" for names, speeds in own.items())
    if not others:
        return f"judged: {said}"
    verbs = ("turns", "was") if len(others) == 1 else ("turn", "were")
    which = f"{', '.join(others)}, which {verbs[0]} too, {verbs[1]} not judged"
    return f"judged: {said} alone; {which}"


def reference_ranges_rad_s(operating: Iterable[Operating]) -> dict[str, tuple[float, float]]:
    """Return operating speeds as speeds of the reference shaft, by what a legend says."""
    ranges = ((o.text, o.reference_rpm) for o in given_speeds(operating))
    return {text: (low * RAD_S_PER_RPM, high * RAD_S_PER_RPM) for text, (low, high) in ranges}


@dataclass(frozen=True, kw_only=True, eq=False)
class Stability:
    """Where a system is unstable, and how its first modes are damped where it operates."""

    #: Range of speeds looked at, of the reference shaft
    low_rpm: float
    high_rpm: float
    #: Where it is unstable, by rising speed
    intervals: tuple[UnstableInterval, ...]
    #: Entries of `at_operating`, one for each end of the operating speeds of each shaft
    at_operating: tuple[dict[str, Any], ...]

    @property
    def stable(self) -> bool:
        """Whether nothing grows in the whole range."""
        return not self.intervals

    @property
    def unstable_from_rpm(self) -> float | None:
        """Lowest speed at which something grows; None if nothing does."""
        return min((i.low_rad_s * RPM_PER_RAD_S for i in self.intervals), default=None)


@dataclass(frozen=True, kw_only=True, eq=False)
class Engine:
    """What an analysis may look at."""

    #: The assembled engine and its Campbell diagram
    system: AssembledSystem
    #: The engine in the frame of asymmetric bodies; None without one
    rotating: RotatingSystem | None
    diagram: Campbell
    #: Of pictures
    title: str
    #: Of the bodies to the reference shaft
    speed_ratios: Mapping[str, float]
    #: Operating speeds of the shafts, those that analyses name included
    operating: tuple[Operating, ...]
    #: Makes those of all shafts that turn from those of some, of `[[operating]]` if of none
    running: Callable[[Sequence[OperatingSpec]], tuple[Operating, ...]]
    #: Which roots count as resonances
    damping_rule: DampingRule
    #: Highest frequency of the diagram, where the scene gives one
    campbell_max_hz: float | None
    #: All analyses of the scene by name
    analyses: Mapping[str, Analysis]
    #: Makes the recovery of a body by its name (`reduction.recovery.stresses`)
    recoveries: Callable[[str], Any]
    #: Makes the engine with other speed laws, by the names of bearings and of laws
    with_laws: Callable[[Mapping[str, str]], AssembledSystem]
    #: Masses of a body below one place along the axis and above another, m, as it is drawn; None of
    #: one without a drawing
    masses_beyond: Callable[[str, float, float], tuple[float, float] | None]
    #: Makes what cyclic indices of a body are reduced from, by its name
    #: (`solidwhirl.analyses.nodal_diameters.results.CyclicSource`)
    cyclic: Callable[[str], Any]
    #: Damping over speeds (s,) of the reference shaft, rad/s, of modes up to a frequency, Hz
    damping: Callable[[FloatArray, float], StabilityChart]
    #: Where it is unstable up to a speed of the reference shaft, rpm, and damping where it operates
    #: (`solidwhirl.analyses.stability_summary.Stability`)
    stability: Callable[[float], Any]
    #: Results of this engine, and of the one with its bodies on a level
    #: (`solidwhirl.analyses.kinds.level_comparison.LevelResults`)
    levels: Callable[[str], tuple[Any, Any]]
    #: Parts of run-ups of this engine, which analyses share (`rotordyn.run_up.integration.run_up`)
    run_ups: dict[Hashable, PartRun] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True, eq=False)
class Found:
    """An analysis that has run, as its charts and tables read it."""

    #: Of the analysis
    name: str
    #: What it returned; its files are data, no pictures
    outcome: Outcome
    #: What it looked at
    engine: Engine

    @cached_property
    def document(self) -> Mapping[str, Any]:
        """Its part of results.json; absent numbers are None."""
        found: Mapping[str, Any] = plain_data(self.outcome.document)
        return found

    @cached_property
    def record(self) -> Mapping[str, Any]:
        """Arrays of the .npz file that it wrote, by name."""
        return record_of(self.outcome, self.name)


def record_of(outcome: Outcome, name: str) -> dict[str, Any]:
    """Return the arrays of the .npz file of an analysis by name; nothing if it wrote none."""
    write = outcome.files.get(f"{name}.npz")
    if write is None:
        return {}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "record.npz"
        write(path)
        with np.load(path, allow_pickle=False) as file:
            return dict(file)


class Analysis(Record):
    """What all analyses share: a name for results and pictures, the kind if there is none.

    A kind says what it is asked (its fields), computes it (`run`), and tells it: `pictures` for
    paper, `blocks` for the page, `labels` for datasets, `scalars` for the table of a batch.
    """

    #: Where a page tells it.
    section: ClassVar[PageSection] = OTHERS
    #: Dimensions of the arrays of its document.
    axes: ClassVar[Mapping[str, tuple[str, ...]]] = {}
    #: Whether it writes arrays over the time as <name>.npz.
    has_record: ClassVar[bool] = False
    #: Keys that name a body which must turn, and why.
    turning: ClassVar[Mapping[str, str]] = {}
    #: What its files have after the name, with other results too.
    suffixes: ClassVar[tuple[str, ...]] = (".png",)
    #: Whether its results depend on the operating speeds of the scene.
    sees_operating: ClassVar[bool] = False
    #: Which engines it is for: "any", those whose bodies are the same in all directions, or those
    #: with one that is not.
    of_bodies: ClassVar[Literal["any", "even", "asymmetric"]] = "even"

    name: FileName | None = None

    @field_validator("name")
    @classmethod
    def _free(cls, value: str | None) -> str | None:
        if value is not None and value.lower() in _TAKEN:
            raise ValueError(f"{value!r} is the name of a file of every run; choose another")
        return value

    @property
    def label(self) -> str:
        """Name in results and file names."""
        return self.name or str(self.kind)  # type: ignore[attr-defined]

    def operating_named(self) -> Iterator[OperatingSpec]:
        """Yield the operating speeds that the analysis itself names."""
        yield from ()

    def shaft_speeds(
        self, operating: Sequence[Operating], ratio: Callable[[str], float], where: str
    ) -> Iterator[tuple[float, str]]:
        """Yield speeds of the reference shaft that follow from that of a shaft, and their source.

        `operating`: of all shafts, by `[[operating]]` of the scene. `ratio`: |speed ratio| of a
        body, inf if it stands still. `where`: what the analysis is called.
        """
        yield from ()

    def possible_files(self, bearings: Mapping[str, bool]) -> tuple[str, ...]:
        """Return the names of all files that it may write.

        `bearings`: whether they have a speed law, by name.
        """
        return tuple(f"{self.label}{suffix}" for suffix in self.suffixes)

    def work(self, size: EngineSize) -> Work:
        """Return how much it has to solve in an engine of a size."""
        return Work()

    def run(self, engine: Engine) -> Outcome:
        """Compute what is asked.

        Raises AnalysisError: the engine has no answer, such as an undamped resonance that is hit
        exactly.
        """
        raise NotImplementedError(self.label)

    def pictures(self, found: Found) -> Mapping[str, Charts]:
        """Return what makes the charts of each picture, by what its file has after the name."""
        return {}

    def blocks(self, found: Found) -> Sequence[AnalysisBlock]:
        """Return what a page tells: the charts of the pictures and the headline, if nothing else.

        Titles need not tell the name of the analysis.
        """
        files = ", ".join(f"`{file}`" for file in found.outcome.files)
        row = [found.name, found.outcome.kind, found.outcome.headline, files]
        drawn = [chart for charts in self.pictures(found).values() for chart in charts()]
        return [*drawn, Table(head=["analysis", "kind", "in short", "files"], rows=[row])]

    @classmethod
    def labels(cls, document: Mapping[str, Any]) -> Labels:
        """Return the arrays of a document with their dimensions."""
        return tabled(document, cls.axes)

    @classmethod
    def peaks(cls, document: Mapping[str, Any]) -> Iterator[dict[str, Any]] | None:
        """Yield its resonance peaks, each with `place` and `exciter`; None: it seeks none."""
        return None

    @classmethod
    def record_labels(cls, record: Mapping[str, Any], document: Mapping[str, Any]) -> Labels:
        """Return the arrays of the .npz file with their dimensions, where `has_record`."""
        return Labels(record)

    @classmethod
    def scalars(cls, document: Mapping[str, Any]) -> Scalars:
        """Yield single numbers for the row of a case; None and nan are left out."""
        yield from ()

    def told(
        self, outcome: Outcome, engine: Engine, kept: Callable[[str, Write], Write]
    ) -> Outcome:
        """Return an outcome with its pictures, and with what a page tells of it.

        `outcome`: from `run`, or kept from an earlier run. `engine`: the same that it looked at.
        `kept`: makes of the name of a picture and what draws it what writes its file.
        """
        from solidwhirl.rotordyn.plots.matplotlib_chart import draw_titled_charts

        found = Found(name=self.label, outcome=outcome, engine=engine)
        pictures = {
            f"{self.label}{suffix}.png": Drawing(
                shown=charts, draw=partial(draw_titled_charts, title=engine.title)
            )
            for suffix, charts in self.pictures(found).items()
        }
        return replace(
            outcome,
            files={**{file: kept(file, draw) for file, draw in pictures.items()}, **outcome.files},
            caption=(type(self).__doc__ or "").partition("\n")[0],
            section=self.section,
            blocks=cache(partial(self.blocks, found)),
        )


class Sweep(Analysis):
    """Speeds of the reference shaft."""

    from_rpm: NotNegative = 0.0
    to_rpm: Positive
    count: Points = 201

    @model_validator(mode="after")
    def _rising(self) -> Sweep:
        refuse_falling(self.from_rpm, self.to_rpm)
        return self

    @property
    def speeds_rad_s(self) -> FloatArray:
        """Speeds of the reference shaft, shape (count,)."""
        return np.asarray(np.linspace(self.from_rpm, self.to_rpm, self.count) * RAD_S_PER_RPM)


def refuse_falling(from_rpm: float, to_rpm: float) -> None:
    """Refuse a range of speeds that does not rise."""
    if to_rpm <= from_rpm:
        raise ValueError(f"to_rpm = {to_rpm:g} is not above from_rpm = {from_rpm:g}")


class Frequencies(Analysis):
    """Excitation frequencies from one step above zero to the highest."""

    frequency_max_hz: Positive
    frequency_count: Points = 500

    @property
    def frequencies_rad_s(self) -> FloatArray:
        """Angular frequencies in equal steps, without zero, shape (frequency_count,)."""
        return equal_steps(self.frequency_max_hz, self.frequency_count)


def refuse_large(what: str, rows: int, columns: int) -> None:
    """Refuse a map with more points than a run can hold."""
    if rows * columns > _MOST_POINTS:
        raise ValueError(
            f"{what} is {rows} x {columns} = {rows * columns}; a map has at most {_MOST_POINTS:.0f}"
        )


class Stiffnesses(Analysis):
    """Support stiffnesses, evenly spaced in their logarithm."""

    bearings: Names
    stiffness_from_n_per_m: Positive
    stiffness_to_n_per_m: Positive
    stiffness_count: Points = 31

    @model_validator(mode="after")
    def _rising(self) -> Stiffnesses:
        if self.stiffness_to_n_per_m <= self.stiffness_from_n_per_m:
            raise ValueError("stiffness_to_n_per_m is not above stiffness_from_n_per_m")
        return self

    @property
    def stiffnesses_n_per_m(self) -> FloatArray:
        """Rising, shape (stiffness_count,)."""
        low, high = self.stiffness_from_n_per_m, self.stiffness_to_n_per_m
        return np.asarray(np.geomspace(low, high, self.stiffness_count))


def synchronous_speed(
    place: str, frequency_max_hz: float, ratio: Callable[[str], float], where: str
) -> Iterator[tuple[float, str]]:
    """Yield the speed at which an unbalance turns at the highest frequency of a map."""
    body = place.partition(".")[0]
    said = f"60 times frequency_max_hz of {where}, as {body!r} turns at every frequency"
    yield 60.0 * frequency_max_hz / ratio(body), said


def spin_of(speed_rpm: float | None) -> float | None:
    """Return the spin of the reference shaft, rad/s; None: that of the unbalance."""
    return None if speed_rpm is None else speed_rpm * RAD_S_PER_RPM


def over_speed_of_force(chart: Chart, speed_rpm: float | None) -> Chart:
    """Return a chart over the speed, which is that of the force alone if the spin is given."""
    if speed_rpm is None:
        return chart
    label = f"speed of the force (reference shaft at {speed_rpm:g} rpm)"
    return replace(chart, x=replace(chart.x, label=label))


def equal_steps(frequency_max_hz: float, count: int) -> FloatArray:
    """Return angular frequencies in equal steps up to the highest, without zero."""
    steps = np.arange(1, count + 1) / count
    return np.asarray(2.0 * np.pi * frequency_max_hz * steps)


def decrements(values: FloatArray) -> list[Any]:
    """Return logarithmic decrements as plain data: rounding (exactly 0) is null."""
    array = np.asarray(values, dtype=float)
    plain: list[Any] = np.where(array == 0.0, np.nan, array).tolist()
    return plain


def largest_of(values: Any) -> float | None:
    """Return the largest number, None among them left out."""
    return max((float(v) for v in values if v is not None), default=None)


def smallest_of(values: Any) -> float | None:
    """Return the smallest number, None among them left out."""
    return min((float(v) for v in values if v is not None), default=None)


def peak_scalars(where: str, peaks: Sequence[Mapping[str, Any]]) -> Scalars:
    """Yield the peak of the largest amplitude; None where there is no peak."""
    found = max(peaks, key=lambda p: p["amplitude_m"] or 0.0, default={})
    yield f"{where}.peak_amplitude_m", found.get("amplitude_m")
    yield f"{where}.peak_speed_rpm", found.get("speed_rpm")
    yield f"{where}.peak_amplification", found.get("amplification")
