"""Error forms: what they are refused for, what they mean, and their place in bodies and files."""

from __future__ import annotations

import dataclasses
import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.linalg as la
from rotors import ground, one_rotor, truncated, truncation_basis

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.estimates.eigenvalue_errors import frequency_errors
from solidwhirl.rotordyn.run_up.complexity import as_rigid_body, without_modes
from solidwhirl.rotordyn.storage.format import FORMAT_VERSION
from solidwhirl.rotordyn.superelement.record import ErrorForm
from solidwhirl.rotordyn.superelement.residual_energy import (
    form_products,
    form_projection,
    form_weight,
)

RNG = np.random.default_rng(11)
FORM = {
    "part": "mesh", "gram": np.eye(8), "stiffness_change": None, "safety": 1.0,
    "cutoff_rad_s": np.inf,
}  # fmt: skip


def form_matrix(form, rate, spin_rad_s):
    """E(s, Ω) − Ω² ΔK2 of a body, (n, n), without safety: residuals of K, s²M, sΩG and Ω²K2."""
    n = form.size
    right = np.array([1.0, rate**2, rate * spin_rad_s, spin_rad_s**2])
    left = right * [1.0, 1.0, -1.0, 1.0]
    change = np.einsum("a,aibj,b->ij", left, form.gram.reshape(4, n, 4, n), right)
    none = form.stiffness_change is None
    return change if none else change - spin_rad_s**2 * form.stiffness_change


@pytest.fixture(scope="module")
def body(full):
    """Truncated body with the forms of two parts, the second with a change of stiffness."""
    cut = truncated(full, 8, safety=1.5, cutoff=3e4)
    root = RNG.standard_normal((6, 4 * cut.size))
    change = RNG.standard_normal((cut.size, cut.size))
    mesh = ErrorForm(**{**FORM, "gram": root.T @ root, "stiffness_change": change + change.T})
    return dataclasses.replace(cut, error_forms=(*cut.error_forms, mesh))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"part": "weather"}, "part is 'weather'"),
        ({"gram": np.eye(6)}, r"gram has shape \(6, 6\)"),
        ({"gram": np.ones((4, 8))}, r"gram has shape \(4, 8\)"),
        ({"gram": np.zeros((0, 0))}, r"gram has shape \(0, 0\)"),
        ({"gram": np.diag([np.nan] * 4)}, "gram.* must be finite"),
        ({"gram": np.triu(np.ones((8, 8)))}, "gram is not symmetric"),
        ({"stiffness_change": np.eye(3)}, "stiffness_change has shape"),
        ({"stiffness_change": np.triu(np.ones((2, 2)))}, "stiffness_change is not symmetric"),
        ({"safety": 0.9}, "safety is 0.9"),
        ({"safety": np.inf}, "safety is inf"),
        ({"cutoff_rad_s": 0.0}, "cutoff_rad_s is 0.0"),
        ({"cutoff_rad_s": np.nan}, "cutoff_rad_s is nan"),
    ],
)
def test_bad_forms_are_refused_by_name(change, message):
    with pytest.raises(rd.SuperelementError, match=message):
        ErrorForm(**{**FORM, **change})


def test_forms_must_fit_their_body(body):
    small = ErrorForm(**FORM)
    form = body.error_forms[0]
    for forms, message in (
        ((small,), "of 2 coordinates, allowed are"),
        ((form, form), "more than once"),
        (("x",), "a str"),
    ):
        with pytest.raises(rd.SuperelementError, match=message):
            dataclasses.replace(body, error_forms=forms)


@pytest.mark.parametrize("slack", [0.0, 0.02])
@pytest.mark.parametrize("rate", [900j, -40 + 900j, 25.0])
def test_form_is_the_schur_complement_with_elastic_metric(full, rate, slack):
    """D_vw(s) K_ww⁻¹ D_wv(s) from the matrices of the whole body, both blocks taken from it."""
    spin = -700.0
    cut = truncated(full, 8, slack=slack)
    few, turn = cut.size, truncation_basis(full, 8, slack)
    dynamic = full.stiffness + rate**2 * full.mass + rate * spin * full.gyroscopic
    dynamic = dynamic + spin**2 * (full.stress_stiffening - full.spin_softening)
    dynamic = turn.T @ dynamic @ turn
    inner = la.solve(full.stiffness[few:, few:], dynamic[few:, :few])
    found = form_matrix(cut.error_forms[0], rate, spin)
    exact = dynamic[:few, few:] @ inner
    # the largest terms of E cancel where the static shapes are wrong: digits of the largest entry
    assert np.abs(found - exact).max() < 1e-8 * np.abs(exact).max()


def test_products_and_projection_are_those_of_the_matrix(body):
    form = body.error_forms[0]
    rates, spin = np.array([300j, -5 + 800j, 40.0]), 321.0
    x, y = (RNG.standard_normal((2, body.size, 3)) @ np.diag([1, 2, 3])).astype(complex)
    y = y + 0.5j * x
    products = [y[:, k] @ form_matrix(form, s, spin) @ x[:, k] for k, s in enumerate(rates)]
    np.testing.assert_allclose(form_products(form, rates, spin, y, x), products, rtol=1e-10)
    whole = form_projection(form, rates, spin, y, x)
    np.testing.assert_allclose(np.diag(whole), products, rtol=1e-10)
    for k, rate in enumerate(rates):  # equal rates: yᵀEx of all pairs
        pairs = form_projection(form, np.full(3, rate), spin, y, x)
        np.testing.assert_allclose(pairs, y.T @ form_matrix(form, rate, spin) @ x, rtol=1e-8)
        assert whole[k, k] == pytest.approx(pairs[k, k], rel=1e-10)


def test_weight_grows_towards_the_cutoff_and_stays_finite():
    form = ErrorForm(**{**FORM, "safety": 2.0, "cutoff_rad_s": 100.0})
    found = form_weight(form, np.array([0.0, 50j, 30 + 40j, 100j, 1e9j]))
    np.testing.assert_allclose(found, 2.0 * np.array([1.0, 4 / 3, 4 / 3, 10.0, 10.0]))
    far = ErrorForm(**FORM)
    assert form_weight(far, np.array([1e6j]))[0] == 1.0


def test_forms_stay_with_a_disk_and_leave_with_other_coordinates(full, body):
    disk = ("left", "d", 20.0, 0.4, 0.2)
    attached = rd.attach_rigid_disk(body, *disk)
    assert attached.error_forms == body.error_forms
    assert not as_rigid_body(body).error_forms and not without_modes(body).error_forms
    # the form still tells the error of the body with its disk
    held = [ground("rotor", end, 7e7, 5e7) for end in ("left", "right")]
    small = dataclasses.replace(attached, error_forms=(dataclasses.replace(
        attached.error_forms[1], safety=1.0, cutoff_rad_s=np.inf),))  # fmt: skip
    systems = one_rotor(rd.attach_rigid_disk(full, *disk), held), one_rotor(small, held)
    exact, modes = (rd.modes_at_speed(system, 300.0, 4) for system in systems)
    change = np.abs(1 - exact.eigenvalues / modes.eigenvalues)
    found = frequency_errors(systems[1], modes).parts["mode_truncation"]
    np.testing.assert_allclose(found, change, rtol=0.05)  # (s/ω_c)² of these modes is below 0.05


def test_file_keeps_forms_bit_for_bit(body, tmp_path):
    rd.write_superelement(body, tmp_path / "body.h5")
    found = rd.read_superelement(tmp_path / "body.h5")
    assert [f.part for f in found.error_forms] == ["mesh", "mode_truncation"]
    for left, right in zip(body.error_forms, found.error_forms, strict=True):
        assert (left.part, left.safety, left.cutoff_rad_s) == (
            right.part,
            right.safety,
            right.cutoff_rad_s,
        )
        assert left.gram.tobytes() == right.gram.tobytes()
        if left.stiffness_change is None:
            assert right.stiffness_change is None
        else:
            assert left.stiffness_change.tobytes() == right.stiffness_change.tobytes()


def _unseal(path):
    """Clear the checksum at the start of a file that is changed on purpose."""
    with Path(path).open("r+b") as file:
        file.write(bytes(512))


def test_older_files_have_no_forms(body, tmp_path):
    rd.write_superelement(body, tmp_path / "body.h5")
    _unseal(tmp_path / "body.h5")
    with h5py.File(tmp_path / "body.h5", "a") as file:
        assert file.attrs["format_version"] == FORMAT_VERSION
        del file["error_forms"]
        file.attrs["format_version"] = "1.1.0"
    assert rd.read_superelement(tmp_path / "body.h5").error_forms == ()


def _group_as_dataset(file):
    del file["error_forms/mesh"]
    file["error_forms/mesh"] = np.eye(3)


def _linked(file):
    file["elsewhere"] = file["error_forms/mesh"]
    del file["error_forms/mesh"]
    file["error_forms/mesh"] = h5py.SoftLink("/elsewhere")


def _gram(values):
    def spoil(file):
        del file["error_forms/mesh/gram"]
        if values is not None:
            file["error_forms/mesh/gram"] = values(file["operators/M"].shape[0])

    return spoil


def _attribute(name, value):
    def spoil(file):
        if value is None:
            del file["error_forms/mesh"].attrs[name]
        else:
            file["error_forms/mesh"].attrs[name] = value

    return spoil


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (_gram(None), "error_forms/mesh/gram is missing"),
        (_gram(lambda n: np.eye(n)), "error_forms/mesh/gram has shape"),
        (_gram(lambda n: np.full((4 * n, 4 * n), np.nan)), "error_forms/mesh/gram has nan"),
        (_gram(lambda n: np.triu(np.ones((4 * n, 4 * n)))), "'mesh': gram is not symmetric"),
        (_attribute("safety", None), "error_forms/mesh has safety None"),
        (_attribute("safety", "large"), "error_forms/mesh has safety 'large'"),
        (_attribute("safety", 0.5), "'mesh': safety is 0.5"),
        (_attribute("cutoff_rad_s", -1.0), "'mesh': cutoff_rad_s is -1.0"),
        (_group_as_dataset, "error_forms/mesh is not a group"),
        (_linked, "error_forms/mesh is a link"),
        (lambda f: f.move("error_forms/mesh", "error_forms/weather"), "does not know"),
    ],
)
def test_bad_forms_in_files_are_refused_by_name(body, tmp_path, spoil, message):
    rd.write_superelement(body, tmp_path / "body.h5")
    copy = shutil.copy(tmp_path / "body.h5", tmp_path / "copy.h5")
    _unseal(copy)
    with h5py.File(copy, "a") as file:
        spoil(file)
    with pytest.raises(rd.SuperelementError, match=message) as caught:
        rd.read_superelement(copy)
    assert str(caught.value).startswith(str(copy))
