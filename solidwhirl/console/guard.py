"""A command's work, guarded: what the user caused ends in one message and exit code 2."""

from __future__ import annotations

import errno
import logging
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np

from solidwhirl.console import exit_handling as ending
from solidwhirl.core.errors import USER_ERRORS, OutputError, SceneError, clean

# What scipy says of a system whose solution would be rounding alone.
_ILL_CONDITIONED = "Ill-conditioned matrix"
# What the system says of a file or folder that a user named, or of the disk that it lies on.
_OF_PATHS = frozenset(
    {
        *(errno.ENAMETOOLONG, errno.ENOTDIR, errno.EISDIR, errno.EACCES, errno.EPERM, errno.ELOOP),
        *(errno.EROFS, errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.ENXIO),
    }
)
_DOCTOR = "`solidwhirl doctor` says what is missing and how to install it"
_GOES_ON = "; the same command goes on from what is done"
# Libraries that an installation may lack; any other import that fails is a defect.
_INSTALLED = frozenset(
    {
        *("dolfinx", "ufl", "ffcx", "basix", "petsc4py", "slepc4py", "mpi4py", "gmsh", "meshio"),
        *(
            "matplotlib",
            "plotly",
            "jinja2",
            "pyvista",
            "vtk",
            "vtkmodules",
            "imageio",
            "xarray",
            "tornado",
        ),
    }
)


def guarded(
    scene: Path,
    work: Callable[[], None],
    *,
    told: Callable[[str], None] = lambda message: None,
    goes_on: Callable[[], bool] = lambda: False,
) -> None:
    """Run a command; what the user caused ends in one message and exit code 2.

    `goes_on`: whether the same command would go on from what is done, asked where it is
    interrupted.
    """
    logging.getLogger().setLevel(logging.WARNING)  # the form compiler talks at INFO level
    warnings.filterwarnings("error", message=_ILL_CONDITIONED)
    try:
        with ending.interruptible():
            ending.take_first_memory()
            work()
    except KeyboardInterrupt as error:
        ending.end_interrupted(error, _GOES_ON if goes_on() else "")
    except Exception as error:
        message = user_message(scene, error)
        if message is None:
            raise
        told(message)
        ending.stop(message)


def user_message(scene: Path, error: Exception) -> str | None:
    """Return what to say of an error that a user caused; None of a defect."""
    if isinstance(error, OutputError):
        return str(error)
    if isinstance(error, USER_ERRORS):
        # loads the records of scenes, which `--help` does without
        from solidwhirl.scene_reading.lines import line_of, with_lines

        if isinstance(error, SceneError):
            return str(with_lines(error))
        return line_of(scene, str(error)) if scene.suffix == ".toml" else f"{scene}: {error}"
    if ending.is_out_of_memory(error):
        return f"{scene}: {ending.memory_text(error)}"
    if isinstance(error, np.linalg.LinAlgError) or _is_ill_conditioned(error):
        return (
            f"{scene}: the numbers of this scene can not be solved ({error}); check masses, "
            "inertias, stiffnesses and units"
        )
    if isinstance(error, ImportError) and (error.name or "").partition(".")[0] in _INSTALLED:
        return f"{error}; {_DOCTOR}"
    if isinstance(error, OSError) and error.errno in _OF_PATHS and error.filename is not None:
        return f"{clean(str(error.filename))}: {error.strerror}"
    if isinstance(error, OSError) and "cannot open shared object file" in str(error):
        return f"{error}; {_DOCTOR}"
    return None


def _is_ill_conditioned(error: Exception) -> bool:
    return isinstance(error, Warning) and str(error).startswith(_ILL_CONDITIONED)
