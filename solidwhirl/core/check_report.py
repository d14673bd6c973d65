"""How the checks of a run or a file are reported."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict
from typing import Any

from solidwhirl.core.plain_data import plain_data
from solidwhirl.rotordyn.superelement.invariants import Invariant


def failed(checks: Iterable[Invariant]) -> tuple[Invariant, ...]:
    """Return the checks that do not hold."""
    return tuple(check for check in checks if check.passed is False)


def checks_line(checks: Iterable[Invariant]) -> str:
    """Return how many checks failed, passed and do not apply, in words."""
    listed = list(checks)
    bad, open_ = len(failed(listed)), [c for c in listed if c.passed is None]
    said = [f"{bad} FAILED"] if bad else []
    said.append(f"{len(listed) - bad - len(open_)} passed")
    if open_:
        damped = all("damp" in check.reason for check in open_)
        said.append(f"{len(open_)} not applicable{' (damped system)' if damped else ''}")
    return ", ".join(said)


def failure_lines(checks: Iterable[Invariant]) -> tuple[str, ...]:
    """Say of every failed check, in a line, which numbers can't be trusted."""
    return tuple(
        f"check failed: {c.where}: {c.name}: {_number(c.value)}, allowed {_number(c.limit)}"
        f"{f' ({c.reason})' if c.reason else ''}; can't be trusted: {c.concerns}"
        for c in failed(checks)
    )


def checks_document(checks: Sequence[Invariant]) -> list[dict[str, Any]]:
    """Return the checks as plain data; a value that is not finite is null."""
    return [plain_data(asdict(check)) for check in checks]


def checks_text(checks: Sequence[Invariant]) -> str:
    """Return the checks of a run in Markdown: what failed, then all of them by name."""
    lines = [f"- **{line}**" for line in failure_lines(checks)]
    open_ = [c for c in checks if c.passed is None]
    head = f"{len(checks)} checks: {checks_line(checks)}."
    if not lines:
        head += " What can go wrong unseen otherwise is in docs/checks.md."
    rows = ["| check | number | nearest to its limit | value | limit |", "|---|---|---|---|---|"]
    rows += [
        f"| {c.name} | {count} | {c.where} | {_number(c.value)} | {_number(c.limit)} |"
        for count, c in nearest_to_limit(checks)
    ]
    undecided = [f"- not applicable: {c.where}: {c.name}: {c.reason}" for c in open_]
    blocks = [head, "\n".join(lines), "\n".join(rows), "\n".join(undecided)]
    return "\n\n".join(block for block in blocks if block)


def nearest_to_limit(checks: Iterable[Invariant]) -> list[tuple[int, Invariant]]:
    """Return of each name that was decided the number, and the one nearest to its limit."""
    found: dict[str, list[Invariant]] = {}
    for check in checks:
        if check.passed is not None:
            found.setdefault(check.name, []).append(check)
    return [(len(same), max(same, key=_nearness)) for same in found.values()]


def _nearness(check: Invariant) -> float:
    """Order checks of one name by how near they are to their limit, failed ones first."""
    value, limit = check.value or 0.0, check.limit or 0.0
    if not check.passed:
        return float("inf")
    return value / limit if limit > 0 else value - limit


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.1e}" if value else "0"
