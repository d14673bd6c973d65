"""What a user causes ends in one message: no error class of the program may be left out."""

from __future__ import annotations

import importlib
import pkgutil

import solidwhirl
from solidwhirl.core.errors import USER_ERRORS

# Caught where they are raised, and told as another error that is one of the user's.
CAUGHT = {
    "CodecError",
    "ForeignError",
    "InfeasibleError",
    "MeasuredFileError",
    "PlaceError",
    "SweepPictureError",
}


def _modules(package):
    for found in pkgutil.iter_modules(package.__path__, f"{package.__name__}."):
        if found.name == "solidwhirl.__main__":
            continue
        module = importlib.import_module(found.name)
        yield module
        if found.ispkg:
            yield from _modules(module)


def test_every_refusal_is_an_error_of_the_user():
    kinds = {
        kind
        for module in _modules(solidwhirl)
        for kind in vars(module).values()
        if isinstance(kind, type)
        and issubclass(kind, ValueError)
        and kind.__module__ == module.__name__
        and not kind.__name__.startswith("_")
    }
    assert len(kinds) > 10
    left_out = {kind.__name__ for kind in kinds if not issubclass(kind, USER_ERRORS)}
    assert left_out == CAUGHT
