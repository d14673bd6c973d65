"""Numpy arrays of a body, read by numpy alone and by this program; hostile files."""

from __future__ import annotations

import io
import pickle
import zipfile

import numpy as np
import pytest
from matrix_body import SPEED, body, expected, tied

from solidwhirl.rotordyn import SuperelementError
from solidwhirl.rotordyn.exchange.matrices.arrays_npz import read_npz, write_npz
from solidwhirl.rotordyn.exchange.matrices.foreign_body import ROLES


def test_numpy_reads_all_digits(tmp_path):
    path, element = tmp_path / "shaft.npz", body()
    write_npz(element, path, speed_rad_s=SPEED)
    with np.load(path, allow_pickle=False) as found:
        for role, matrix in expected(element).items():
            np.testing.assert_array_equal(found[ROLES[role].name], matrix)
        places = [n.position_m for n in element.interfaces]
        np.testing.assert_array_equal(found["node_position"], places)
        assert str(found["length_unit"]) == "m" and str(found["mass_unit"]) == "kg"
        motions = ("q", "ux", "uy", "uz", "rx", "ry", "rz")
        assert [motions[k] for k in found["dof_component"]] == [
            c.component for c in element.coordinates
        ]


def plain(**changes):
    """Arrays of a small body with some changed; None leaves one out."""
    arrays = {
        "M": np.eye(2),
        "K0": np.eye(2),
        "dof_node": np.array([1, 1]),
        "dof_component": np.array([1, 2]),
        "node_id": np.array([1]),
        "node_position": np.zeros((1, 3)),
    }
    return {name: array for name, array in (arrays | changes).items() if array is not None}


def test_a_small_body_as_docs_say(tmp_path):
    np.savez(tmp_path / "a.npz", **plain(K0=np.asfortranarray([[2.0, 1.0], [0.5, 3.0]])))
    found = read_npz(tmp_path / "a.npz")
    np.testing.assert_array_equal(found.matrices["K0"], [[2.0, 1.0], [0.5, 3.0]])
    assert found.length_unit is None and found.names == {}


WRONG = {
    r"array 'M'\[0, 0\] is nan; all numbers must be finite": {"M": np.full((2, 2), np.nan)},
    "array 'dof_component' is no list of the length 2": {"dof_component": np.ones(3, int)},
    r"array 'dof_component' has 9 at \[1\]; whole numbers from 0 to 6": {
        "dof_component": np.array([1, 9])
    },
    "array 'node_id' is missing": {"node_id": None},
    "array 'node_id' needs": {"node_id": np.array([1, 1]), "node_position": np.zeros((2, 3))},
    "'dof_node' has 7, which is no node": {"dof_node": np.array([1, 7])},
    "whole numbers from 0 to 1000000000000 are allowed": {"dof_node": np.array([1.0, 1.5])},
    "holds complex128": {"M": np.eye(2, dtype=complex)},
    "has 3000 coordinates": {"dof_node": np.ones(3000, int)},
    "'frame' is 'rotating'": {"frame": np.array("rotating")},
    "'maximum_speed_rad_s' is nan": {"maximum_speed_rad_s": np.array(np.nan)},
    "'node_name' has '3', which is no name": {"node_name": np.array([3])},
    "'node_name' has 'a.*b', which is no name": {"node_name": np.array(["a\nb"])},
}


@pytest.mark.parametrize("message", WRONG)
def test_wrong_arrays_are_named(tmp_path, message):
    path = tmp_path / "a.npz"
    np.savez(path, **plain(**WRONG[message]))
    with pytest.raises(SuperelementError, match=message) as caught:
        read_npz(path)
    assert str(path) in str(caught.value)


class Trap:
    """Unpickled, it would leave a trace."""

    def __reduce__(self):
        return (pytest.fail, ("a pickle was loaded",))


def archive(members):
    """Bytes of a zip archive."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as made:
        for name, data in members:
            made.writestr(name, data)
    return content.getvalue()


def header(text, data=b""):
    """An array file with a header of one's own."""
    body_text = text.encode().ljust(118) + b"\n"
    return b"\x93NUMPY\x01\x00" + len(body_text).to_bytes(2, "little") + body_text + data


def array(value):
    content = io.BytesIO()
    np.save(content, value)
    return content.getvalue()


def of_objects():
    content = io.BytesIO()
    np.save(content, np.array([Trap()], dtype=object), allow_pickle=True)
    return content.getvalue()


GOOD = [(f"{name}.npy", array(value)) for name, value in plain().items()]
HUGE = "{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000, 2), }"
HOSTILE = {
    "is not an .npz file": b"PK nonsense",
    "is not an .npz": b"",
    "objects are never read": archive([("dof_node.npy", of_objects()), *GOOD[3:]]),
    "which is too large": archive([("dof_node.npy", header(HUGE)), *GOOD[3:]]),
    "occurs twice": archive([*GOOD, ("M", array(np.eye(2)))]),
    "holds 300 arrays": archive([(f"a{k}.npy", b"") for k in range(300)]),
    "is damaged": archive([("dof_node.npy", b"\x93NUMPY\x01\x00\xff\xff{"), *GOOD[3:]]),
    "array 'dof_node' is missing": archive(GOOD[:2]),
    "expected 16 bytes got 8": archive(
        [
            (
                "dof_node.npy",
                header("{'descr': '<i8', 'fortran_order': False, 'shape': (2,), }", b"\1" * 8),
            )
        ]
    ),
    "is damaged: ": archive([("dof_node.npy", pickle.dumps(Trap()))]),
}


@pytest.mark.filterwarnings("ignore:Duplicate name:UserWarning")
@pytest.mark.parametrize("message", HOSTILE)
def test_hostile_files_are_refused(tmp_path, message):
    path = tmp_path / "a.npz"
    path.write_bytes(HOSTILE[message])
    with pytest.raises(SuperelementError, match=message):
        read_npz(path)


def test_a_bomb_is_refused(tmp_path):
    """A directory that declares far more than deflate can hold."""
    path = tmp_path / "a.npz"
    content = bytearray(archive([("dof_node.npy", b"x" * 100)]))
    at = content.rindex(b"PK\x01\x02")
    content[at + 24 : at + 28] = (4_000_000_000).to_bytes(4, "little")
    path.write_bytes(content)
    with pytest.raises(SuperelementError, match="refused as a bomb"):
        read_npz(path)


@pytest.mark.parametrize("seed", range(20))
def test_changed_bytes_never_crash_the_reader(tmp_path, seed):
    path = tmp_path / "a.npz"
    write_npz(tied(), path)
    rng = np.random.default_rng(seed)
    content = np.frombuffer(path.read_bytes(), np.uint8).copy()
    at = rng.integers(0, content.size, 3)
    content[at] = rng.integers(0, 256, 3)
    path.write_bytes(content.tobytes())
    try:
        read_npz(path)  # bytes that nothing depends on
    except SuperelementError as error:
        assert str(path) in str(error)
