"""OUTPUT4 files, read by pyNastran or pyYeti and by this program."""

from __future__ import annotations

import json
import struct

import numpy as np
import pytest
from matrix_body import SPEED, body, expected
from nastran_reader import nastran_reader

from solidwhirl.rotordyn import SuperelementError
from solidwhirl.rotordyn.exchange.matrices.foreign_body import ROLES
from solidwhirl.rotordyn.exchange.matrices.op4 import (
    read_op4,
    read_op4_matrices,
    rows_path,
    write_op4,
)


@pytest.mark.parametrize("form", ["binary", "ascii"])
def test_another_program_reads_all_digits(tmp_path, form):
    path, element = tmp_path / "shaft.op4", body()
    exported = write_op4(element, path, speed_rad_s=SPEED, form=form)
    found = nastran_reader().op4(path)
    for role, matrix in expected(element).items():
        form, values = found[ROLES[role].short]
        square = 1 if values.shape[0] == values.shape[1] else 2
        assert form == (6 if ROLES[role].symmetry == "symmetric" else square)
        np.testing.assert_array_equal(values, matrix)
    assert exported.files == (path, tmp_path / "shaft.op4.rows.json")


def swapped(content):
    """A binary file in the other byte order: all words of 4 bytes but names, pairs for doubles."""
    out, at = [], 0
    while at < len(content):
        (size,) = struct.unpack_from("<i", content, at)
        record = content[at + 4 : at + 4 + size]
        if size == 24:
            turned = struct.pack(">4i", *struct.unpack("<4i", record[:16])) + record[16:]
        else:
            turned = struct.pack(">3i", *struct.unpack("<3i", record[:12]))
            turned += np.frombuffer(record[12:], "<f8").astype(">f8").tobytes()
        mark = struct.pack(">i", size)
        out.append(mark + turned + mark)
        at += size + 8
    return b"".join(out)


def test_the_other_byte_order(tmp_path):
    path = tmp_path / "body.op4"
    write_op4(body(), path)
    path.write_bytes(swapped(path.read_bytes()))
    np.testing.assert_array_equal(read_op4_matrices(path)["MRED"], body().mass)
    np.testing.assert_array_equal(nastran_reader().op4(path)["MRED"][1], body().mass)


def test_the_ascii_writer_of_another_program(tmp_path):
    matrix = np.array([[1.5, 0.0, -2.25], [0.0, 0.0, 0.0], [-2.25, 0.0, 1e-3]])
    path = tmp_path / "theirs.op4"
    nastran_reader().write_op4(path, {"K": (6, matrix)})
    np.testing.assert_array_equal(read_op4_matrices(path)["K"], matrix)


def head(columns=2, rows=2, form=1, kind=2, name=b"K       "):
    return record(struct.pack("<4i", columns, rows, form, kind) + name)


def record(content):
    mark = struct.pack("<i", len(content))
    return mark + content + mark


def column(number, first, values, words=None):
    words = 2 * len(values) if words is None else words
    return record(struct.pack("<3i", number, first, words) + np.array(values, "<f8").tobytes())


END = column(3, 1, [1.0])
BAD = {
    "is cut off": head() + column(1, 1, [1.0, 2.0]),
    "a record of .* bytes does not fit": head() + struct.pack("<i", 900),
    "the end of a record does not fit": head()[:-4] + b"\1\2\3\4" + END,
    r"is sparse \(BIGMAT\)": head(rows=-2) + END,
    "column 1 is sparse": head() + column(1, 0, [1.0]) + END,
    "form is 3, allowed are 1, 2 and 6": head(form=3) + END,
    r"type is 4, allowed are 1 and 2 \(real\)": head(kind=4) + END,
    "rows 2 to 3 of a matrix of 2 by 2": head() + column(1, 2, [1.0, 2.0]) + END,
    "column 1 after 1": head() + column(1, 1, [1.0]) + column(1, 1, [1.0]) + END,
    "8 words in a record": head() + column(1, 1, [1.0], words=8) + END,
    "row 1, column 1 is nan": head() + column(1, 1, [np.nan]) + END,
    "a new name of letters and digits": head(name=b"../K    ") + END,
    "has 2000000000 coordinates or more": head(columns=2_000_000_000, rows=2_000_000_000) + END,
    "neither a binary nor an ASCII": b"\x93NUMPY",
    "has no matrix": b"\n",
    "4 whole numbers of 8 columns are needed": b"hello\n",
    "no format as 1P,3E23.16": b"       2       2       6       2K       nonsense\n",
    "line 3.*could not convert": b"       1       1       6       2K       1P,3E23.16\n"
    b"       1       1       1\n  x\n       2       1       1\n 1.0\n",
}


@pytest.mark.parametrize("message", BAD)
def test_damage_is_named(tmp_path, message):
    path = tmp_path / "body.op4"
    path.write_bytes(BAD[message])
    with pytest.raises(SuperelementError, match=message) as caught:
        read_op4_matrices(path)
    assert str(path) in str(caught.value)


def test_rows_are_needed_and_must_fit(tmp_path):
    path = tmp_path / "body.op4"
    write_op4(body(), path)
    rows = rows_path(path)
    document = json.loads(rows.read_text())
    document["coordinates"].pop()
    rows.write_text(json.dumps(document))
    with pytest.raises(SuperelementError, match=r"matrix MRED has 60 rows, .* has 59 coordinates"):
        read_op4(path)
    rows.unlink()
    with pytest.raises(SuperelementError, match="does not say what its rows are"):
        read_op4(path)
    with pytest.raises(SuperelementError, match="form is 'text'"):
        write_op4(body(), path, form="text")
