"""Matrix Market folders, read by scipy and by this program."""

from __future__ import annotations

import json

import numpy as np
import pytest
import scipy.io
from matrix_body import SPEED, body, expected

from solidwhirl.rotordyn import SuperelementError
from solidwhirl.rotordyn.exchange.matrices.matrix_market import (
    read_matrix,
    read_matrix_market,
    write_matrix_market,
)


def test_scipy_reads_all_digits(tmp_path):
    folder, element = tmp_path / "shaft", body()
    exported = write_matrix_market(element, folder, speed_rad_s=SPEED)
    document = json.loads((folder / "body.json").read_text())
    for role, matrix in expected(element).items():
        path = folder / document["matrices"][role]["name"]
        np.testing.assert_array_equal(scipy.io.mmread(path).toarray(), matrix)
    assert scipy.io.mminfo(folder / "G.mtx")[-1] == "skew-symmetric"
    assert exported.files[0] == folder / "body.json"
    assert {p.name for p in folder.iterdir()} == {p.name for p in exported.files}


def test_the_document_says_what_the_rows_are(tmp_path):
    element = body()
    write_matrix_market(element, tmp_path / "shaft")
    document = json.loads((tmp_path / "shaft" / "body.json").read_text())
    named = {n["id"]: n["name"] for n in document["nodes"]}
    motions = ("q", "ux", "uy", "uz", "rx", "ry", "rz")
    found = [(named.get(c["node"], ""), motions[c["component"]]) for c in document["coordinates"]]
    assert found == [(c.interface, c.component) for c in element.coordinates]
    assert [n["position"] for n in document["nodes"]] == [
        n.position_m.tolist() for n in element.interfaces
    ]
    assert (document["frame"], document["length_unit"], document["mass_unit"]) == (
        "inertial", "m", "kg",
    )  # fmt: skip
    assert document["maximum_speed_rad_s"] == 2000.0


@pytest.mark.parametrize("symmetry", ["general", "symmetric", "skew-symmetric"])
@pytest.mark.parametrize("sparse", [False, True])
def test_what_scipy_writes_is_read(tmp_path, symmetry, sparse):
    """scipy's writer, dense (array) and sparse (coordinate)."""
    rng = np.random.default_rng(5)
    matrix = rng.standard_normal((6, 6))
    matrix = {"symmetric": matrix + matrix.T, "skew-symmetric": matrix - matrix.T}.get(
        symmetry, matrix
    )
    path = tmp_path / "a.mtx"
    # given its ending, or scipy adds one
    content = scipy.sparse.coo_matrix(matrix) if sparse else matrix
    scipy.io.mmwrite(str(path), content, symmetry=symmetry, precision=17)
    np.testing.assert_allclose(read_matrix(path), matrix, rtol=1e-15)


HEAD = "%%MatrixMarket matrix coordinate real symmetric\n"
BAD = {
    "is no Matrix Market matrix": "hello\n",
    "field is 'complex', allowed are real": HEAD.replace("real", "complex") + "1 1 0\n",
    "symmetry is 'hermitian'": HEAD.replace("symmetric", "hermitian") + "1 1 0\n",
    # the words of scipy's reader in Python, of its compiled one
    "Matrix Market matrix: .*(not of length 3|Invalid integer)": HEAD + "2 2\n",
    "it has no line of sizes": HEAD + "% no more\n\n",
    "has 0 entries in 0 by 0": HEAD + "0 0 0\n",
    "has -1 entries in 2 by 2|NNZ can't be negative": HEAD + "2 2 -1\n",
    "has 5000000 coordinates or more": HEAD + "5000000 5000000 1\n1 1 1.0\n",
    "has 9 entries in 2 by 2": HEAD + "2 2 9\n",
    "2 by 3 is not square, but symmetric": HEAD + "2 3 1\n1 1 1.0\n",
    "is no Matrix Market matrix: .*(entries|[Tt]runcated)": HEAD + "2 2 2\n1 1 1.0\n",
    "is no Matrix Market matrix: ": HEAD + "2 2 1\n1 1\n",
    "is no Matrix Market matrix: .*": HEAD + "2 2 1\n1 1 x\n",
    "is no Matrix Market matrix: .*index": HEAD + "2 2 1\n3 1 1.0\n",
    "an entry is given twice": HEAD + "2 2 2\n1 1 1.0\n1 1 2.0\n",
    "an entry is given twi.e": HEAD + "2 2 2\n1 2 1.0\n2 1 1.0\n",
    "row 1, column 2 is inf": HEAD + "2 2 1\n2 1 inf\n",
    "has a diagonal entry": HEAD.replace("symmetric", "skew-symmetric") + "2 2 1\n1 1 1.0\n",
}


@pytest.mark.parametrize("message", BAD)
def test_damage_is_named(tmp_path, message):
    path = tmp_path / "a.mtx"
    path.write_text(BAD[message])
    with pytest.raises(SuperelementError, match=message):
        read_matrix(path)


DOCUMENT_BAD = {
    "is not valid JSON": "{",
    "format is 'None'": "{}",
    "frame: is 'rotating'": ("frame", "rotating"),
    "spin_axis: allowed is": ("spin_axis", [1, 0, 0]),
    r"nodes.position: has shape \(0,\)": ("nodes", []),
    r"nodes.id: has x at \[0\]": ("nodes", [{"id": "x"}]),
    r"nodes.position: has shape \(1, 2\)": ("nodes", [{"id": 1, "position": [1, 2]}]),
    "nodes.id: needs at most 100000 numbers, all different": (
        "nodes",
        [{"id": 1, "position": [0, 0, 0]}] * 2,
    ),
    r"coordinates.component: has 7 at \[0\]": ("coordinates", [{"node": 1, "component": 7}]),
    "coordinates.node: has 99, which is no node": ("coordinates", [{"node": 99, "component": 1}]),
    "matrices.mass: is '../M.mtx'; a file of the same folder": ("matrices", {"mass": "../M.mtx"}),
    "has 60 rows, body.json has 1 coordinates": ("coordinates", [{"node": 1, "component": 1}]),
    "matrices.mass: needs a name": ("matrices", {"mass": 3}),
    "mass: is nan; numbers are needed": ("mass", "nan"),
    "no such file": ("matrices", {"mass": "N.mtx"}),
}


@pytest.mark.parametrize("message", DOCUMENT_BAD)
def test_damaged_documents_are_named(tmp_path, message):
    folder = tmp_path / "shaft"
    write_matrix_market(body(), folder)
    path = folder / "body.json"
    bad = DOCUMENT_BAD[message]
    if isinstance(bad, tuple):
        bad = json.dumps({**json.loads(path.read_text()), bad[0]: bad[1]})
    path.write_text(bad)
    with pytest.raises(SuperelementError, match=message):
        read_matrix_market(path)
