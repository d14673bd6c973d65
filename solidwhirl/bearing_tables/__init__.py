"""Coefficients of bearings and seals as their makers give them, read from files.

In: CSV with units, files of ROSS, film models of ROSS in its own environment.
Out: `CoefficientTable` in SI units, and the keys of a `[speed_laws.NAME]` of a scene.
A name is imported when it is first asked for: a scene without such files loads no reader.
"""

from typing import TYPE_CHECKING

from solidwhirl.rotordyn.core.later import import_later

if TYPE_CHECKING:
    from solidwhirl.bearing_tables.axes import at_load, in_sense_of_spin, over, turned
    from solidwhirl.bearing_tables.law import as_table_law
    from solidwhirl.bearing_tables.reading import read_table, read_tables
    from solidwhirl.bearing_tables.records import CoefficientTable, TableFileError

__all__ = [
    "CoefficientTable",
    "TableFileError",
    "as_table_law",
    "at_load",
    "in_sense_of_spin",
    "over",
    "read_table",
    "read_tables",
    "turned",
]

import_later(__name__)
