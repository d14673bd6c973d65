"""`solidwhirl bearing`: what it says of a table, what it writes, what it refuses."""

from __future__ import annotations

import sys
import tomllib

import numpy as np
import pytest
from typer.testing import CliRunner

from solidwhirl.bearing_tables import read_table
from solidwhirl.bearing_tables.checks import findings
from solidwhirl.bearing_tables.csv_files import read_csv
from solidwhirl.cli import app

HEAD = "speed_rpm,kxx_n_per_m,kxy_n_per_m,kyx_n_per_m,kyy_n_per_m,cxx_n_s_per_m"
PADS = f"{HEAD}\n3000,2e8,3e7,-4e7,5e8,6e5\n9000,1e8,2e7,-3e7,4e8,5e5\n"
# A film model in ROSS's manner: what it needs, and what it hands on to its base.
FAKE = """
import numpy as np
__version__ = "9.9"
class Quantity(float):
    def m_as(self, unit):
        return float(self)
def Q_(value, unit):
    return Quantity(value * {"mm": 1e-3}[unit])
class BearingElement:
    def __init__(self, n, kxx, cxx, kxy=0, frequency=None, tag=None, **kwargs):
        self.n, self.kxx, self.cxx, self.kxy, self.frequency = n, kxx, cxx, kxy, frequency
class Film(BearingElement):
    def __init__(self, n, frequency, gap, oil=1.0, **kwargs):
        if gap == 0:
            raise ZeroDivisionError("no gap")
        f = np.array(frequency)
        super().__init__(n, oil * f / gap, [2.0 * oil] * f.size, frequency=frequency, **kwargs)
class Thrust(BearingElement):
    def __init__(self, n, frequency, gap, load=1.0, **kwargs):
        super().__init__(n, 0, 0, frequency=frequency, **kwargs)
        self.kzz, self.czz = load / gap.m_as("m") * np.array(frequency), 3.0 * load
"""


def bearing(*words):
    return CliRunner().invoke(app, ["bearing", *map(str, words)])


@pytest.fixture
def pads(tmp_path):
    (tmp_path / "pads.csv").write_text(PADS)
    return tmp_path / "pads.csv"


@pytest.fixture
def ross(tmp_path):
    """A Python that imports a module `ross`."""
    (tmp_path / "modules").mkdir()
    (tmp_path / "modules" / "ross.py").write_text(FAKE)
    python = tmp_path / "python"
    python.write_text(f'#!/bin/sh\nPYTHONPATH={tmp_path}/modules exec {sys.executable} "$@"\n')
    python.chmod(0o755)
    return python


def test_what_is_shown_and_written(pads):
    folder = pads.parent
    outputs = (
        "-o",
        folder / "law.toml",
        "--csv",
        folder / "new.csv",
        "--picture",
        folder / "p.png",
    )
    done = bearing(pads, "--name", "film", *outputs)
    assert done.exit_code == 0, done.output
    for text in ("kxy", "[N/m]", "9000", "4e+08", "kxy > 0 > kyx: cross stiffness drives forward"):
        assert text in done.output
    assert f"written: {folder / 'law.toml'}" in done.output.replace("\n", "")
    law = tomllib.loads((folder / "law.toml").read_text())["speed_laws"]["film"]
    assert (law["kind"], law["speed_rpm"]) == ("table", [3000.0, 9000.0])
    assert law["stiffness_n_per_m"][0] == [[2e8, 3e7], [-4e7, 5e8]]
    again = read_table(folder / "new.csv")
    np.testing.assert_allclose(again.damping_n_s_per_m[0, 1, 0], 5e5 * np.eye(2))
    assert (folder / "p.png").stat().st_size > 10_000
    refused = bearing(pads, "-o", folder / "law.toml")
    assert refused.exit_code == 2
    assert "is there already; --force replaces it" in refused.output


def test_table_over_frequency_alone(pads):
    pads.write_text(PADS.replace("speed_rpm", "frequency_hz"))
    out = pads.with_name("law.toml")
    done = bearing(pads)
    assert done.exit_code == 0
    assert "over frequency alone: --axis speed if it is the speed" in done.output
    done = bearing(pads, "-o", out)
    assert done.exit_code == 2
    assert "axis: missing; the table is over frequency alone" in done.output
    assert not out.exists()
    assert bearing(pads, "-o", out, "--axis", "speed").exit_code == 0
    assert "speed_rpm = [180000.0, 540000.0]" in out.read_text()


def test_thrust_bearing_of_ross(tmp_path, ross):
    """What acts along z alone is shown for the keys of a bearing, and no law is made of it."""
    film = tmp_path / "thrust.toml"
    film.write_text('model = "Thrust"\n[arguments]\nload = 2\ngap = { value = 5, unit = "mm" }\n')
    words = ("--from-ross", film, "--ross-python", ross, "--speeds", "300:600:300")
    done = bearing(*words)
    assert done.exit_code == 0, done.output
    for text in ("along z", "kzz", "czz", "1.257e+04", "2.513e+04", "axial_stiffness_n_per_m"):
        assert text in done.output
    done = bearing(*words, "-o", tmp_path / "law.toml")
    assert done.exit_code == 2 and "along z no speed law acts" in done.output
    assert not (tmp_path / "law.toml").exists()
    for values, said in (
        ("gap = 5", "needs its unit, as { value = 15"),
        ('load = 0\ngap = { value = 5, unit = "mm" }', "gives no coefficients on ux, uy and uz"),
        ('load = nan\ngap = { value = 5, unit = "mm" }', "gives no number for kzz"),
    ):
        film.write_text(f'model = "Thrust"\n[arguments]\n{values}\n')
        done = bearing(*words)
        assert done.exit_code == 2 and said in done.output, done.output


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        # (kxy - kyx)/(Ω (cxx + cyy)) = 2e6/(100π·2·2e3)
        ("3000,1e7,1e6,-1e6,1e7,2e3", ["kxy > 0 > kyx", "is up to 1.59"]),
        ("3000,1e7,2e6,1e6,1e7,2e3", ["kxy > kyx: cross stiffness drives forward whirl"]),
        ("3000,1e7,1e6,1e6,1e7,2e3", ["cross stiffness is symmetric: it drives no whirl"]),
        ("3000,1e7,-1e6,1e6,1e7,2e3", ["warning: kxy < kyx: cross stiffness drives backward"]),
        ("3000,1,0,0,1,2\n6000,1,0,0,-1,2", ["warning: direct stiffness below zero at 1 of 2 "
                                             "points, first at 6000 rpm", "symmetric"]),
        ("3000,1,0,0,1,-2", ["warning: direct damping below zero at 1 of 1", "symmetric"]),
        ("3000,1,1,-1,1,2\n6000,1,-1,1,1,2", ["drives backward whirl at 1 of 2 points, first at"]),
    ],
)  # fmt: skip
def test_findings(pads, rows, said):
    found = findings(read_csv(pads, f"{HEAD}\n{rows}\n"))
    assert len(found) == len([text for text in said if not text.startswith("is up")])
    for text in said:
        assert any(text in line for line in found), found


def test_damping_that_drives_in_one_direction(pads):
    head = "rpm,kxx_n_per_m,cxx_n_s_per_m,cxy_n_s_per_m,cyx_n_s_per_m"
    found = findings(read_csv(pads, f"{head}\n1,1,2,3,3\n2,1,2,9,-9\n"))
    assert found[0] == (
        "warning: damping drives motion in one direction at 1 of 2 points, first at 1 rpm"
    )


def test_film_model_in_an_environment_of_its_own(tmp_path, ross, monkeypatch):
    monkeypatch.chdir(tmp_path)
    film, out = tmp_path / "film.toml", tmp_path / "film.csv"
    film.write_text('model = "Film"\n[arguments]\ngap = { value = 5, unit = "mm" }\noil = 3\n')
    words = ("--from-ross", film, "--ross-python", f"./{ross.name}", "--speeds", "300:1000:300")
    done = bearing(*words, "--csv", out)
    assert done.exit_code == 0, done.output
    assert "film.toml: Film of ROSS 9.9" in done.output
    table = read_table(out)
    np.testing.assert_allclose(table.speeds_rad_s, np.pi / 30 * np.array([300, 600, 900]))
    np.testing.assert_allclose(table.stiffness_n_per_m[0, :, 0, 1, 1], 600 * table.speeds_rad_s)
    for text, said in (
        ('model = "Film"\n[arguments]\noil = 3', "arguments: missing gap, unknown none; Film of"),
        ('model = "Film"\n[arguments]\ngap = 1\nwidth = 3', "missing none, unknown width; Film of"),
        ('model = "Film"\n[arguments]\ngap = 0', "Film: ZeroDivisionError: no gap"),
        ('model = "Filn"', "model: ROSS 9.9 has no bearing or seal 'Filn'; it has BearingElement,"),
        ('model = "Film"\nspeed = 3', "speed: unknown key; allowed are model, arguments"),
        ('model = "Film"\n[arguments]\nn = 3', "arguments.n: leave it out"),
        ("model = 3", 'needs model = "CLASS" and a table [arguments]'),
    ):
        film.write_text(text)
        done = bearing(*words)
        assert done.exit_code == 2, done.output
        assert said in done.output.replace("\n", " ")

    film.write_text('model = "Film"')
    done = bearing(*words[:2], "--ross-python", "/none", *words[4:])
    assert done.exit_code == 2
    assert "--ross-python: /none can not import ross; install" in done.output


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], "give a FILE, or --from-ross with a film model"),
        (["--from-ross", "a.toml"], "--speeds: missing"),
        (
            ["--from-ross", "a.toml", "--speeds", "3:2:1"],
            "--speeds: found '3:2:1', allowed is FROM",
        ),
        (["pads.csv", "--axis", "time"], "--axis: found 'time'; allowed are speed, frequency"),
        (
            ["pads.csv", "--maker-spin", "left"],
            "--maker-spin: found 'left'; allowed are x_to_y",
        ),
        (
            ["--from-ross", "film.toml", "--speeds", "1:2:1"],
            "--ross-python: missing; install ross-rotordynamics in an environment of its own",
        ),
        (["pads.csv", "--load-n", "3"], "load_n: the table has no column of loads"),
        (["pads.csv", "--tag", "a"], "tag: no 'a'; allowed are none"),
        (["pads.csv", "--picture", "p.bmp"], ".bmp"),
        (["pads.csv", "--ross-python", "/none", "--from-ross", "a"], "give a FILE, or"),
        (["--from-ross", "a", "--ross-python", "/none", "--speeds", "1:2:1"], "no such file"),
    ],
)
def test_refusals(pads, monkeypatch, words, said):
    monkeypatch.chdir(pads.parent)
    (pads.parent / "film.toml").write_text('model = "Film"')
    done = bearing(*words)
    assert done.exit_code == 2, done.output
    assert said in done.output


def test_names_of_others_make_no_tables_and_move_no_terminal(tmp_path):
    """Tags, file names and --name with line breaks and escapes, in what is written and shown."""
    ross = tmp_path / "a\n[bodies.file]\n.toml"
    ross.write_text(
        'ross_version = "2.3"\n["BearingElement_x"]\ntag = "b\\u001b[2J\\n[bodies.evil]"\n'
        "kxx = [1.0, 2.0]\ncxx = [0.0, 0.0]\nfrequency = [1.0, 2.0]\n"
    )
    done = bearing(str(ross), "--name", "n]\n[bodies.name]", "--out", str(tmp_path / "law.toml"))
    assert done.exit_code == 0, done.output
    assert "\x1b[2J" not in done.output and "\\x1b[2J" in done.output
    law = tomllib.loads((tmp_path / "law.toml").read_text())
    assert list(law) == ["speed_laws"] and list(law["speed_laws"]) == ["n]\n[bodies.name]"]


@pytest.mark.parametrize("words", [(), ("--speeds", "1:2:1", "--ross-python", "/none")])
def test_keys_of_thousands_of_names_are_refused_at_once(tmp_path, words):
    """Reading one of 20 000 names took 2.3 GB."""
    path = tmp_path / "ross.toml"
    path.write_text(".".join(["a"] * 20_000) + " = 1\n")
    done = bearing(*(("--from-ross",) if words else ()), str(path), *words)
    assert done.exit_code == 2 and "a key of more than 16 names" in done.output
