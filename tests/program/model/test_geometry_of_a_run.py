"""A run builds the geometry of each body once: its results carry it to pages and pictures."""

from __future__ import annotations

from collections import Counter

import pytest
from typer.testing import CliRunner

from solidwhirl.cli import app
from solidwhirl.model import bodies


@pytest.mark.solver
def test_each_body_is_built_once(root, tmp_path, monkeypatch):
    built = Counter()

    def counted(**fields):
        built[fields["name"]] += 1
        return body(**fields)

    body = bodies.Body
    monkeypatch.setattr(bodies, "Body", counted)
    scene = root / "scenes" / "laval.toml"
    options = ["--level", "beam", "--out", str(tmp_path / "out")]
    done = CliRunner().invoke(app, ["run", str(scene), *options])
    assert done.exit_code == 0, done.output
    assert (tmp_path / "out" / "report.html").is_file()
    assert built == {"rotor": 1}
