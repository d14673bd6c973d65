"""What an imported body may not be: one message each, and nothing is run."""

from __future__ import annotations

import pickle
import re

import numpy as np
import pytest
from imported_tube import BENDING, DENSITY, ENTRY, LENGTH, MODULUS, mounts, scene_of, tube
from toml_text import toml
from typer.testing import CliRunner

from solidwhirl.cli import app
from solidwhirl.core.errors import SceneError
from solidwhirl.model.bodies import build_bodies
from solidwhirl.pipeline.run import run_scene
from solidwhirl.plausibility.units import implausible
from solidwhirl.rotordyn import (
    AnalysisError,
    SuperelementError,
    beam_superelement,
    write_superelement,
)
from solidwhirl.scene_reading.reader import read_scene


def changed(**changes):
    """The tube with entries of some matrices changed: name to (row, column, factor)."""
    arrays = tube()
    for name, (row, column, factor) in changes.items():
        arrays[name][row, column] *= factor
    return arrays


def without(*names):
    return {name: array for name, array in tube().items() if name not in names}


def massless():
    arrays = tube()
    arrays["MASS"][9] = arrays["MASS"][:, 9] = 0.0
    return arrays


def negative():
    arrays = tube()
    arrays["STIFF"][7, 7] -= 1e7
    return arrays


def moved():
    arrays = tube()
    arrays["node_position"][4, 0] += 5.0
    return arrays


def gyroscopic(matrix=None, sign=1.0, turn_of_translations=0.0):
    """Turning tube: polar inertia of the rotations about y and z of the file."""
    arrays = tube()
    tilt = np.zeros((102, 102))
    lumped = DENSITY * 2.0 * BENDING / MODULUS * LENGTH / 16
    for node in range(17):
        ry, rz = 6 * node + 4, 6 * node + 5
        weight = 0.5 if node in (0, 16) else 1.0
        tilt[ry, rz], tilt[rz, ry] = sign * weight * lumped, -sign * weight * lumped
        uy, uz = 6 * node + 1, 6 * node + 2
        tilt[uy, uz] = turn_of_translations
        tilt[uz, uy] = -turn_of_translations
    arrays["G"] = tilt
    return arrays


def uneven():
    arrays = gyroscopic()
    rows = np.sort(np.r_[np.arange(1, 102, 6), np.arange(5, 102, 6)])
    arrays["STIFF"][np.ix_(rows, rows)] *= 1.3
    return arrays


TURNS = {"speed_ratio": 1.0}
REFUSED = {
    "file: missing": (tube, {"file": None}),
    "casing.file: .*other.npz: no such file": (tube, {"file": "other.npz"}),
    r"imported.casing: file ends in '\.mat'; known are \.npz": (tube, {"file": "a.mat"}),
    "length_unit: Input should be 'm' or 'mm'": (tube, {"length_unit": "inch"}),
    "the file does not say its units; length_unit is needed, 'm' or 'mm'": (
        tube, {"length_unit": None}),
    "mass_unit is needed, 'kg' or 't'": (tube, {"mass_unit": None}),
    "interfaces: missing; the file has no names of nodes": (tube, {"interfaces": None}),
    "interfaces.front: no node 99; the file has 1, 2": (tube, {"interfaces": {"front": 99}}),
    "interfaces.front: no node 'left'; the file has no names": (
        tube, {"interfaces": {"front": "left"}}),
    "interfaces.front: a node is a whole number from 1": (tube, {"interfaces": {"front": 1.5}}),
    "'front' and 'rear' are both node 1": (tube, {"interfaces": {"front": 1, "rear": 1}}),
    "mass = 'M2' is not in the file; it has MASS, STIFF": (tube, {"mass": "M2"}),
    "has no matrix K0 or KRED; name it with stiffness": (tube, {"stiffness": None}),
    "stress_stiffening and spin_softening belong together": (tube, {"spin_softening": "STIFF"}),
    "axes: Input should be 'xyz', 'yzx' or 'zxy'": (tube, {"axes": "zyx"}),
    "nodes: casing.npz has its own nodes": (tube, {"nodes": "casing.npz"}),
    "stiffness is not symmetric: it deviates by": (
        lambda: changed(STIFF=(1, 7, 1.01)), {}),
    r"mass is not positive definite: node 2.rz has the mass 0; condense": (
        massless, {}),
    "stiffness has a negative eigenvalue": (negative, {}),
    "leaves 6 motions free, of which 4 are rigid": (moved, {}),
    "array 'dof_node' is missing": (lambda: without("dof_node"), {}),
    "imported.casing.interfaces.front: no node 1;|no node_id|which is no node": (
        lambda: {**tube(), "node_id": np.arange(2, 19)}, {}),
    r"the body turns \(speed_ratio is not 0\) and has no gyroscopic matrix": (tube, TURNS),
    "gyroscopic gives row rx, column ry of rigid tilts -": (lambda: gyroscopic(sign=-1.0), TURNS),
    "looks like the Coriolis matrix of a rotating frame": (
        lambda: gyroscopic(turn_of_translations=1e-4), TURNS),
    "is not the same in all directions about z": (uneven, TURNS),
    "gyroscopic is not skew": (lambda: {**tube(), "G": np.eye(102)}, {}),
    "unknown key; did you mean 'length_unit'": (tube, {"length_units": "mm"}),
}  # fmt: skip


def written(folder, arrays, entry):
    """A scene file with one imported body."""
    np.savez(folder / "casing.npz", **arrays)
    casing = {k: v for k, v in {**ENTRY, **entry}.items() if v is not None}
    data = {"name": "small", "speeds": {"to_rpm": 6000, "count": 2}, "bearings": mounts()}
    path = folder / "small.toml"
    path.write_text(toml({**data, "imported": {"casing": casing}}))
    return path


@pytest.mark.parametrize("message", REFUSED)
def test_one_message_and_exit_2(tmp_path, message):
    make, entry = REFUSED[message]
    path = written(tmp_path, make(), entry)
    done = CliRunner().invoke(app, ["plan", str(path)])
    assert done.exit_code == 2, done.output
    text = " ".join(done.output.split())
    assert len(text) < 1200
    assert re.search(message, text), text
    assert text.startswith(f"error: {path}") and "Traceback" not in text


def test_a_turning_tube_is_taken(tmp_path):
    """The gyroscopic matrix of the refusals above, as it should be: no generator, real form."""
    path = written(tmp_path, gyroscopic(), TURNS)
    results = run_scene(read_scene(path))
    assert results.elements["casing"].spin_generator is None
    assert not [c for c in results.checks if c.passed is False]
    frequencies = results.campbell.frequency_hz
    assert (np.abs(frequencies[:, 1] / frequencies[:, 0] - 1.0) > 1e-6).any()


def test_motions_that_joints_need(tmp_path):
    """A node with translations only can't hold a torsion spring; one message before any work."""
    arrays = tube()
    keep = np.array([k for k in range(102) if k not in (3,)])  # rx of the file, rz of the scene
    arrays["MASS"], arrays["STIFF"] = (arrays[n][np.ix_(keep, keep)] for n in ("MASS", "STIFF"))
    arrays["dof_node"], arrays["dof_component"] = (
        arrays[n][keep] for n in ("dof_node", "dof_component")
    )
    path = written(tmp_path, arrays, {})
    with pytest.raises(SuperelementError, match=r"interface 'front' has no rz, which 'front' acts"):
        run_scene(read_scene(path))


def test_an_imported_body_that_nothing_carries_is_refused(tmp_path):
    np.savez(tmp_path / "casing.npz", **tube())
    held = mounts()[:1]
    run_up = {"kind": "run_up", "ramp_s": 0.1, "to_rpm": 600.0, "mount": held[0]["name"]}
    run_up |= {"observe": [held[0]["first"]], "gravity_m_per_s2": [0.0, -9.81, 0.0]}
    asked = scene_of(ENTRY, tmp_path, body="casing", bearings=held, analyses=[run_up])
    with pytest.raises(AnalysisError, match="no bearing carries the weight of 'casing' along y"):
        run_scene(asked)


def test_keys_that_a_superelement_file_does_not_need(tmp_path):
    shaft = beam_superelement(
        "s", [0.0, 0.4], 0.02, 0.0, (2e11, 0.3, 7800.0), {"left": 0.0, "right": 0.4}
    )
    write_superelement(shaft, tmp_path / "rotor.h5")
    for entry, message in (
        ({"length_unit": "m"}, "length_unit is not for a superelement file"),
        ({"axes": "yzx"}, "axes is not for a superelement file"),
        ({"interfaces": {"a": "middle"}}, r"interfaces\.a: no 'middle'; the file has left, right"),
    ):
        with pytest.raises(SceneError, match=message):
            scene_of({"file": "rotor.h5", **entry}, tmp_path)


class Trap:
    """Unpickled, it would fail the test."""

    def __reduce__(self):
        return (pytest.fail, ("a pickle was loaded",))


def test_a_hostile_file_is_one_message(tmp_path):
    path = written(tmp_path, tube(), {})
    for content in (b"", b"PK\x03\x04", pickle.dumps(Trap())):
        (tmp_path / "casing.npz").write_bytes(content)
        done = CliRunner().invoke(app, ["plan", str(path)])
        assert done.exit_code == 2 and "casing.npz: is not an .npz file" in " ".join(
            done.output.split()
        )
    np.savez(tmp_path / "casing.npz", **{**tube(), "dof_node": np.array([Trap()], dtype=object)})
    done = CliRunner().invoke(app, ["plan", str(path)])
    assert done.exit_code == 2 and "objects are never read" in " ".join(done.output.split())


def test_units_that_are_off_are_doubted(tmp_path):
    """Millimetres taken for metres: 1200 m between the mounts."""
    np.savez(tmp_path / "casing.npz", **tube())
    entry = {**ENTRY, "length_unit": "m", "mass_unit": "kg"}
    scene = scene_of(entry, tmp_path, body="casing", bearings=mounts(stiffness=1e9))
    found = [d for d in implausible(scene, build_bodies(scene)) if d.key == "imported.casing"]
    assert len(found) == 1 and "length_unit" in found[0].mistake
    right = scene_of(ENTRY, tmp_path, body="casing", bearings=mounts())
    assert implausible(right, build_bodies(right)) == ()
