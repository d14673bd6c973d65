"""`python -m solidwhirl` and the command `solidwhirl`: the command line, where it can be loaded."""

import sys


def main() -> None:
    """Run the command line; without its packages the doctor alone, which needs none."""
    try:
        from solidwhirl.cli import main as command_line
    except ModuleNotFoundError as missing:
        if (missing.name or "").partition(".")[0] == "solidwhirl":
            raise
        if sys.argv[1:] == ["doctor"]:
            from solidwhirl.console.doctor import main as doctor

            sys.exit(doctor())
        sys.stderr.write(
            f"error: {missing}; rotordynamics alone is installed, and the command line needs more: "
            "`pip install '.[pipeline]'` in the folder of the sources installs it, and "
            "`solidwhirl doctor` says what else is missing\n"
        )
        sys.exit(2)
    command_line()


if __name__ == "__main__":
    main()
