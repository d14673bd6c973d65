"""`--version` says what `version` says; an interrupted run says whether it goes on."""

from __future__ import annotations

import pytest
from typer.testing import CliRunner

from solidwhirl.cli import app


def test_version_is_an_option_too():
    option, command = (CliRunner().invoke(app, [word]) for word in ("--version", "version"))
    assert option.exit_code == command.exit_code == 0
    assert option.stdout == command.stdout
    assert "\nsolidwhirl " in option.stdout
    said = CliRunner().invoke(app, ["--help"]).stdout
    assert "Turbine rotors as solids" in said and "--version" in said


@pytest.mark.solver
@pytest.mark.parametrize(
    ("stage", "options", "goes_on"),
    [
        ("error estimates", (), True),
        ("error estimates", ("--fresh",), False),
        ("level", (), False),  # before anything is kept
    ],
)
def test_interrupted_run(root, tmp_path, monkeypatch, stage, options, goes_on):
    def interrupted(*arguments, **settings):
        raise KeyboardInterrupt

    place = "engine_stages.estimate_errors" if stage != "level" else "run.make_plan"
    monkeypatch.setattr(f"solidwhirl.pipeline.{place}", interrupted)
    words = ["run", str(root / "scenes" / "laval.toml"), "--out", str(tmp_path / "out")]
    done = CliRunner().invoke(app, [*words, "--level", "beam", "-q", *options])
    assert done.exit_code == 130
    more = "; the same command goes on from what is done" if goes_on else ""
    assert done.stderr == f"error: interrupted{more}\n"
