"""`solidwhirl export`: a superelement in the files of other programs."""

from __future__ import annotations

import json
import math
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import typer

from solidwhirl.core.errors import OutputError, choice, clean, writing
from solidwhirl.files.run_folder import refuse_existing
from solidwhirl.files.surface_files import write_surface_vtkhdf, write_surface_vtu
from solidwhirl.rotordyn.core.atomic import replace_text
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM
from solidwhirl.rotordyn.exchange.exported import Exported
from solidwhirl.rotordyn.exchange.matrices.arrays_npz import write_npz
from solidwhirl.rotordyn.exchange.matrices.dmig import write_dmig
from solidwhirl.rotordyn.exchange.matrices.matrix_market import write_matrix_market
from solidwhirl.rotordyn.exchange.matrices.op4 import write_op4
from solidwhirl.rotordyn.exchange.multibody.mbdyn import write_mbdyn
from solidwhirl.rotordyn.exchange.multibody.sid import write_sid
from solidwhirl.rotordyn.exchange.python.exudyn import write_exudyn
from solidwhirl.rotordyn.exchange.python.exudyn_frame import write_exudyn_frame
from solidwhirl.rotordyn.exchange.python.ross import write_ross
from solidwhirl.rotordyn.storage.files import read_superelement
from solidwhirl.rotordyn.storage.sidecar import superelement_document
from solidwhirl.rotordyn.superelement.record import Superelement


class Format(NamedTuple):
    """A format that bodies can be exported in."""

    writer: Callable[..., Exported]
    ending: str
    title: str
    #: Options of the command that it understands, and the writer's names for them
    options: Mapping[str, str]


def write_sidecar(element: Superelement, path: Path) -> Exported:
    """Write what a superelement is, without its matrices, as JSON."""
    text = json.dumps(superelement_document(element), indent=1, allow_nan=False)
    replace_text(path, text + "\n")
    return Exported(
        files=(path,),
        carried=("coordinates", "interfaces", "mass properties", "frequencies", "provenance"),
        left_out=("The matrices stay in the superelement file.",),
    )


_MODES = {"modes": "modes"}
_DAMPED = {"modes": "modes", "damping": "modal_damping"}
_SPEED = {"speed_rpm": "speed_rad_s"}
_SURFACE = "modes on the surface, for ParaView"
FORMATS: Mapping[str, Format] = {
    "sid": Format(
        write_sid,
        ".SID_FEM",
        "standard input data of a flexible body (Simpack, Modelica)",
        {**_DAMPED, "layout": "layout"},
    ),
    "mbdyn": Format(write_mbdyn, ".fem", "MBDyn modal joint", {**_DAMPED, "records": "level"}),
    "dmig": Format(write_dmig, ".pch", "Nastran bulk data matrices", _SPEED),
    "op4": Format(write_op4, ".op4", "Nastran output 4 matrices", _SPEED),
    "exudyn": Format(write_exudyn, ".py", "Exudyn, linear body in the inertial frame", {}),
    "exudyn-frame": Format(
        write_exudyn_frame,
        ".py",
        "Exudyn, flexible body with a moving frame",
        {**_MODES, **_SPEED},
    ),
    "ross": Format(write_ross, ".py", "ROSS rotor", {}),
    "matrix-market": Format(write_matrix_market, "", "folder of Matrix Market matrices", _SPEED),
    "npz": Format(write_npz, ".npz", "numpy arrays", _SPEED),
    "vtu": Format(write_surface_vtu, ".vtu", _SURFACE, _MODES),
    "vtkhdf": Format(write_surface_vtkhdf, ".vtkhdf", _SURFACE, _MODES),
    "json": Format(write_sidecar, ".json", "what the body is, without its matrices", {}),
}


# Formats that programs read, by the name of the program.
_READ_BY: Mapping[str, tuple[str, ...]] = {
    **dict.fromkeys(("nastran", "optistruct"), ("dmig", "op4")),
    **dict.fromkeys(("simpack", "modelica"), ("sid",)),
    **dict.fromkeys(("numpy", "python", "scipy"), ("npz", "matrix-market")),
    **dict.fromkeys(("paraview", "vtk"), ("vtu", "vtkhdf")),
    **dict.fromkeys(("ansys", "matlab"), ("matrix-market",)),
}
# Programs that have no format here: their users can still take the matrices.
_WITHOUT = ("abaqus", "adams", "recurdyn")


def export_body(
    body: Path, name: str, out: Path, options: Mapping[str, Any], *, force: bool = False
) -> Exported:
    """Write a superelement file in another format.

    Raises OutputError: an unknown format, an option that it does not have, a file that is there, or
    a place that can't be written; SuperelementError: the file can't be read, or the format can't
    take the body.
    """
    if name not in FORMATS:
        raise OutputError(f"--format: {_unknown(name)}; {choice(name, list(FORMATS))}")
    if body.is_dir():
        raise OutputError(_folder_text(body))
    chosen = FORMATS[name]
    for option in options:
        flag = option.replace("_", "-")
        if option not in chosen.options:
            takers = [key for key, other in FORMATS.items() if option in other.options]
            raise OutputError(f"--{flag}: not an option of {name}; {', '.join(takers)} have it")
        if isinstance(options[option], float) and not math.isfinite(options[option]):
            raise OutputError(f"--{flag}: found {options[option]}, a finite number is needed")
    if out.is_dir() and chosen.ending:
        raise OutputError(f"{out}: can not be written: it is a folder")
    if out.exists() and body.exists() and out.samefile(body):
        raise OutputError(f"{out}: is the file to export; choose another name")
    out = out if out.name not in ("", "..") else out.resolve()
    if out.is_file():
        refuse_existing([out], force=force)
    element = read_superelement(body)
    with writing(out):
        out.parent.mkdir(parents=True, exist_ok=True)
    named = {
        chosen.options[key]: value * RAD_S_PER_RPM if key == "speed_rpm" else value
        for key, value in options.items()
    }
    try:
        with (
            writing(out),
            tempfile.TemporaryDirectory(dir=out.parent, prefix=".writing-") as scratch,
        ):
            done = chosen.writer(element, Path(scratch) / out.name, **named)
            places = {
                file: out.parent / file.relative_to(scratch)
                for file in Path(scratch).rglob("*")
                if file.is_file()
            }
            refuse_existing(places.values(), force=force)
            for file, place in places.items():
                place.parent.mkdir(exist_ok=True)
                file.replace(place)
            return replace(done, files=tuple(places[file] for file in done.files))
    except SuperelementError as error:
        raise SuperelementError(clean(f"{body}: can not be exported as {name}: {error}")) from error


def _unknown(name: str) -> str:
    """What to say of a format that there is not; a program's name is told its formats."""
    program = name.lower()
    if program in _READ_BY:
        return f"unknown {name!r}; that program reads {' and '.join(_READ_BY[program])}"
    if program in _WITHOUT:
        return f"unknown {name!r}; matrix-market and npz hold the matrices for any program"
    return f"unknown {name!r}"


def _folder_text(folder: Path) -> str:
    """What to say of a folder in place of a body, with the bodies in it."""
    found = sorted(folder.glob("bodies/*.h5")) or sorted(folder.glob("*.h5"))
    if not found:
        return f"{folder}: is a folder without bodies; a superelement file is needed"
    what = "a folder of a run" if found[0].parent != folder else "a folder"
    return f"{folder}: is {what}; bodies in it: {', '.join(str(path) for path in found)}"


def export_command(
    body: Path, name: str, out: Path, options: Mapping[str, Any], *, force: bool
) -> None:
    """Export a body and say what was written, and what the format can not carry.

    Raises OutputError: as in `export_body`, also for what `SuperelementError` says there.
    """
    try:
        done = export_body(body, name, out, options, force=force)
    except SuperelementError as error:
        raise OutputError(str(error)) from error
    for file in done.files:
        typer.echo(f"written: {file}")
    typer.echo(f"carried: {', '.join(done.carried)}")
    for sentence in done.left_out:
        typer.echo(f"left out: {sentence}")


def formats_text() -> str:
    """One line for each format: name, usual ending, what it is, its options."""
    lines = []
    for name, found in FORMATS.items():
        flags = " ".join(f"--{key.replace('_', '-')}" for key in found.options)
        lines.append(f"{name:14} {found.ending or 'folder':9} {found.title:55} {flags}".rstrip())
    return "\n".join(lines)
