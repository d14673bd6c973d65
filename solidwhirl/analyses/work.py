"""How much there is to solve in an engine, for what it will cost."""

from __future__ import annotations

from typing import Literal, NamedTuple

#: How eigenproblems of an engine are solved: without damping; with it; with it, as complex ones of
#: half the size, where bearings follow the speed and are alike in x and y; in the frame of a body.
EngineKind = Literal["hermitian", "damped", "isotropic", "asymmetric"]


class EngineSize(NamedTuple):
    """What the work of an analysis depends on beside its own settings.

    `shafts`: different speeds at which bodies turn; `laws`: whether bearings depend on the speed;
    `uneven`: whether some are unlike in x and y; `bodies`: how many there are; `frequencies`: of
    tables, at each of which all modes of a speed are sought.
    """

    kind: EngineKind = "hermitian"
    coordinates: int = 0
    shafts: int = 1
    laws: bool = False
    uneven: bool = False
    bodies: int = 1
    frequencies: int = 1

    @property
    def search(self) -> Work:
        """Work of the search for the critical speeds that one shaft excites."""
        if self.kind == "isotropic":
            return Work(eigenproblems=60.0)
        if self.laws:
            # bearings are taken at the frequency of the excitation alone
            return Work(eigenproblems=45.0 / self.frequencies, factorisations=200.0)
        if self.kind == "damped":
            return Work(eigenproblems=11.0, factorisations=12.0)
        return Work(undamped=2.0)


class Work(NamedTuple):
    """Dense problems of the engine, about, and what is kept of them.

    `eigenproblems`: with all modes, of the engine as it is; `undamped`: the same of its stiffness
    and mass alone; `factorisations`: for a few modes; `solves`: responses at one frequency;
    `steps`: in time; `checks`: speeds at which modes are checked; `results`: what is made once for
    each, such as peaks, tables and records; `values`: numbers that are in memory at once.
    """

    eigenproblems: float = 0.0
    undamped: float = 0.0
    factorisations: float = 0.0
    solves: float = 0.0
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
