"""Rotors on makers' tables read from files, against ROSS on the same coefficients.

ROSS 2 puts a smoothing spline through a table, which passes through four rows exactly: the
comparison is at the speeds of four rows.
"""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
from ross_shafts import STEEL, complex_of, shaft
from typer.testing import CliRunner

from solidwhirl.cli import app
from solidwhirl.reduced_scene import reduce_scene
from solidwhirl.scene_reading.reader import parse_scene

pytestmark = pytest.mark.verify
ROOT = Path(__file__).parents[2]
RPM = [1500.0, 3000.0, 4500.0, 6000.0]
RAD_S = [rpm * np.pi / 30 for rpm in RPM]
FILM = {
    "weight": 525.0, "bearing_length": 0.03, "journal_diameter": 0.1, "radial_clearance": 1e-4,
    "oil_viscosity": 0.1,
}  # fmt: skip
# Whole matrices of a maker whose x is vertical, N/m and N s/m, per speed.
RNG = np.random.default_rng(5)
STIFFNESS = 1e7 * (np.array([[2.0, 0.4], [-0.7, 3.0]]) + RNG.uniform(-0.3, 0.3, (4, 2, 2)))
DAMPING = 1e4 * (np.array([[1.5, -0.2], [-0.1, 2.0]]) + RNG.uniform(-0.1, 0.1, (4, 2, 2)))
POUNDS_PER_INCH = 4.4482216152605 / 0.0254
ENDS = ("xx", "xy", "yx", "yy")


def table_of(stiffness, damping):
    """Columns as ROSS takes them."""
    return {
        f"{letter}{end}": values.reshape(-1, 4)[:, k].tolist()
        for letter, values in (("k", stiffness), ("c", damping))
        for k, end in enumerate(ENDS)
    }


def from_vertical(values):
    """x' = y, y' = -x written out, as the coefficients of a source with vertical x are given."""
    (xx, xy), (yx, yy) = np.moveaxis(values, 0, -1)
    return np.moveaxis(np.array([[yy, -yx], [-xy, xx]]), -1, 0)


def case(**bearing):
    held = [{"node": node, "speeds_rad_s": RAD_S, **bearing} for node in (0, 6)]
    asked = {"modes": {"speeds": RAD_S, "count": 8}}
    return {"material": STEEL, "shafts": [shaft(held)], "asked": asked}


CASES = {
    "film": case(film=FILM),
    "table": case(table=table_of(from_vertical(STIFFNESS), from_vertical(DAMPING))),
}


def scene_of(law, folder):
    """The shaft of the cases as a beam of a scene."""
    data = CASES["film"]["shafts"][0]
    disks = [
        {
            "name": f"disk_{k}", "at_m": data["nodes_m"][d["node"]], "mass_kg": d["mass"],
            "polar_inertia_kg_m2": d["polar"], "diametral_inertia_kg_m2": d["diametral"],
        }
        for k, d in enumerate(data["disks"])
    ]  # fmt: skip
    beam = {
        "material": "case",
        "stations_m": data["nodes_m"],
        "outer_radius_m": data["outer_radius_m"],
        "disks": disks,
        "interfaces": {"first": data["nodes_m"][0], "last": data["nodes_m"][6]},
    }
    steel = {
        "density_kg_per_m3": STEEL["rho"],
        "youngs_modulus_pa": STEEL["E"],
        "poissons_ratio": STEEL["E"] / (2 * STEEL["G"]) - 1,
    }
    scene = {
        "name": "maker",
        "materials": {"case": steel},
        "beams": {"rotor": beam},
        "bearings": [
            {"name": n, "first": f"rotor.{n}", "speed_law": "table"} for n in ("first", "last")
        ],
        "speed_laws": {"table": law},
        "speeds": {"list_rpm": RPM},
    }
    return parse_scene(scene, folder / "scene.toml")


@pytest.fixture(scope="module")
def ross(run_ross):
    return run_ross(CASES)


def assert_same(found, theirs):
    """Frequency and damping of the modes at the speeds of the table."""
    for rpm, pairs in zip(RPM, theirs["modes"], strict=True):
        expected = complex_of(pairs)
        assert expected.size >= 6
        ours = found.modes(rpm).eigenvalues
        ours = ours[ours.imag > 1.0][: expected.size]
        # Seen: 7e-13.
        np.testing.assert_allclose(ours, expected, rtol=7e-11)


def test_sheet_in_pounds_and_inches_with_vertical_x(ross, tmp_path):
    columns = table_of(STIFFNESS / POUNDS_PER_INCH, DAMPING / POUNDS_PER_INCH)
    units = ["rpm", *["lb/in"] * 4, *["lb-s/in"] * 4]
    rows = [["a maker"], ["Speed", *columns], units]
    numbers = np.array([RPM, *columns.values()]).T[::-1].tolist()
    rows += [[repr(value) for value in row] for row in numbers]
    (tmp_path / "sheet.csv").write_text("\n".join(",".join(row) for row in rows))
    law = {"kind": "file", "file": "sheet.csv", "turned_deg": 90}
    assert_same(reduce_scene(scene_of(law, tmp_path)), ross["table"])


def test_film_of_ross(ross, tmp_path):
    """The command runs the film model in ROSS's environment; the scene reads what it wrote."""
    film = tmp_path / "film.toml"
    lines = [f"{key} = {value}" for key, value in FILM.items()]
    film.write_text("\n".join(['model = "CylindricalBearing"', "[arguments]", *lines]))
    words = ["bearing", "--from-ross", str(film), "--speeds", "1500:6000:1500"]
    words += ["--ross-python", str(ROOT / ".venv-ross" / "bin" / "python")]
    outputs = ["-o", str(tmp_path / "law.toml"), "--csv", str(tmp_path / "film.csv")]
    done = CliRunner().invoke(app, [*words, *outputs])
    assert done.exit_code == 0, done.output
    # what ROSS's own documentation prints of this bearing at 1500 rpm
    law = tomllib.loads((tmp_path / "law.toml").read_text())["speed_laws"]["table"]
    np.testing.assert_allclose(
        law["stiffness_n_per_m"][0], [[12807959, 16393593], [-25060393, 8815302]], rtol=1e-7
    )
    assert_same(reduce_scene(scene_of(law, tmp_path)), ross["film"])
    law = {"kind": "file", "file": "film.csv"}
    assert_same(reduce_scene(scene_of(law, tmp_path)), ross["film"])


def test_elements_that_ross_saved(ross, tmp_path):
    """A file as ROSS 2 writes it, whose `frequency` is the speed of the rotor."""
    table = CASES["table"]["shafts"][0]["bearings"][0]["table"]
    lines = [f"{key} = {value}" for key, value in {**table, "frequency": RAD_S}.items()]
    text = "\n".join(['["BearingElement_Bearing 0"]', *lines, '["BearingElement_b"]', *lines])
    (tmp_path / "rotor.toml").write_text(text)
    law = {"kind": "file", "file": "rotor.toml", "tag": "Bearing 0"}
    assert_same(reduce_scene(scene_of(law, tmp_path)), ross["table"])
