"""Compare two records of machines and tell, where they differ, which one is right."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment
from truth_oracle import Dynamic, Settled, Turning

# Relative difference of equal values; lines of one analysis that are printed.
EQUAL, SHOWN = 1e-9, 6
# Parts of the top speed below which a root is a free motion, and of damping above which it creeps.
FREE, CREEPS = 1e-6, 0.95
Array = np.ndarray
Numbers = dict[str, Array]


class Line(NamedTuple):
    """What of two records differs. `kind`: "worse" (NEW is wrong), "better" (OLD was), "other"."""

    kind: str
    text: str


def compare(old: Path, new: Path, every: bool) -> int:
    """Print all differences and their sums; 1 if NEW lost or invented something."""
    sums: Counter[tuple[str, str]] = Counter()
    for path in sorted(old.glob("*/*.npz")):
        other = new / path.relative_to(old)
        if not other.exists():
            continue
        a, b = (dict(np.load(p)) for p in (path, other))
        name = f"{path.parent.name}/{path.stem}"
        kinds = ", ".join(str(a[k]) for k in a if k.startswith("kinds/all"))
        judge = Judge(a, b, every)
        for analysis, lines in judge.analyses():
            lines = list(lines)
            group = f"{path.parent.name} {analysis.split('/')[0]}"
            for kind in {line.kind for line in lines} or {"equal"}:
                sums[group, kind] += 1
            for line in lines[:SHOWN]:
                print(
                    f"{name} {analysis}: {line.kind}: {line.text}" + f" [{kinds}]" * bool(kinds),
                    flush=True,
                )
            if len(lines) > SHOWN:
                more = Counter(line.kind for line in lines[SHOWN:])
                print(f"{name} {analysis}: and {dict(more)} more", flush=True)
    heads = ("equal", "better", "other", "worse")
    print(f"\n{'analyses by machine':28}" + "".join(f"{h:>8}" for h in heads))
    for group in sorted({g for g, _ in sums}):
        print(f"{group:28}" + "".join(f"{sums[group, h]:8}" for h in heads))
    return int(any(kind == "worse" for _, kind in sums))


class Judge:
    """Both records of a machine, and what decides between them."""

    def __init__(self, a: Numbers, b: Numbers, every: bool) -> None:
        self.a, self.b, self.every = a, b, every
        self.is_turning = "terms/mass" in a
        self.oracle = Turning(a) if self.is_turning else Dynamic(a)
        self.series = Dynamic(a, is_series=True)
        self.top = float(a.get("kinds/top", a.get("range/high", 1.0)))

    def analyses(self) -> Iterator[tuple[str, Iterable[Line]]]:
        """Names of what both have and the lines of it."""
        names = {
            k.removeprefix("refused/") if k.startswith("refused/") else k.rsplit("/", 1)[0]
            for record in (self.a, self.b)
            for k in record
        }
        own = {
            "modes": self._modes,
            "campbell": self._campbell,
            "critical": self._resonances if self.is_turning else self._critical,
            "gravity": self._resonances,
            "unstable": self._unstable,
            "response": self._response,
            "steady": self._steady,
            "exponents": self._exponents,
            "map": self._plain,
            "stiffness_map": self._plain,
        }
        seen = {n if n.split("/")[0] in ("modes", "critical") else n.split("/")[0] for n in names}
        for key in (k for k in self.a if k.startswith(("laws/", "matrices/mass", "terms/mass"))):
            pair = [r.get(key) for r in (self.a, self.b)]
            if pair[1] is not None and not _same_numbers(*pair):
                yield "machine", [Line("other", f"{key} is another one: these are two machines")]
                break
        for name in sorted(seen):
            if name.split("/")[0] in own:
                yield name, self._judged(name, own[name.split("/")[0]])
            elif name in ("machine", "assembled", "matrices"):
                texts = [str(r.get(f"refused/{name}", "")) for r in (self.a, self.b)]
                if texts[0] != texts[1] and texts[1]:
                    yield name, [Line("worse", f"new refused: {texts[1][:200]}")]

    def _judged(self, name: str, lines: Callable[[str], Iterable[Line]]) -> Iterator[Line]:
        texts = [str(r.get(f"refused/{name}", "")) for r in (self.a, self.b)]
        if texts[0] and texts[1]:
            return
        slow = ["TimeoutError" in text for text in texts]
        if texts[1] and not slow[1]:
            yield Line("other", f"new refused: {texts[1][:200]}")
        elif any(texts):
            side, text = ("new", texts[1]) if texts[1] else ("old", texts[0])
            yield Line("other", f"{side} refused: {text[:120]}")
        if slow[1]:
            return
        for line in lines(name):
            if not (slow[0] and line.kind == "better"):  # it had no time to find them
                yield line

    # --- sets of roots ----------------------------------------------------------------------------

    def _sets(
        self,
        a: Array,
        b: Array,
        judge: Callable[[complex], Settled],
        told: Callable[[complex], str],
        ceilings: tuple[float, float] = (np.inf, np.inf),
        floor: float = 0.0,
    ) -> Iterator[Line]:
        """Lines of two sets of roots; `ceilings`: of Im above which OLD and NEW need have none."""
        a, b = (np.asarray(v, dtype=complex)[np.abs(v) > floor] for v in (a, b))
        gap = np.abs(a[:, None] - b[None]) / np.maximum(np.abs(a[:, None]), 1e-300)
        rows, columns = linear_sum_assignment(np.minimum(gap / EQUAL, 1e6))
        same = gap[rows, columns] <= EQUAL
        left = [np.delete(v, i[same]) for v, i in ((a, rows), (b, columns))]
        judged = [[(s, judge(s)) for s in side] for side in left]
        if self.every:
            judged_too = [(s, judge(s)) for s in b[columns[same]]]
            yield from (
                Line("worse", f"both are no root: {told(s)}, {j}")
                for s, j in judged_too
                if not j.is_root
            )
        true: list[list[tuple[complex, Settled]]] = []
        for side, found in enumerate(judged):
            true.append([one for one in found if one[1].is_root])
            yield from (
                Line(
                    "worse" if side else "better",
                    f"{'new' if side else 'old'} is no root: {told(s)}, {j}",
                )
                for s, j in found
                if not j.is_root
            )
        for s, j in list(true[0]):
            for other in true[1]:
                allowed = 2e-8 * abs(s) + 10.0 * (j.unsure + other[1].unsure)
                if abs(j.root - other[1].root) <= allowed:
                    true[0].remove((s, j))
                    true[1].remove(other)
                    break
        for side, found in enumerate(true):
            kind, who = ("better", "old") if side else ("worse", "new")
            for s, j in found:
                if s.imag >= ceilings[1 - side] * (1.0 - 1e-9):
                    continue
                listed = int(
                    np.sum(np.abs((a if side else b) - s) <= 2e-8 * abs(s) + 10.0 * j.unsure)
                )
                if listed >= j.multiplicity:
                    extra, owner = ("worse", "new") if side else ("better", "old")
                    yield Line(
                        extra, f"{owner} lists {told(s)} too often, it is {j.multiplicity}-fold"
                    )
                else:
                    yield Line(kind, f"{who} missed {told(s)}, {j}")

    def _root(self, speed: float) -> Callable[[complex], Settled]:
        def judge(s: complex) -> Settled:
            found = self.oracle.root(s, speed)
            return found if found.is_root or self.is_turning else self.series.root(s, speed)

        return judge

    @staticmethod
    def _at(speed: float) -> Callable[[complex], str]:
        return lambda s: f"{s:.10g} 1/s at {speed:.6g} rad/s"

    def _modes(self, name: str) -> Iterator[Line]:
        at = f"{name}/speed"
        speed = float(self.a[at] if at in self.a else self.b[at])
        a, b = (
            np.concatenate([r.get(f"{name}/{part}", np.zeros(0)) for part in ("values", "real")])
            for r in (self.a, self.b)
        )
        fast = self.oracle.fastest
        own, filters = (
            [v[self._is_mode(v, fast) == is_mode] for v in (a, b)] for is_mode in (1, 0)
        )
        yield from self._sets(*own, self._root(speed), self._at(speed), floor=FREE * self.top)
        if filters[0].size != filters[1].size:
            text = (
                f"{filters[0].size} roots that creep or are those of filters, now {filters[1].size}"
            )
            yield Line("other", text)
        counts = [int(r.get(f"{name}/zeros", -1)) for r in (self.a, self.b)]
        if counts[0] != counts[1] and -1 not in counts:
            yield Line("other", f"{counts[0]} zeros, now {counts[1]}")
        if self.every:
            roots, unsure = self.oracle.roots(speed)
            kept = (
                (roots.imag >= 0)
                & self._is_mode(roots, fast)
                & (unsure < 1e-6 * np.abs(roots))
                & (np.abs(roots) < 1e7)
            )
            own = roots[kept & (np.abs(roots) > 100 * FREE * self.top)]
            for s in own:
                if not (np.abs(b - s) <= 1e-6 * abs(s)).any():
                    both = not (np.abs(a - s) <= 1e-6 * abs(s)).any()
                    index = self.oracle.index(s, speed)
                    text = f"{'both' if both else 'new'} missed {self._at(speed)(s)}, index {index}"
                    yield Line("worse" if index > 0 else "other", text)

    @staticmethod
    def _is_mode(values: Array, fast: float) -> Array:
        """Whether roots are motions of a machine with controllers; without any all are."""
        creeps = -values.real > CREEPS * np.abs(values)
        return (np.abs(values) < fast) & ~(creeps & np.isfinite(fast))

    def _campbell(self, name: str) -> Iterator[Line]:
        known = self.a if "campbell/speeds" in self.a else self.b
        speeds = known["campbell/speeds"]
        columns = [
            r.get("campbell/values", np.full((0, speeds.size), np.nan)) for r in (self.a, self.b)
        ]
        for k, speed in enumerate(speeds):
            a, b = (v[np.isfinite(v[:, k]), k] for v in columns)
            tops = tuple(v.imag.max(initial=0.0) for v in (a, b))
            yield from self._sets(a, b, self._root(speed), self._at(speed), tops, FREE * self.top)
        whirls = [r.get("campbell/whirl") for r in (self.a, self.b)]
        if all(w is not None for w in whirls) and columns[0].shape == columns[1].shape:
            apart = np.abs(columns[0] - columns[1]) > 1e-7 * np.abs(columns[0])
            if apart.any():
                yield Line(
                    "other",
                    f"branches {np.flatnonzero(apart.any(axis=1)) + 1} are connected otherwise",
                )
            elif (whirls[0] != whirls[1]).any():
                yield Line(
                    "other",
                    f"whirl of {int((whirls[0] != whirls[1]).sum())} points is told otherwise",
                )

    def _critical(self, name: str) -> Iterator[Line]:
        ratio = float(name.split("/")[1])
        a, b = (
            r.get(f"{name}/speeds", np.zeros(0))
            * (1j - ratio * r.get(f"{name}/decrements", np.zeros(0)) / (2.0 * np.pi))
            for r in (self.a, self.b)
        )

        def judge(p: complex) -> Settled:
            found = self.oracle.critical(p.imag, p.real, ratio)
            return found if found.is_root else self.series.critical(p.imag, p.real, ratio)

        def told(p: complex) -> str:
            damping = -p.real / abs(complex(p.real, ratio * p.imag))
            return f"critical speed {p.imag:.10g} rad/s (damping {damping:.3g})"

        for line in self._sets(a, b, judge, told, (self.top, self.top)):
            damping = float(line.text.split("(damping ")[1].split(")")[0])
            soft = "missed" in line.text and abs(damping) > CREEPS
            yield line._replace(kind="other") if soft else line

    def _resonances(self, name: str) -> Iterator[Line]:
        def speeds(r: Numbers) -> Array:
            real, ratio = r.get(f"{name}/speeds", np.zeros(0)), r.get(f"{name}/ratios", np.zeros(0))
            return real - 1j * ratio * real / np.sqrt(np.maximum(1.0 - ratio**2, 1e-12))

        def judge(v: complex) -> Settled:
            offsets = (0,) if name == "critical" else (1, -1)
            tries = [self.oracle.critical(w, h) for h in offsets for w in (v, v.conjugate())]
            found = min(tries, key=lambda one: (not one.is_root, one.residual))
            return found._replace(root=complex(found.root.real, -abs(found.root.imag)))

        yield from self._sets(
            *map(speeds, (self.a, self.b)), judge, lambda v: f"resonance at {v:.10g} rad/s"
        )

    def _exponents(self, name: str) -> Iterator[Line]:
        speeds = (self.a if "exponents/speeds" in self.a else self.b)["exponents/speeds"]
        for k, speed in enumerate(speeds):
            width = self.oracle.stride * speed

            def folded(r: Numbers, k: int = k, width: float = width) -> Array:
                v = r.get(f"exponents/values/{k}", np.zeros(0, complex))
                turned = np.round(v.imag / width) * width
                return v.real + 1j * np.abs(v.imag - turned)

            a, b = map(folded, (self.a, self.b))
            # a few harmonics are not enough for all of them at low speeds: told, not judged
            apart = [v for v in b if not (np.abs(a - v) <= 1e-6 * max(abs(v), FREE * speed)).any()]
            if apart or a.size != b.size:
                text = f"{a.size} and {b.size} exponents at {speed:.6g} rad/s, {len(apart)} differ"
                yield Line("other", text)

    # --- intervals and responses ------------------------------------------------------------------

    def _unstable(self, name: str) -> Iterator[Line]:
        lists = [
            list(
                zip(r.get("unstable/low_rad_s", ()), r.get("unstable/high_rad_s", ()), strict=True)
            )
            for r in (self.a, self.b)
        ]
        low = float(self.a.get("range/low", 0.0))
        ends = {low, self.top, *(float(e) for found in lists for pair in found for e in pair)}
        if self.every:
            ends |= set(np.linspace(low, self.top, 6 if self.is_turning else 12))
        ends = sorted(ends)
        narrow = 1e-4 if self.is_turning else EQUAL
        for first, last in pairwise(ends):
            middle = 0.5 * (first + last)
            inside = [any(x < middle < y for x, y in found) for found in lists]
            if last - first <= narrow * self.top or (inside[0] == inside[1] and not self.every):
                continue
            grows, slow, turned = self._growth(middle)
            at = f"{first:.10g} to {last:.10g} rad/s"
            if np.isnan(grows):
                if inside[0] != inside[1]:
                    yield Line("other", f"{'new' if inside[1] else 'old'} alone tells growth, {at}")
                continue
            if slow and not grows:
                if inside[0] != inside[1]:
                    yield Line("other", f"growth that is neutral or rounding, {slow:.2g} 1/s, {at}")
                continue
            wrong = [was != bool(grows) for was in inside]
            growth = f"the largest growth in the middle is {grows:.3g} 1/s"
            growth += f", of index −1 {turned:.3g} 1/s" if turned else ""
            if turned and not grows and inside[0] != inside[1]:
                yield Line("other", f"{'old' if inside[0] else 'new'} tells growth, {at}: {growth}")
                continue
            told = "stable" if grows else "unstable"
            if wrong[1]:
                yield Line(
                    "worse", f"{'both tell' if wrong[0] else 'new tells'} {told} {at}: {growth}"
                )
            elif wrong[0]:
                yield Line("better", f"old tells {told} {at}: {growth}")

    def _growth(self, speed: float) -> tuple[float, float, float]:
        if not self.is_turning:
            return self.oracle.growth(speed)
        found = self.oracle.growth(speed)
        return (
            (found if found > 1e-5 * speed else 0.0),
            max(found, 0.0) * (found > 1e-9 * speed),
            0.0,
        )

    def _response(self, name: str) -> Iterator[Line]:
        known = self.a if f"{name}/speeds" in self.a else self.b
        where = [
            str(known[f"{name}/at"]),
            float(known[f"{name}/moment"]),
            float(known[f"{name}/phase"]),
        ]
        nodes = [str(n) for n in known[f"{name}/nodes"]]
        both = [r.get(f"{name}/translation") for r in (self.a, self.b)]
        for k, speed in enumerate(known[f"{name}/speeds"]):
            shown = [None if v is None else np.nan_to_num(v[k]) for v in both]
            if not self.every and all(v is not None for v in shown) and _equal(*shown):
                continue
            motion, rounding = self.oracle.response(float(speed), *where)
            own = np.array([self.a[f"matrices/seats/{n}"][:2] @ motion for n in nodes])
            yield from self._right(
                shown, own, f"response at {speed:.6g} rad/s", EQUAL + 100.0 * rounding
            )

    def _right(
        self, shown: list[Array | None], own: Array, what: str, allowed: float
    ) -> Iterator[Line]:
        size = np.abs(own).max()
        missed = [np.inf if v is None else np.abs(v - own).max() / size for v in shown]
        wrong = [m > allowed for m in missed]
        text = (
            f"{what}: old misses by {missed[0]:.1e}, new by {missed[1]:.1e}, allowed {allowed:.1e}"
        )
        if wrong[1]:
            yield Line("worse", text)
        elif wrong[0]:
            yield Line("better", text)

    def _steady(self, name: str) -> Iterator[Line]:
        known = self.a if "steady/speeds" in self.a else self.b
        for k, speed in enumerate(known["steady/speeds"]):
            head = f"steady/motion/{k}/"
            both = [
                {int(n[len(head) :]): v for n, v in r.items() if n.startswith(head)}
                for r in (self.a, self.b)
            ]
            hs = sorted(set(both[0]) | set(both[1]))
            n = self.a["terms/mass"].shape[0]
            shown = [np.array([r.get(h, np.zeros(n)) for h in hs]) if r else None for r in both]
            if all(v is not None for v in shown) and _equal(*shown):
                continue
            found = self.oracle.steady(float(speed), known["steady/load"])
            own = np.array([found.get(h, np.zeros(n)) for h in hs])
            yield from self._right(shown, own, f"steady motion at {speed:.6g} rad/s", 1e-8)

    def _plain(self, name: str) -> Iterator[Line]:
        for key in sorted({k for r in (self.a, self.b) for k in r if k.startswith(f"{name}/")}):
            pair = [r.get(key) for r in (self.a, self.b)]
            if any(v is None for v in pair) or pair[0].shape != pair[1].shape:
                yield Line(
                    "other",
                    f"{key} has {' and '.join(str(getattr(v, 'shape', 'none')) for v in pair)}",
                )
            elif not _equal(*pair):
                yield Line("other", f"{key} differs by {_largest(*pair):.2e} of itself")


def _same_numbers(a: Array, b: Array) -> bool:
    return bool(np.array_equal(a, b) if a.dtype.kind in "US" else _equal(a, b))


def _largest(a: Array, b: Array) -> float:
    if (np.isfinite(a) != np.isfinite(b)).any():
        return np.inf
    size = np.abs(np.nan_to_num(a)).max(initial=0.0)
    return float(np.abs(np.nan_to_num(a) - np.nan_to_num(b)).max(initial=0.0) / (size or 1.0))


def _equal(a: Array, b: Array) -> bool:
    return a.shape == b.shape and _largest(a, b) <= EQUAL
