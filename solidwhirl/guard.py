"""A command's work, guarded: what the user caused ends in one message and exit code 2."""

from __future__ import annotations

import logging
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from solidwhirl.endings import (
    end_interrupted,
    interruptible,
    is_out_of_memory,
    memory_text,
    stop,
    take_first_memory,
)
from solidwhirl.errors import OutputError, SceneError
from solidwhirl.geometry import GeometryError

# What scipy says of a system whose solution would be rounding alone.
_ILL_CONDITIONED = "Ill-conditioned matrix"


def guarded(scene: Path, work: Callable[[], None]) -> None:
    """Run a command; what the user caused ends in one message and exit code 2.

    Parameters
    ----------
    scene
        What messages name.
    work
        The command.
    """
    logging.getLogger().setLevel(logging.WARNING)  # the form compiler talks at INFO level
    warnings.filterwarnings("error", message=_ILL_CONDITIONED)
    try:
        with interruptible():
            take_first_memory()
            work()
    except SceneError as error:
        stop(str(error))
    except OutputError as error:
        stop(str(error))
    except KeyboardInterrupt as error:
        end_interrupted(error)
    except Exception as error:
        if isinstance(error, user_errors()):
            stop(f"{scene}: {error}")
        if is_out_of_memory(error):
            stop(f"{scene}: {memory_text(error)}")
        if isinstance(error, np.linalg.LinAlgError) or _is_ill_conditioned(error):
            stop(
                f"{scene}: the numbers of this scene can not be solved ({error}); check masses, "
                "inertias, stiffnesses and units"
            )
        raise


def _is_ill_conditioned(error: Exception) -> bool:
    return isinstance(error, Warning) and str(error).startswith(_ILL_CONDITIONED)


def user_errors() -> tuple[type[Exception], ...]:
    """Return the errors that a user causes, which end in one message.

    Of stages that were reached: one that was not imported raised nothing.
    """
    kinds: list[type[Exception]] = [GeometryError]
    for module, names in (
        ("solidwhirl.meshing", ("MeshingError",)),
        ("solidwhirl.cost", ("CostError",)),
        ("solidwhirl.study", ("StudyError",)),
        ("solidwhirl.batch_journal", ("BatchTableError",)),
        ("solidwhirl.reduction", ("ReductionError",)),
        ("solidwhirl.rotordyn", ("AssemblyError", "AnalysisError", "SuperelementError")),
    ):
        loaded: Any = sys.modules.get(module)
        kinds += [getattr(loaded, name) for name in names if loaded is not None]
    return tuple(kinds)
