"""`solidwhirl bearing`: a maker's table of coefficients, shown, checked and written for a scene."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from solidwhirl.commands.options import Force, completing, examples, taking
from solidwhirl.console.guard import guarded
from solidwhirl.core.errors import UserError, choice, writing

if TYPE_CHECKING:
    from rich.console import Console

    from solidwhirl.bearing_tables import CoefficientTable
    from solidwhirl.bearing_tables.records import AxialCoefficients
    from solidwhirl.bearing_tables.ross_models import Film

EXAMPLES = examples(
    "solidwhirl bearing pads.csv --out pads.toml --picture pads.png",
    'solidwhirl bearing rotor.toml --tag "Bearing 0" --csv bearing.csv',
    "solidwhirl bearing --from-ross film.toml --speeds 3000:9000:1000",
)
_WIDTH_WITHOUT_TERMINAL = 140
_MOST_ROWS = 60
_OVER_FREQUENCY = (
    "over frequency alone: --axis speed if it is the speed of the rotor, --axis frequency if it is "
    "that of the motion"
)
_AXIAL = (
    "along z no speed law acts: give axial_stiffness_n_per_m and axial_damping_n_s_per_m of one "
    "speed in the bearing itself"
)


@dataclass(frozen=True, kw_only=True)
class BearingOptions:
    """What `bearing` takes."""

    file: Annotated[
        Path | None,
        typer.Argument(metavar="FILE", help="CSV with units, or a TOML or JSON file of ROSS."),
    ] = None
    tag: Annotated[
        str | None, typer.Option(metavar="TAG", help="One of the elements of a file of ROSS.")
    ] = None
    axis: Annotated[
        str | None,
        typer.Option(
            metavar="speed|frequency",
            help="What the only axis of the table is.",
            autocompletion=completing(("speed", "frequency")),
        ),
    ] = None
    load_n: Annotated[
        float | None, typer.Option(metavar="N", help="Load of the bearing, in a table over loads.")
    ] = None
    maker_spin: Annotated[
        str,
        typer.Option(
            metavar="x_to_y|y_to_x",
            help="Sense of the spin in the maker's axes.",
            autocompletion=completing(("x_to_y", "y_to_x")),
        ),
    ] = "x_to_y"
    turned_deg: Annotated[
        float,
        typer.Option(metavar="DEG", help="Angle of the maker's x axis from ours, towards y."),
    ] = 0.0
    name: Annotated[str, typer.Option(metavar="NAME", help="Of the law in -o.")] = "table"
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="FILE.toml", help="Write a speed law.")
    ] = None
    csv: Annotated[Path | None, typer.Option(metavar="FILE.csv", help="Write the table.")] = None
    picture: Annotated[
        Path | None, typer.Option(metavar="FILE.png", help="Draw the coefficients.")
    ] = None
    from_ross: Annotated[
        Path | None,
        typer.Option(metavar="FILE.toml", help="A film model, which ROSS computes."),
    ] = None
    speeds: Annotated[
        str | None, typer.Option(metavar="FROM:TO:STEP", help="In rpm, with --from-ross.")
    ] = None
    ross_python: Annotated[
        Path | None,
        typer.Option(
            metavar="PYTHON",
            envvar="SOLIDWHIRL_ROSS_PYTHON",
            help="Of the environment that ROSS is installed in, with --from-ross.",
        ),
    ] = None
    force: Force = False


@taking(BearingOptions)
def bearing(options: BearingOptions) -> None:
    """Show and check a maker's table of coefficients, and write it as a speed law.

    Frequencies, loads and masses are kept. `kind = "file"` in a scene reads the same files.
    """
    guarded(options.file or options.from_ross or Path("bearing"), lambda: _work(options))


def _work(options: BearingOptions) -> None:
    from rich.console import Console

    from solidwhirl.bearing_tables.axes import is_over_frequency_alone
    from solidwhirl.files.run_folder import refuse_existing

    if (options.file is None) == (options.from_ross is None):
        raise UserError("give a FILE, or --from-ross with a film model")
    outputs = [path for path in (options.out, options.csv, options.picture) if path is not None]
    refuse_existing(outputs, force=options.force)
    film = None if options.from_ross is None else _of_ross(options)
    if film is not None and film.across is None and outputs:
        raise UserError(f"{_AXIAL}, and none is written")
    found = _tables(options, film)
    if len(found) > 1 and outputs:
        raise UserError(f"--tag: missing; the file has {', '.join(found)}")
    width = None if sys.stdout.isatty() else _WIDTH_WITHOUT_TERMINAL
    console = Console(width=width, highlight=False)
    for table in found.values():
        show_table(console, table)
        if options.axis is None and is_over_frequency_alone(table):
            console.print(_OVER_FREQUENCY, soft_wrap=True)
    if film is not None and film.along is not None:
        show_axial(console, film.along)
    for path in outputs:
        with writing(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            _write(options, next(iter(found.values())), path)
        typer.echo(f"written: {path}")


def _tables(options: BearingOptions, film: Film | None) -> Mapping[str, CoefficientTable]:
    """Tables that are asked for by their tags, at the load and in the axes of the scene."""
    from solidwhirl.bearing_tables import (
        at_load,
        in_sense_of_spin,
        over,
        read_table,
        read_tables,
        turned,
    )

    axis, spin = _axis(options.axis), _spin(options.maker_spin)
    if options.file is None:
        found = {} if film is None or film.across is None else {"": film.across}
    elif options.tag is None:
        found = dict(read_tables(options.file))
    else:
        found = {options.tag: read_table(options.file, options.tag)}
    out = {}
    for tag, table in found.items():
        table = at_load(table, options.load_n) if options.load_n is not None else table
        table = table if axis is None else over(table, axis)
        out[tag] = turned(in_sense_of_spin(table, spin), options.turned_deg)
    return out


def _axis(given: str | None) -> Literal["speed", "frequency"] | None:
    if given is None:
        return None
    if given == "speed":
        return "speed"
    if given == "frequency":
        return "frequency"
    raise UserError(f"--axis: found {given!r}; {choice(given, ('speed', 'frequency'))}")


def _spin(given: str) -> Literal["x_to_y", "y_to_x"]:
    if given == "x_to_y":
        return "x_to_y"
    if given == "y_to_x":
        return "y_to_x"
    raise UserError(f"--maker-spin: found {given!r}; {choice(given, ('x_to_y', 'y_to_x'))}")


def _of_ross(options: BearingOptions) -> Film:
    from solidwhirl.bearing_tables.ross_models import film_of, speeds_of

    if options.speeds is None or options.from_ross is None:
        raise UserError("--speeds: missing; --from-ross needs it, as in 3000:12000:1000")
    return film_of(options.from_ross, speeds_of(options.speeds), options.ross_python)


def _write(options: BearingOptions, table: CoefficientTable, path: Path) -> None:
    """Write what a path was named for."""
    from solidwhirl.bearing_tables.csv_files import csv_text
    from solidwhirl.bearing_tables.law import law_toml
    from solidwhirl.bearing_tables.picture import draw_table
    from solidwhirl.rotordyn.core.atomic import replace_text

    if path == options.picture:
        draw_table(table, path)
    elif path == options.csv:
        replace_text(path, csv_text(table))
    else:
        from solidwhirl.bearing_tables import over

        replace_text(path, law_toml(options.name, over(table, _axis(options.axis))))


def show_table(console: Console, table: CoefficientTable) -> None:
    """Print the coefficients of a table, what its reader noted, and what they say of themselves."""
    from rich.text import Text

    from solidwhirl.bearing_tables.checks import findings
    from solidwhirl.bearing_tables.csv_files import columns_of

    heads, numbers = columns_of(table)
    _show_rows(console, table.source, heads, numbers[:_MOST_ROWS])
    if len(numbers) > _MOST_ROWS:
        console.print(Text(f"and {len(numbers) - _MOST_ROWS} more rows"))
    for line in (*table.notes, *table.assumed, *findings(table)):
        if line.startswith("warning"):
            typer.secho(line, fg="yellow", err=True)
        else:
            console.print(Text(line))


def show_axial(console: Console, found: AxialCoefficients) -> None:
    """Print the coefficients along the axis and where a scene has them."""
    from rich.text import Text

    from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S

    heads = ("speed_rpm", "kzz_n_per_m", "czz_n_s_per_m")
    rows = zip(
        found.speeds_rad_s * RPM_PER_RAD_S,
        found.stiffness_n_per_m,
        found.damping_n_s_per_m,
        strict=True,
    )
    _show_rows(console, f"{found.source}, along z", heads, rows)
    console.print(Text(_AXIAL), soft_wrap=True)


def _show_rows(
    console: Console, title: str, heads: Sequence[str], rows: Iterable[Iterable[float]]
) -> None:
    """Print columns under their keys: coefficients with four digits, all else with six."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    from solidwhirl.core.key_units import label_of

    shown = Table(box=box.SIMPLE_HEAD, title=Text(title), title_justify="left")
    for head in heads:
        shown.add_column(label_of(head).replace(" ", "\n"), justify="right")
    for row in rows:
        digits = (4 if head[0] in "kcm" else 6 for head in heads)
        shown.add_row(*(f"{v:.{n}g}" for v, n in zip(row, digits, strict=True)))
    console.print(shown)
