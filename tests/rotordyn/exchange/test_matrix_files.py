"""Files of plain matrices that keep all digits, read back by this program."""

from __future__ import annotations

import numpy as np
import pytest
from matrix_body import body, tied

from solidwhirl.rotordyn.exchange.matrices.arrays_npz import read_npz, write_npz
from solidwhirl.rotordyn.exchange.matrices.foreign_body import ROLES, matrix_set, rows_of
from solidwhirl.rotordyn.exchange.matrices.matrix_market import (
    read_matrix_market,
    write_matrix_market,
)
from solidwhirl.rotordyn.exchange.matrices.op4 import read_op4, write_op4

FORMATS = {
    "npz": (write_npz, read_npz, {}),
    "op4": (write_op4, read_op4, {"form": "binary"}),
    "op4 in ascii": (write_op4, read_op4, {"form": "ascii"}),
    "matrix-market": (write_matrix_market, read_matrix_market, {}),
}


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("make", [body, tied])
def test_this_program_reads_it_back_bit_for_bit(tmp_path, form, make):
    write, read, options = FORMATS[form]
    path, element = tmp_path / f"body.{form[:3]}", make()
    write(element, path, **options)
    found = read(path)
    for role, matrix in matrix_set(element, None).matrices.items():
        name = ROLES[role].short if "op4" in form else ROLES[role].name
        np.testing.assert_array_equal(found.matrices[name], matrix)
    rows = [(r.node if r.component else 0, r.component) for r in rows_of(element)]
    assert list(zip(found.nodes, found.components, strict=True)) == rows
    assert found.names == {k + 1: n.name for k, n in enumerate(element.interfaces)}
    assert (found.length_unit, found.mass_unit) == ("m", "kg")
    assert float(found.properties["mass"]) == element.mass_kg
    assert found.maximum_speed_rad_s == element.maximum_speed_rad_s
    if form == "npz":
        np.testing.assert_array_equal(found.points, element.recovery_points_m)
        np.testing.assert_array_equal(found.point_modes, element.recovery_modes)
