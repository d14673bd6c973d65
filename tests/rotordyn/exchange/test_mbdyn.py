"""MBDyn's modal body, read back by a strict parser of the format, and its equations."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from floating_frame import floating_body, floating_frame_modes
from hypothesis import given, settings
from hypothesis import strategies as st
from mbdyn_file import fields, lumped_integrals, modal_joint, parse_fem, statements
from point_bodies import point_form, some_points
from python_exports import with_names
from springs import inertial_modes

from solidwhirl.rotordyn import SuperelementError
from solidwhirl.rotordyn.exchange.multibody.body_fixed import body_fixed_form
from solidwhirl.rotordyn.exchange.multibody.mass_points import equivalent_mass_points
from solidwhirl.rotordyn.exchange.multibody.mbdyn import fem_text, node_labels, write_mbdyn

LEVELS = (13, 18, 19)
BLOCKS = ("data", "initial value", "control data", "nodes", "elements")
_SMALL = point_form(some_points(2, count=3), stiffening=1.0, shown=1)


def written(element, folder, **options):
    """Parse what the writer wrote: body, input, report."""
    exported = write_mbdyn(element, folder / "body.fem", **options)
    assert exported.files == (folder / "body.fem", folder / "body_example.mbd")
    body, start = (file.read_text(encoding="utf-8") for file in exported.files)
    return parse_fem(body), statements(start), exported


@pytest.mark.parametrize("level", LEVELS)
def test_frequencies_of_a_body(disk_shaft, level, tmp_path):
    """Those of the inertial frame; lower levels lack the stiffening alone, and say so."""
    fem, _, exported = written(disk_shaft, tmp_path, level=level)
    told = [x for x in exported.left_out if x.startswith("Stiffening by spin is not written")]
    names = [node.name for node in disk_shaft.interfaces]
    springs = dict.fromkeys(names, (1e7, 1e7))
    wanted = inertial_modes(disk_shaft, springs, 1200.0).eigenvalues.imag
    stated = fields(fem, names)
    assert bool(told) == (level < 19) == (not stated["stress_stiffening"].any())
    if told:
        found = floating_frame_modes(floating_body(stated), springs, 1200.0).frequencies
        assert found.size != wanted.size or np.abs(found / wanted - 1.0).max() > 1e-5
        stated |= {"stress_stiffening": body_fixed_form(disk_shaft).stress_stiffening}
    found = floating_frame_modes(floating_body(stated), springs, 1200.0).frequencies
    # the inertia of points is that of the body to the rounding of a decomposition
    np.testing.assert_allclose(found, wanted, rtol=1e-8)


@pytest.mark.parametrize("level", LEVELS)
def test_numbers(level):
    """All 17 digits come back."""
    form = point_form(some_points(5), stiffening=3.0)
    fem = parse_fem(fem_text(form, level=level, modal_damping=0.01))
    k = len(form.nodes)
    assert np.array_equal(fem.places[:k], [node.position_m for node in form.nodes])
    assert np.array_equal(fem.shapes[:k, :3], [node.translations for node in form.nodes])
    assert np.array_equal(fem.shapes[:k, 3:], [node.rotations for node in form.nodes])
    points = form.points_m.shape[0]
    assert np.array_equal(fem.places[k : k + points], form.points_m)
    assert np.array_equal(fem.shapes[k : k + points, :3], form.point_modes)
    assert not fem.shapes[k:, 3:].any() and not fem.amplitudes.any() and not fem.rates.any()
    assert np.array_equal(fem.mass, form.mass) and np.array_equal(fem.stiffness, form.stiffness)
    wanted = 2.0 * 0.01 * np.sqrt(np.diag(form.stiffness))
    np.testing.assert_allclose(np.diag(fem.damping), wanted, rtol=1e-15)
    if level >= 18:
        for key in ("I3", "I4", "I5", "I8", "I9"):
            assert np.array_equal(getattr(fem, key), getattr(form, key)), key
    assert list(fem.stiffening) == ([3] if level == 19 else [])
    if level == 19:
        assert np.array_equal(fem.stiffening[3], form.stress_stiffening)


@pytest.mark.parametrize("level", LEVELS)
def test_rigid_body(disk_shaft, level, tmp_path):
    """Mass, centre of gravity and inertia are those of cylinder and disk."""
    fem, _, _ = written(disk_shaft, tmp_path, level=level)
    shaft = 7850.0 * np.pi * 0.02**2 * 0.4
    mass, centre = shaft + 5.0, (0.2 * shaft + 0.15 * 5.0) / (shaft + 5.0)
    tilt = shaft * (0.02**2 / 4 + 0.4**2 / 3) + 0.021 + 5.0 * 0.15**2
    wanted = np.diag([tilt, tilt, 0.5 * shaft * 0.02**2 + 0.04])
    found = fields(fem, [])
    assert found["mass_kg"] == pytest.approx(mass, rel=1e-12)
    np.testing.assert_allclose(found["center_of_gravity_m"], [0, 0, centre], atol=1e-12)
    np.testing.assert_allclose(found["inertia_kg_m2"], wanted, atol=1e-12 * tilt)
    if level > 13:  # group 12 has the inertia about the centre of gravity
        about = tilt - mass * centre**2
        np.testing.assert_allclose(np.diag(fem.inertia[2])[:2], about, rtol=1e-12)


@settings(max_examples=15, deadline=None)
@given(modes=st.integers(1, 12), count=st.integers(4, 9), seed=st.integers(0, 999))
def test_equivalent_points(modes, count, seed):
    """Points of equal mass that have the moments of other points, however many those were."""
    form = point_form(some_points(modes, count=count, seed=seed))
    points = equivalent_mass_points(form)
    # no more than functions, and no more than the body has points
    assert points.masses_kg.size <= min(3 * modes + 4, count)
    assert np.ptp(points.masses_kg) == 0.0
    fem = parse_fem(fem_text(form, level=13))
    found = lumped_integrals(fem)
    for key, value in found.items():
        wanted = getattr(form, key)
        np.testing.assert_allclose(value, wanted, atol=1e-10 * np.abs(wanted).max() + 1e-11)
    moving = np.einsum("p,paj,pak->jk", fem.lumped[:, 0], fem.shapes[:, :3], fem.shapes[:, :3])
    np.testing.assert_allclose(moving, form.mass, atol=1e-11)


def test_moments_of_nothing_are_refused():
    """Inertia that no masses can have needs a level without points."""
    form = replace(_SMALL, inertia_kg_m2=np.diag([1.0, 1.0, 3.0]) + _SMALL.inertia_kg_m2 * 1e-3)
    with pytest.raises(SuperelementError, match="contradict each other"):
        fem_text(form, level=13)
    parse_fem(fem_text(form, level=18))


def test_lines_and_order_of_the_manual(disk_shaft):
    """At most six values stand in a line, record groups come in order, as the manual wants."""
    form = body_fixed_form(disk_shaft)
    for level in LEVELS:
        text = fem_text(form, level=level)
        assert max(len(line.split()) for line in text.split("\n") if line[:2] != "**") <= 6
        groups = parse_fem(text).groups
        with_inertia = {13: (11,), 18: (12,), 19: (12,)}[level]
        later = tuple(range(14, level + 1))
        assert groups == (*range(1, 11), *with_inertia, 13, *later)


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("damping", [0.0, 0.01])
def test_example_input(disk_shaft, level, damping, tmp_path):
    """The input beside the file names what is in it."""
    fem, start, _ = written(disk_shaft, tmp_path, level=level, modal_damping=damping)
    block = {"set": [], **{name: [] for name in BLOCKS}}
    for name, key, words in start:
        block[name or key].append((key, words))
    assert list(dict.fromkeys(name for name, _, _ in start)) == [None, *BLOCKS]
    assert any(re.fullmatch(r"real SPIN = [1-9]\d*\.", *words) for _, words in block["set"])
    joints = [words for key, words in block["elements"] if key == "joint"]
    (joint,) = (modal_joint(words) for words in joints if words[1] == "modal")
    assert joint["file"] == "body.fem" and joint["modes"] == fem.mass.shape[0]
    assert joint["damping"] == ("damping from file" if damping else "no damping")
    assert joint["use invariant 9"] == (level == 13)
    assert [label for label, _, _ in joint["interfaces"]] == ["front", "rear"]
    nodes = {words[0]: words for key, words in block["nodes"] if key == "structural"}
    assert nodes["BODY"][1:] == ["modal", "null", "eye", "null", "0.", "0.", "SPIN"]
    for label, node, offset in joint["interfaces"]:
        kind, *place = nodes[node][1:5]
        assert kind == "static" and offset == "null"
        at = fem.labels.index(label)
        assert [float(value) for value in place] == [*fem.places[at]]
    counts = dict(block["control data"])
    assert sum(map(int, counts["structural nodes"][0].split("+")[1:])) == len(nodes)
    assert sum(map(int, counts["joints"][0].split("+")[1:])) == len(joints)
    springs = [words[7] for words in joints if words[1] == "deformable displacement joint"]
    assert springs == ["INTERFACE + 1", "INTERFACE + 2"]
    assert ("use automatic differentiation" in counts) == (level == 19)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.text(min_size=1, max_size=90), min_size=1, max_size=5, unique=True))
def test_labels(names):
    """Any names give labels that stay apart, and files that are read as meant."""
    labels = node_labels(names)
    assert len(set(labels)) == len(names)
    form = replace(_SMALL, nodes=tuple(replace(_SMALL.nodes[0], name=name) for name in names))
    assert parse_fem(fem_text(form)).labels[: len(names)] == labels


@pytest.mark.parametrize("name", ['a; "b"', "käfig # 1", "end: data;", "** END OF FILE"])
def test_names_in_the_input(disk_shaft, name, tmp_path):
    """The name of the body is in a comment and cannot leave it."""
    named = replace(disk_shaft, name=name)
    _, start, _ = written(named, tmp_path)
    assert {block for block, _, _ in start} == {None, *BLOCKS}


def test_what_is_missing_is_said(lateral_shaft, disk_shaft, tmp_path):
    """No axial motion, no torsion, truncated modes, renamed interfaces, what MBDyn must be told."""
    _, _, lateral = written(lateral_shaft, tmp_path, modes=4)
    text = " ".join(lateral.left_out)
    for words in ("rigid in axial", "rigid in torsion", "4 of 24 elastic", "automatic differentia"):
        assert words in text
    named = with_names(disk_shaft, "vorn ö")
    fem, _, exported = written(named, tmp_path)
    assert fem.labels[:2] == ("vorn_o", "rear")
    assert "The interface 'vorn ö' is written as 'vorn_o'." in exported.left_out


def test_refused(disk_shaft, tmp_path):
    """Arguments out of their range; nothing is written. Bodies: in test_body_fixed."""
    path = tmp_path / "body.fem"
    with pytest.raises(
        SuperelementError, match=r"the last record group is 12, allowed are \(13, 18, 19\)"
    ):
        write_mbdyn(disk_shaft, path, level=12)
    for name in ('a"b.fem', "a\\b.fem", "a\nb.fem", "body.mbd"):
        with pytest.raises(SuperelementError, match="cannot be called"):
            write_mbdyn(disk_shaft, tmp_path / name)
    assert not list(tmp_path.iterdir())
