"""Checks of a superelement file, whoever wrote it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from solidwhirl.rotordyn.storage.checked_reads import SuperelementFile, check_header
from solidwhirl.rotordyn.storage.files import read_superelement
from solidwhirl.rotordyn.storage.format import OPERATORS
from solidwhirl.rotordyn.storage.sandbox import refuse_damaged
from solidwhirl.rotordyn.superelement.body_measures import asymmetry
from solidwhirl.rotordyn.superelement.invariants import (
    Invariant,
    check_superelement,
    symmetry_check,
    undecided,
)


def check_superelement_file(path: str | Path) -> tuple[Invariant, ...]:
    """Check what must hold for the body of a file.

    Returns
    -------
    tuple of Invariant
        As `check_superelement`, with the symmetry of the matrices as they are stored: the reader
        takes out what is below its limit, and refuses what is above.

    Raises
    ------
    SuperelementError
        If the file can not be read for another reason than that.
    """
    refuse_damaged(Path(path), _stored_symmetry)
    stored = _stored_symmetry(Path(path))
    if not all(check.passed for check in stored.values()):
        first = next(iter(stored.values()))
        reason = "a body whose matrices are not symmetric or skew is not read"
        rest = undecided("all other checks", first.where, first.concerns, reason)
        return (*stored.values(), rest)
    element = read_superelement(path)
    return tuple(
        replace(stored[check.name], where=element.name) if check.name in stored else check
        for check in check_superelement(element)
    )


def _stored_symmetry(path: Path) -> dict[str, Invariant]:
    """Symmetry and skewness of the operators in a file, by name of the check."""
    with SuperelementFile.open(path) as file:
        check_header(file)
        n, where = file.coordinate_count(), file.text_attribute("name")
        checks = [
            symmetry_check(
                operator.field,
                where,
                asymmetry(
                    file.operator(name, n), 1.0 if operator.symmetry == "symmetric" else -1.0
                ),
            )
            for name, operator in OPERATORS.items()
        ]
    return {check.name: check for check in checks}
