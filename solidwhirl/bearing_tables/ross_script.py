"""Compute a film model of ROSS: `python ross_script.py request.json reply.json`.

Runs inside the environment of ROSS, which solidwhirl is not part of, and imports nothing of it.
The request has `model`, a class of ROSS, its `arguments` and `speeds_rad_s`; the reply has
coefficients over the axis, or `error`.
"""

from __future__ import annotations

import contextlib
import importlib
import inspect
import io
import json
import sys
import warnings
from pathlib import Path
from typing import Any

_NAMES = [letter + end for letter in "kcm" for end in ("xx", "xy", "yx", "yy", "zz")]
# What stands for the speeds among the arguments of a class.
_AXES = ("speed", "frequency")


def computed(ross: Any, request: dict[str, Any]) -> dict[str, Any]:
    """Return the coefficients of a model, or what is wrong with its name or arguments."""
    model = getattr(ross, request["model"], None)
    base = ross.BearingElement
    if not (inspect.isclass(model) and issubclass(model, base)):
        known = sorted(
            name
            for name, found in vars(ross).items()
            if inspect.isclass(found) and issubclass(found, base) and _axis(found)
        )
        return {
            "error": f"model: ROSS {ross.__version__} has no bearing or seal "
            f"{request['model']!r}; it has {', '.join(known)}"
        }
    axis = _axis(model)
    given = {"n": 0, axis: request["speeds_rad_s"]} | {
        key: _quantity(ross, value) for key, value in request["arguments"].items()
    }
    taken = _parameters(model)
    missing = [name for name, needed in taken.items() if needed and name not in given]
    unknown = [name for name in given if name not in taken]
    if unknown or missing:
        return {
            "error": f"arguments: missing {', '.join(missing) or 'none'}, unknown "
            f"{', '.join(unknown) or 'none'}; {request['model']} of ROSS {ross.__version__} takes "
            f"{', '.join(taken)}"
        }
    element = model(**given)
    return {
        "version": ross.__version__,
        "axis_rad_s": _numbers(getattr(element, "frequency", None)),
        "coefficients": {name: _numbers(getattr(element, name, None)) for name in _NAMES},
    }


def _parameters(model: Any) -> dict[str, bool]:
    """Arguments of a class by name, with those that it hands on, and whether it needs each."""
    found: dict[str, bool] = {}
    for base in model.__mro__:
        if "__init__" in vars(base):
            parameters = inspect.signature(base.__init__).parameters.values()
            named = [
                p for p in parameters if p.kind is p.POSITIONAL_OR_KEYWORD and p.name != "self"
            ]
            # of a class further up the one below gives what is needed
            needs = not found
            found |= {p.name: needs and p.default is p.empty for p in named if p.name not in found}
            if not any(p.kind is p.VAR_KEYWORD for p in parameters):
                break
        if base.__name__ == "BearingElement":
            break
    return found


def _axis(model: Any) -> str:
    return next((name for name in _AXES if name in _parameters(model)), "")


def _quantity(ross: Any, value: Any) -> Any:
    """A value, or one with its unit as { value = 30, unit = "mm" }."""
    if isinstance(value, dict) and set(value) == {"value", "unit"}:
        return ross.Q_(value["value"], value["unit"])
    return value


def _numbers(values: Any) -> list[float] | None:
    """Plain numbers of an array or list; None for nothing."""
    if values is None:
        return None
    plain: Any = values.tolist() if hasattr(values, "tolist") else values
    return [float(v) for v in (plain if isinstance(plain, list) else [plain])]


def main() -> None:
    """Read the request, write the reply."""
    with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
        warnings.simplefilter("ignore")
        ross = importlib.import_module("ross")
        request = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
        try:
            reply = computed(ross, request)
        except Exception as error:  # what a model says of its numbers is for the user
            unit = "; it needs its unit, as { value = 15, unit = 'deg' }" * ("m_as" in str(error))
            reply = {"error": f"{request['model']}: {type(error).__name__}: {error}{unit}"}
    Path(sys.argv[2]).write_text(json.dumps(reply), encoding="utf-8")


if __name__ == "__main__":
    main()
