"""`python -m solidwhirl` is the command `solidwhirl`."""

import sys

try:
    from solidwhirl.cli import main
except ModuleNotFoundError as missing:
    if (missing.name or "").partition(".")[0] == "solidwhirl":
        raise
    sys.exit(
        f"error: {missing}; the command line needs more than the rotordynamics alone: "
        "`python3 solidwhirl/console/doctor.py` says what to install, or pip install '.[pipeline]'"
    )

main()
