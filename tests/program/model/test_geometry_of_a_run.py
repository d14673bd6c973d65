"""A run computes what its results carry once: geometry, doubts, alarms, the document."""

from __future__ import annotations

from collections import Counter

import pytest
from typer.testing import CliRunner

from solidwhirl.cli import app
from solidwhirl.model import bodies
from solidwhirl.output import documents
from solidwhirl.pipeline import results as records
from solidwhirl.pipeline import run

ONCE = (
    (bodies.geo, "Body"),
    (run, "build_bodies"),
    (run, "implausible"),
    (records, "support_doubts"),
    (records, "alarms_of"),
    (records, "operating_speeds"),
    (documents, "results_document"),
    (documents, "accuracy_document"),
)


@pytest.mark.solver
def test_nothing_is_computed_twice(root, tmp_path, monkeypatch):
    calls = Counter()

    def count(module, name):
        own = getattr(module, name)

        def counted(*args, **fields):
            calls[name] += 1
            return own(*args, **fields)

        monkeypatch.setattr(module, name, counted)

    for module, name in ONCE:
        count(module, name)
    scene = root / "scenes" / "laval.toml"
    options = ["--level", "beam", "--out", str(tmp_path / "out")]
    done = CliRunner().invoke(app, ["run", str(scene), *options])
    assert done.exit_code == 0, done.output
    assert (tmp_path / "out" / "report.html").is_file()
    assert calls == {name: 1 for _, name in ONCE}
