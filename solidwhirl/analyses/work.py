"""How much there is to solve in an engine, for what it will cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, Literal, NamedTuple

#: How eigenproblems of an engine are solved: without damping; with it; with it, as complex ones of
#: half the size, where bearings follow the speed and are alike in x and y; in the frame of a body,
#: where supports are alike in x and y; there, with harmonics of the turn, where they are not.
EngineKind = Literal["hermitian", "damped", "isotropic", "asymmetric", "periodic"]


class EngineSize(NamedTuple):
    """What the work of an analysis depends on beside its own settings.

    `parts`: coordinates of the parts that nothing couples; `whole`: whether modes are those of
    whole spectra at every speed, as some motions have no stiffness or forces depend on the
    frequency, and not continued from one to the next; `shafts`: different speeds at which bodies
    turn; `laws`: whether bearings depend on the speed; `uneven`: whether some are unlike in x and
    y; `bodies`: how many there are; `frequencies`: of tables, at each of which all modes of a speed
    are sought; `speed_ratios`: of the bodies; `top_rad_s`: up to which critical speeds are sought
    in every run; `operating`: `[[operating]]` of the scene.
    """

    kind: EngineKind = "hermitian"
    coordinates: int = 0
    parts: tuple[float, ...] = ()
    whole: bool = False
    shafts: int = 1
    laws: bool = False
    uneven: bool = False
    bodies: int = 1
    frequencies: int = 1
    speed_ratios: Mapping[str, float] = MappingProxyType({})
    top_rad_s: float = 0.0
    operating: Sequence[Any] = ()

    @property
    def search(self) -> Work:
        """Work of the search for the critical speeds that one shaft excites."""
        if self.kind == "isotropic" and self.whole:
            return Work(undamped=150.0, factorisations=140.0)
        if self.kind == "isotropic":
            return Work(eigenproblems=18.0, continued=130.0, factorisations=50.0)
        if self.laws:
            # bearings are taken at the frequency of the excitation alone
            return Work(eigenproblems=25.0 / self.frequencies, continued=45.0, factorisations=70.0)
        if self.kind == "damped":
            return Work(eigenproblems=10.0, factorisations=23.0)
        return Work(undamped=2.0)


class Work(NamedTuple):
    """Dense problems of the engine, about, and what is kept of them.

    `eigenproblems`: with all modes, of the engine as it is; `undamped`: the same of its stiffness
    and mass alone; `continued`: lowest modes that follow from those at another speed;
    `factorisations`: for a few modes; `solves`: responses at one frequency; `balances`: harmonics
    of a motion that are balanced once; `steps`: in time; `checks`: speeds at which modes are
    checked; `results`: what is made once for each, such as peaks, tables and records; `values`:
    numbers that are in memory at once.
    """

    eigenproblems: float = 0.0
    undamped: float = 0.0
    continued: float = 0.0
    factorisations: float = 0.0
    solves: float = 0.0
    balances: float = 0.0
    steps: float = 0.0
    checks: float = 0.0
    results: float = 0.0
    values: float = 0.0

    def times(self, count: float) -> Work:
        """Return the work done so many times."""
        return Work(*(count * each for each in self))

    def and_also(self, other: Work) -> Work:
        """Return the work of both."""
        return Work(*(a + b for a, b in zip(self, other, strict=True)))
