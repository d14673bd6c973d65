"""DMIG and its bulk data, read by pyNastran or pyYeti and by this program."""

from __future__ import annotations

import os

import numpy as np
import pytest
from matrix_body import SPEED, body, compare, expected, tied
from nastran_reader import nastran_reader

from solidwhirl.rotordyn import SuperelementError
from solidwhirl.rotordyn.exchange.matrices.bulk_data import parsed_real, real_field
from solidwhirl.rotordyn.exchange.matrices.dmig import read_dmig, write_dmig
from solidwhirl.rotordyn.exchange.matrices.foreign_body import ROLES, rows_of

# Frequencies from 12 digits: measured 2.6e-11 at worst; the contract with users is 1e-6.
LIMIT = 1e-8


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    path = tmp_path_factory.mktemp("dmig") / "shaft.pch"
    return path, write_dmig(body(), path, speed_rad_s=SPEED)


def scattered(model, name, rows):
    """A square matrix in the order of `rows`: foreign readers drop empty rows and columns."""
    found = model.matrices[name]
    out = np.zeros((len(rows), len(rows)))
    index = {(row.node, row.component): k for k, row in enumerate(rows)}
    at = [[index[label] for label in labels] for labels in (found.rows, found.columns)]
    out[np.ix_(*at)] = found.values
    return out


def order_of(element, found):
    """Coordinates of the element in the order of what was read."""
    rows = [(r.node, r.component) for r in rows_of(element)]
    read = zip(found.nodes.tolist(), found.components.tolist(), strict=True)
    return [rows.index(row) for row in read]


def test_another_program_reads_the_body_and_its_frequencies(written):
    path, exported = written
    model = nastran_reader().bulk(path.with_suffix(".bdf"))
    element, rows = body(), rows_of(body())
    assert sorted(model.grids) == [1, 2, 3]
    for node, grid in zip(element.interfaces, (model.grids[k] for k in (1, 2, 3)), strict=True):
        np.testing.assert_allclose(grid, node.position_m, rtol=1e-13)
    assert {r.node for r in rows if r.component == 0} == model.scalar_points
    wanted = {role: m for role, m in expected(element).items() if role != "rigid_modes"}
    found = {role: scattered(model, ROLES[role].short, rows) for role in wanted}
    for role, matrix in wanted.items():
        # half of the twelfth digit, of the eleventh below 1e-10
        np.testing.assert_allclose(found[role], matrix, rtol=5.1e-12, atol=1e-20)
    compare(element, found, LIMIT)
    assert exported.files == (path, path.with_suffix(".bdf"))
    assert any("12 digits" in text for text in exported.left_out)


def test_another_program_writes_what_this_one_reads(written, tmp_path):
    """Another writer's form of the same matrices: there and back."""
    path, _ = written
    again = tmp_path / "again.bdf"
    nastran_reader().bulk_again(path.with_suffix(".bdf"), again)
    lines = again.read_text().splitlines()
    assert any(line.startswith("DMIG*") for line in lines)
    ours_read, theirs = read_dmig(path), read_dmig(again)
    assert theirs.nodes.tolist() == ours_read.nodes.tolist()
    assert theirs.components.tolist() == ours_read.components.tolist()
    for name in ("MRED", "KRED", "CCOR"):
        scale = np.abs(ours_read.matrices[name]).max()
        np.testing.assert_allclose(
            theirs.matrices[name], ours_read.matrices[name], atol=1e-9 * scale, rtol=1e-8
        )


def test_this_program_reads_it_back(written):
    path, _ = written
    element, found = body(), read_dmig(path)
    order = order_of(element, found)
    at = np.ix_(order, order)
    np.testing.assert_allclose(found.matrices["MRED"], element.mass[at], rtol=5.1e-12, atol=1e-20)
    np.testing.assert_allclose(
        found.matrices["CCOR"], element.gyroscopic[at], rtol=5.1e-12, atol=1e-20
    )
    np.testing.assert_allclose(
        found.matrices["RIGB"], element.rigid_body_modes[order], rtol=5.1e-12, atol=1e-20
    )
    assert {path, path.with_suffix(".bdf")} == set(found.files)


def test_tied_coordinates_become_scalar_points_and_mpc(tmp_path):
    element = tied()
    exported = write_dmig(element, tmp_path / "casing.pch")
    assert any("tied to 6 free motions" in text for text in exported.left_out)
    model = nastran_reader().bulk(tmp_path / "casing.bdf")
    rows = [type(rows_of(element)[0])(node=1001 + k, component=0) for k in range(6)]
    mass = scattered(model, "MRED", rows)
    # the free motions are those about the origin: mass and m z of a body at z = 0.3 m
    assert mass[0, 0] == pytest.approx(40.0, rel=1e-11)
    assert mass[0, 4] == pytest.approx(40.0 * 0.3, rel=1e-11)
    assert model.constraints == element.size
    found = read_dmig(tmp_path / "casing.pch")
    order = order_of(element, found)
    np.testing.assert_allclose(found.matrices["TIE"], element.constraint[order], atol=1e-12)
    np.testing.assert_allclose(
        found.matrices["MRED"], element.mass[np.ix_(order, order)], atol=1e-9
    )


@pytest.mark.parametrize("exponent", range(-30, 31))
def test_numbers_have_as_many_digits_as_fit(exponent):
    """At least 12 digits between 1e-10 and 1e20, 11 elsewhere; all programs read one number."""
    rng = np.random.default_rng(exponent + 100)
    digits = 12 if -10 <= exponent < 20 else 11
    for value in rng.uniform(1.0, 10.0, 25) * rng.choice([-1.0, 1.0], 25) * 10.0**exponent:
        text = real_field(float(value))
        assert len(text) == 16
        assert parsed_real(text) == pytest.approx(value, rel=0.51 * 10.0 ** (1 - digits), abs=0)
        assert nastran_reader().real(text) == pytest.approx(parsed_real(text), rel=1e-15, abs=0)


def test_numbers_that_are_none():
    for text in ("", "12", "abc", "1.0.0", ".", "1.0E", "nan", "1.0+12345", "--1.0"):
        with pytest.raises(ValueError, match="is no real number"):
            parsed_real(text)
    assert [parsed_real(t) for t in ("1.5+3", "-.2-3", "4.D-2", "12.E4", "7.0")] == [
        1500.0, -2e-4, 0.04, 120000.0, 7.0,
    ]  # fmt: skip


GOOD = """\
GRID           1              0.      0.      0.
DMIG    MRED           0       6       2       0
DMIG*   MRED                           1               1
*                      1               1 2.000000000D+00
"""
TYPE_4 = GOOD.replace("       6       2", "       6       4")
SYSTEM_5 = GOOD.replace("GRID           1        ", "GRID           1       5")
BAD = {
    "no DMIG entry": GOOD.split("DMIG")[0],
    "line 3: DMIG: row 1, 1 is given twice": GOOD + GOOD.splitlines()[3] + "\n",
    "form is 3; allowed are 1, 2, 6 and 9": GOOD.replace("       6       2", "       3       2"),
    r"type is 4; allowed are 1 and 2 \(real\)": TYPE_4,
    "line 3: DMIG: field 8: 'two' is no real number": GOOD.replace("2.000000000D+00", "two"),
    "CQUAD4: this entry is not known": GOOD + "CQUAD4         1       1       1       2\n",
    "point 1 has component 1 in a matrix, and no GRID": GOOD.split("\n", 1)[1],
    "CP is 5; the basic system": SYSTEM_5,
    "continues nothing": "*                      1               1 2.000000000D+00\n",
    "component is 7": GOOD.replace(" 1               1 2.", " 1               7 2."),
    "column of matrix MXED before its header": GOOD.replace("DMIG*   MRED", "DMIG*   MXED"),
    "begun more than once": GOOD + GOOD.splitlines()[1] + "\n",
    "point 1 occurs more than once": GOOD.splitlines()[0] + "\n" + GOOD,
    "GRID: field 2 is": None,
    "has an imaginary part": GOOD.rstrip() + " 1.000000000D+00\n",
}  # fmt: skip


@pytest.mark.parametrize("message", BAD)
def test_damage_is_named(tmp_path, message):
    path = tmp_path / "body.pch"
    text = BAD[message]
    path.write_bytes(b"GRID \xff\xfe" if text is None else text.encode())
    with pytest.raises(SuperelementError, match=message) as caught:
        read_dmig(path)
    assert str(path) in str(caught.value)


def test_includes_that_never_end_and_files_that_are_not_there(tmp_path):
    path = tmp_path / "body.bdf"
    path.write_text("INCLUDE 'body.bdf'\n")
    with pytest.raises(SuperelementError, match=r"INCLUDE names 'body\.bdf' a second time"):
        read_dmig(path)
    path.write_text("INCLUDE 'other.pch'\n")
    with pytest.raises(SuperelementError, match=r"names 'other\.pch', which does not exist"):
        read_dmig(path)
    with pytest.raises(SuperelementError, match="the matrices go to a punch file"):
        write_dmig(body(), tmp_path / "a.bdf")


@pytest.mark.parametrize("name", ["../secret", "{0}/secret", "link", "below/../../secret", "pipe"])
def test_includes_from_elsewhere_are_not_read(tmp_path, name):
    """Nor is anything of them quoted."""
    (tmp_path / "secret").write_text("PASSWORD,1,2\n")
    folder = tmp_path / "body"
    (folder / "below").mkdir(parents=True)
    (folder / "link").symlink_to(tmp_path / "secret")
    os.mkfifo(folder / "pipe")
    for own in (f"INCLUDE '{name.format(tmp_path)}'\n", "INCLUDE 'below/in.pch'\n"):
        (folder / "body.pch").write_text(own)
        inner = name if name.startswith("{") else f"../{name}"
        (folder / "below" / "in.pch").write_text(f"INCLUDE '{inner.format(tmp_path)}'\n")
        with pytest.raises(SuperelementError, match=r"line 1: INCLUDE names") as caught:
            read_dmig(folder / "body.pch")
        assert "PASSWORD" not in str(caught.value)


def test_speed_beyond_the_basis(tmp_path):
    with pytest.raises(SuperelementError, match="at most 2000 rad/s"):
        write_dmig(body(), tmp_path / "a.pch", speed_rad_s=2001.0)
    assert list(tmp_path.iterdir()) == []


def test_small_fields_commas_and_case_control_are_read(tmp_path):
    path = tmp_path / "body.bdf"
    path.write_text(
        "SOL 103\nCEND\nM2GG = MRED\nBEGIN BULK\nPARAM   POST    -1\n"
        "GRID,1,,1.5,-.2+1,3.\nSPOINT  1001    1003\n"
        "DMIG,MRED,0,6,1,0\nDMIG,MRED,1,1,,1,1,2.0\n+,1001,,.5\nENDDATA\nnonsense\n"
    )
    found = read_dmig(path)
    np.testing.assert_allclose(found.positions[1], [1.5, -2.0, 3.0])
    np.testing.assert_allclose(found.matrices["MRED"], [[2.0, 0.5], [0.5, 0.0]])
    assert found.components.tolist() == [1, 0]
