"""Superelement files: bit-exact round trip, and refusal of everything that is not in order."""

from __future__ import annotations

import dataclasses
import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest

from solidwhirl.rotordyn import (
    Bearing,
    End,
    Rotor,
    Superelement,
    SuperelementError,
    assemble,
    attach_rigid_disk,
    modes_at_speed,
    read_superelement,
    rigid_superelement,
    write_superelement,
)
from solidwhirl.rotordyn.storage.files import write_superelement_again
from solidwhirl.rotordyn.storage.sandbox import is_sealed
from solidwhirl.rotordyn.storage.sidecar import superelement_document
from solidwhirl.rotordyn.superelement.surface import Copies, Surface


@pytest.fixture(scope="module")
def element(twin_bodies):
    body = attach_rigid_disk(twin_bodies()[0], "B", "hub", 3.0, 0.02, 0.01, 0.03)
    rng = np.random.default_rng(3)
    noise = rng.standard_normal((body.size, body.size))
    return dataclasses.replace(
        body,
        name="Läufer 1/2 – Ω",
        level="harmonic",
        harmonics=(1, 2),
        stress_stiffening=noise + noise.T,
        spin_softening=noise @ noise.T,
        maximum_speed_rad_s=1234.5,
        frequency_error_estimate=1e-4 * np.ones(body.fixed_interface_frequencies_hz.size),
        provenance={"mesh": {"order": 2, "note": "Kσ"}, "list": [1, 2.5, None, True]},
        surface=Surface(
            points_m=np.array([[0.1, 0.5], [0.2, 0.5]]),
            cells=np.array([[0, 1]]),
            amplitudes=np.arange(12.0).reshape(2, 3, 2),
            coordinate=np.array([0, 1]),
            order=np.array([1, 3]),
            family=np.array([0, 1]),
            size=body.size,
        ),
    )


@pytest.fixture(scope="module")
def written(element, tmp_path_factory):
    path = tmp_path_factory.mktemp("files") / "body.h5"
    write_superelement(element, path)
    return path


@pytest.fixture
def copy(written, tmp_path):
    """As from elsewhere: without the checksum, which would refuse every change."""
    path = shutil.copy(written, tmp_path / "copy.h5")
    with path.open("r+b") as file:
        file.write(bytes(512))
    return path


def _assert_same_parts(first, second):
    for part in dataclasses.fields(first):
        a, b = (getattr(side, part.name) for side in (first, second))
        same = a.tobytes() == b.tobytes() if isinstance(a, np.ndarray) else a == b
        assert same, part.name


def _assert_same(first: Superelement, second: Superelement):
    for field in dataclasses.fields(Superelement):
        left, right = getattr(first, field.name), getattr(second, field.name)
        if isinstance(left, np.ndarray):
            assert left.dtype == right.dtype and left.tobytes() == right.tobytes(), field.name
        elif field.name == "interfaces":
            for a, b in zip(left, right, strict=True):
                assert (a.name, a.coupling) == (b.name, b.coupling)
                assert a.position_m.tobytes() == b.position_m.tobytes()
        elif field.name == "error_forms":
            for a, b in zip(left, right, strict=True):
                _assert_same_parts(a, b)
        elif field.name in ("moments", "surface") and left is not None:
            _assert_same_parts(left, right)
        else:
            assert left == right, field.name


def test_round_trip_is_bit_exact(element, written):
    _assert_same(read_superelement(written), element)


def test_round_trip_of_rigid_bodies_and_of_those_without_points(general, hub, tmp_path):
    modal = general(np.eye(6), np.eye(6), np.zeros((6, 6)))
    long = dataclasses.replace(hub(), provenance={"nodes": list(range(30_000))})
    tied = rigid_superelement("drum", 2.0, [0, 0, 0.1], [1, 1, 1.5], {"a": 0.0, "b": 0.5})
    for index, body in enumerate((hub(), modal, long, tied)):
        path = tmp_path / f"{index}.h5"
        write_superelement(body, str(path))
        _assert_same(read_superelement(str(path)), body)


@pytest.fixture(scope="module")
def sector(element):
    """The surface of half a sector of seven, in the coordinates 0 and 1."""
    rng = np.random.default_rng(8)
    field = rng.standard_normal((3, 3, 2)) + 1j * rng.standard_normal((3, 3, 2))
    return dataclasses.replace(
        element,
        level="solid",
        harmonics=(0, 1),
        cyclic_sectors=7,
        surface=Surface(
            points_m=rng.standard_normal((3, 3)),
            cells=np.array([[0, 1, 2]]),
            amplitudes=field,
            coordinate=np.array([0, 1]),
            order=np.array([1, 1]),
            family=np.array([0, 1]),
            size=element.size,
            copies=Copies(count=7, mirrored=True, angle_rad=0.3),
        ),
    )


def test_round_trip_of_a_sector(sector, tmp_path):
    path = tmp_path / "sector.h5"
    write_superelement(sector, path)
    found = read_superelement(path)
    _assert_same(found, sector)
    assert (found.cyclic_sectors, found.harmonics) == (7, (0, 1))
    assert superelement_document(found)["cyclic_sectors"] == 7
    with h5py.File(path) as file:  # readers of 1.3 know two kinds of surface
        assert "surface" not in file and file["sector_surface"].attrs["kind"] == "sector"


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (lambda f: f.attrs.__setitem__("cyclic_sectors", 2), "cyclic_sectors is 2, allowed"),
        (lambda f: f.attrs.__setitem__("cyclic_sectors", 7.5), "'cyclic_sectors' is 7.5"),
        (lambda f: f.attrs.__setitem__("cyclic_sectors", -7), "'cyclic_sectors' is -7"),
        (lambda f: f.attrs.__delitem__("cyclic_sectors"), "one of 7 sectors"),
        (lambda f: f["sector_surface"].attrs.__setitem__("copies", 8), "one of 8 sectors"),
        (lambda f: f["sector_surface"].attrs.__setitem__("copies", "all"), "'copies' is 'all'"),
        (lambda f: f["sector_surface"].attrs.__delitem__("angle"), "angle None; a number is"),
        (
            lambda f: f["sector_surface"].attrs.__setitem__("angle", np.nan),
            "angle of copies is nan",
        ),
        (lambda f: f["sector_surface"].attrs.__setitem__("kind", "solid"), "is of kind 'solid'"),
        (lambda f: f.__delitem__("sector_surface/amplitudes_imaginary"), "is missing"),
    ],
)
def test_damaged_sectors_are_refused(sector, tmp_path, damage, words):
    path = tmp_path / "sector.h5"
    write_superelement(sector, path)
    with path.open("r+b") as file:
        file.write(bytes(512))
    with h5py.File(path, "r+") as file:
        damage(file)
    with pytest.raises(SuperelementError, match=words):
        read_superelement(path)


def test_files_of_1_3_have_no_sectors(element, written, copy):
    """Such a file: no `cyclic_sectors`, another version, a surface of another kind."""
    with h5py.File(copy, "r+") as file:
        assert "cyclic_sectors" not in file.attrs
        file.attrs["format_version"] = "1.3.0"
    _assert_same(read_superelement(copy), element)


def test_a_solid_that_the_program_of_1_3_wrote(tmp_path):
    """A steel tube, 0.04 m long, of a mesh of the whole; Hz as its own run told."""
    old = read_superelement(Path(__file__).parent / "solid_1_3.h5")
    assert (old.level, old.harmonics, old.cyclic_sectors) == ("solid", (), None)
    # of the mesh, whose curved faces are of second order
    assert old.mass_kg == pytest.approx(7800 * np.pi * (0.03**2 - 0.01**2) * 0.04, rel=1e-4)
    assert old.surface.kind == "solid"
    assert old.surface.copies is None
    springs = tuple(
        Bearing(name=n, first=End(body="tube", interface=n), stiffness_n_per_m=1e8 * np.eye(2))
        for n in ("a", "b")
    )
    system = assemble({"tube": Rotor(element=old, speed_ratio=1.0)}, springs)
    for rpm, told in (
        (0.0, [2534.4767094416943, 2534.476709441693, 2586.401326819753]),
        (30000.0, [2278.6203925024042, 2534.4755103935527, 2534.4784815032112]),
    ):
        modes = modes_at_speed(system, rpm * np.pi / 30.0, 3)
        np.testing.assert_allclose(modes.frequency_hz[:3], told, rtol=1e-9)
    write_superelement(old, tmp_path / "new.h5")
    _assert_same(read_superelement(tmp_path / "new.h5"), old)


def test_writing_replaces_and_leaves_nothing_behind(hub, tmp_path):
    path = tmp_path / "body.h5"
    path.write_bytes(b"old")
    write_superelement(hub(), path)
    assert read_superelement(path).name == "disk"
    assert [p.name for p in tmp_path.iterdir()] == ["body.h5"]


def test_failed_writing_keeps_the_old_file(hub, tmp_path, monkeypatch):
    path = tmp_path / "body.h5"
    path.write_bytes(b"old")

    def fail(*_):
        raise OSError("disk full")

    monkeypatch.setattr("solidwhirl.rotordyn.storage.files._write_body", fail)
    with pytest.raises(OSError, match="disk full"):
        write_superelement(hub(), path)
    assert path.read_bytes() == b"old"
    assert [p.name for p in tmp_path.iterdir()] == ["body.h5"]


def test_datasets_do_not_vary_between_runs(element, written, tmp_path):
    again = tmp_path / "again.h5"
    write_superelement(element, again)

    def content(path):
        found = {}
        with h5py.File(path) as file:

            def visit(name, item):
                if isinstance(item, h5py.Dataset):
                    found[name] = item[()].tobytes() if item.dtype != object else list(item[()])

            file.visititems(visit)
        return found

    assert content(again) == content(written)


@pytest.mark.parametrize("old, new", [({"a": 1}, {}), ({}, {"nodes": list(range(30_000))})])
def test_a_file_of_another_origin_is_written_again(element, tmp_path, old, new):
    """The same numbers bit for bit, the provenance of the new one, and a seal that fits."""
    first, again = tmp_path / "first.h5", tmp_path / "again.h5"
    write_superelement(dataclasses.replace(element, provenance=old), first)
    other = dataclasses.replace(element, provenance=new)
    write_superelement_again(first.read_bytes(), other, again)
    assert is_sealed(again)
    _assert_same(read_superelement(again), other)


def test_layout_follows_the_published_schema(element, written):
    with h5py.File(written) as file:
        assert file.attrs["format"] == "ROTOR-SUPERELEMENT"
        assert file.attrs["frame"] == "inertial"
        assert file.attrs["created_utc"].endswith("Z")
        operators = file["operators"]
        kspin = operators["Kspin"]
        assert (kspin.attrs["acts_on"], kspin.attrs["omega_power"]) == ("q", 2)
        np.testing.assert_array_equal(kspin[()], -element.spin_softening)
        euler = operators["Keul"]
        assert (euler.attrs["acts_on"], euler.attrs["omega_dot_power"]) == ("q", 1)
        np.testing.assert_array_equal(euler[()], 0.5 * element.gyroscopic)
        # The generic rule of the format: A(Ω) = Σ term Ω^power, grouped by what it acts on.
        stiffness = sum(
            item[()] * 300.0 ** item.attrs["omega_power"]
            for item in operators.values()
            if item.attrs["acts_on"] == "q" and item.attrs["omega_dot_power"] == 0
        )
        expected = element.stiffness + 300.0**2 * (
            element.stress_stiffening - element.spin_softening
        )
        np.testing.assert_allclose(stiffness, expected, rtol=1e-12)
        moment = file["body/J_origin"][()] - file["body/J_com"][()]
        arm = element.center_of_gravity_m
        np.testing.assert_allclose(
            moment, element.mass_kg * (arm @ arm * np.eye(3) - np.outer(arm, arm)), atol=1e-12
        )


# Refusal. Each damage is made to a good file; the message names the file and the place.


def _replace(place, data, **options):
    def damage(file):
        attributes = dict(file[place].attrs)
        del file[place]
        file.create_dataset(place, data=data, **options).attrs.update(attributes)

    return damage


def _edit(place, index, value):
    def damage(file):
        file[place][index] = value

    return damage


def _attribute(name, value, place="/"):
    def damage(file):
        file[place].attrs[name] = value

    return damage


def _delete(place):
    def damage(file):
        del file[place]

    return damage


def _soft_link(file):
    file.move("operators", "elsewhere")
    file["operators"] = h5py.SoftLink("/elsewhere")


def _damping(file):
    n = file["operators/M"].shape[0]
    file.create_dataset("operators/D0", data=np.eye(n))


DAMAGES = {
    "other format": (_attribute("format", "MODES"), "attribute 'format' is 'MODES'"),
    "newer major version": (
        _attribute("format_version", "2.0.0"),
        "is '2.0.0'; this program reads",
    ),
    "odd version": (_attribute("format_version", "one"), "is 'one'; this program reads 1.x.y"),
    "no version": (lambda f: f.attrs.__delitem__("format_version"), "'format_version' is None"),
    "other units": (_attribute("unit_system", "mm-t-s"), "attribute 'unit_system' is 'mm-t-s'"),
    "millimetres": (_attribute("units", '{"length": "mm"}'), "attribute 'units' is"),
    "broken units": (_attribute("units", "{"), "attribute 'units' is not JSON"),
    "other frame": (_attribute("frame", "tilted"), "frame is 'tilted'"),
    "rotating frame": (_attribute("frame", "rotating"), "frame is 'rotating' and spin_generator"),
    "other axis": (_attribute("spin_axis", [1.0, 0.0, 0.0]), "attribute 'spin_axis' is"),
    "bad level": (_attribute("level", "shell"), "level is 'shell'"),
    "bad harmonics": (_attribute("harmonics", "one"), "'harmonics' is not a list of integers"),
    "missing operator": (_delete("operators/G"), "operators/G is missing"),
    "missing group": (_delete("operators"), "operators/M is missing"),
    "missing mass": (_delete("body/mass"), "body/mass is missing"),
    "group for dataset": (
        lambda f: (_delete("body/com")(f), f.create_group("body/com")),
        "body/com is not a dataset",
    ),
    "wrong shape": (_replace("operators/K0", np.eye(3)), r"operators/K0 has shape \(3, 3\)"),
    "wrong length": (_replace("dof/kind", np.zeros(2)), r"dof/kind has shape \(2,\)"),
    "no coordinates": (_replace("dof/component", np.zeros(0)), "has 0 entries"),
    "scalar for list": (_replace("dof/component", 1.0), r"dof/component has shape \(\)"),
    "nan": (_edit("operators/G", (0, 1), np.nan), r"operators/G has nan at \[0, 1\]"),
    "inf": (_edit("body/com", 2, np.inf), r"body/com has inf at \[2\]"),
    "not symmetric": (_edit("operators/M", (0, 1), 1e9), "mass is not symmetric"),
    "text for numbers": (
        _replace("body/com", ["a", "b", "c"], dtype=h5py.string_dtype()),
        "body/com has type object; numbers are needed",
    ),
    "numbers for text": (_replace("interface/name", np.zeros(3)), "3 texts needed"),
    "bad coupling": (
        _replace("interface/coupling", ["x"] * 3, dtype=h5py.string_dtype()),
        "interface/coupling is 'x'",
    ),
    "bad component": (_edit("dof/component", 0, 9), "component 9"),
    "bad kind": (_edit("dof/kind", 0, 4), "kind 4"),
    "bad node": (_edit("dof/node", 0, 77), "node 77"),
    "nodes of one number": (_edit("interface/node", slice(None), 1), "has a number more than once"),
    "coordinate twice": (_edit("dof/component", 0, 2), "occurs more than once"),
    "modal first": (_edit("dof/kind", 0, 1), "interface coordinates come first"),
    "impossible inertia": (_edit("body/J_com", (2, 2), 1e9), "none above the sum of the others"),
    "odd unit texts": (_attribute("units", "[" * 50_000), "attribute 'units' is not JSON"),
    "other meaning": (
        _attribute("omega_power", np.int32(1), "operators/Kgeo"),
        "operators/Kgeo has omega_power 1, needed is 2",
    ),
    "no meaning": (
        lambda f: f["operators/K0"].attrs.__delitem__("acts_on"),
        "operators/K0 has acts_on None",
    ),
    "damping": (_damping, "operators/D0 is a term this program does not evaluate"),
    "soft link": (_soft_link, "operators is a link"),
    "broken provenance": (_attribute("json", "[1", "provenance"), "provenance is not JSON"),
    "list for provenance": (_attribute("json", "[1]", "provenance"), "not a JSON object"),
    "lacking moments": (_delete("moments/first"), "moments/first is missing"),
    "moments of another size": (
        _replace("moments/displacement", np.zeros((3, 2))),
        r"moments/displacement has shape \(3, 2\)",
    ),
    "moments that are no fields": (
        _edit("moments/second", (0, 0, 1), 1e9),
        "mass moments: second_kg.* differs from",
    ),
    "nan in moments": (_edit("moments/second", (3, 0, 1), np.nan), "moments/second has nan"),
    "dataset for moments": (
        lambda f: (_delete("moments")(f), f.create_dataset("moments", data=1.0)),
        "moments is not a group",
    ),
    "surface of no kind": (_attribute("kind", "cloud", "surface"), "kind 'cloud'"),
    "no kind of surface": (lambda f: f["surface"].attrs.__delitem__("kind"), "kind None"),
    "no points": (_delete("surface/points"), "surface/points is missing"),
    "no families": (_delete("surface/family"), "surface/family is missing"),
    "odd points": (_replace("surface/points", np.zeros((4, 3))), "surface/points has shape"),
    "odd order": (_replace("surface/order", np.array([-1.0, 1.0])), "surface/order"),
    "odd cells": (_replace("surface/cells", np.full((1, 2), 10**9)), "cells"),
    "linked surface": (
        lambda f: (
            _delete("surface/coordinate")(f),
            f.__setitem__("surface/coordinate", h5py.SoftLink("/dof/node")),
        ),
        "links are not followed",
    ),
    "negative mass": (_replace("body/mass", -1.0), "mass_kg is -1.0"),
}


@pytest.mark.parametrize("case", DAMAGES)
def test_damage_is_refused_with_file_and_place(copy, case):
    damage, message = DAMAGES[case]
    with h5py.File(copy, "r+") as file:
        damage(file)
    with pytest.raises(SuperelementError, match=message) as caught:
        read_superelement(copy)
    assert str(caught.value).startswith(f"{copy}: ")
    assert str(caught.value).count(str(copy)) == 1


def test_older_files_have_no_moments(element, copy):
    with h5py.File(copy, "r+") as file:
        assert file["moments/second"].shape == (6, element.size, element.size)
        del file["moments"]
        file.attrs["format_version"] = "1.2.0"
    assert element.moments is not None
    assert read_superelement(copy).moments is None


def test_files_that_are_not_complete_are_refused(copy, tmp_path):
    content = copy.read_bytes()
    for kept in (0, 100, len(content) // 2, len(content) - 1):
        copy.write_bytes(content[:kept])
        with pytest.raises(SuperelementError, match="not a complete HDF5 file"):
            read_superelement(copy)
    with pytest.raises(SuperelementError, match="no such file"):
        read_superelement(tmp_path / "nothing.h5")
    text = tmp_path / "text.h5"
    text.write_text("M = 1")
    with pytest.raises(SuperelementError, match="not a complete HDF5 file"):
        read_superelement(text)


def test_every_change_of_a_sealed_file_is_found(written, tmp_path):
    """Numbers without a checksum of their own, attributes and unused bytes too."""
    copy = tmp_path / "copy.h5"
    content = written.read_bytes()
    for at in range(100, len(content), len(content) // 40):
        copy.write_bytes(content[:at] + bytes([content[at] ^ 4]) + content[at + 1 :])
        with pytest.raises(SuperelementError, match="do not fit the checksum"):
            read_superelement(copy)
    for kept in (512, len(content) - 1):
        copy.write_bytes(content[:kept])
        with pytest.raises(SuperelementError, match="do not fit the checksum"):
            read_superelement(copy)


def test_a_flipped_bit_in_a_matrix_is_found(copy):
    with h5py.File(copy) as file:
        chunk = file["operators/M"].id.get_chunk_info(0)
    content = bytearray(copy.read_bytes())
    content[chunk.byte_offset + chunk.size // 2] ^= 0x10
    copy.write_bytes(content)
    with pytest.raises(SuperelementError, match="operators/M cannot be read"):
        read_superelement(copy)


def test_later_minor_versions_and_unknown_parts_are_read(element, copy):
    n = element.size
    with h5py.File(copy, "r+") as file:
        file.attrs["format_version"] = "1.7.3"
        file.attrs["colour"] = "blue"
        file.create_group("thermal").create_dataset("field", data=np.arange(5))
        file["operators"].create_dataset("Kmagnetic", data=np.eye(n))
        # Internal damping that is zero says nothing new.
        file["operators"].create_dataset("D0", data=np.zeros((n, n)))
    _assert_same(read_superelement(copy), element)
