"""A curved fan blade (Olson and Lindberg, 1968) as a solid against a thin shell."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
from numpy.polynomial import legendre

from solidwhirl.pipeline.run import run_scene
from solidwhirl.scene_reading.reader import read_scene

SCENE = Path(__file__).resolve().parents[2] / "scenes" / "measured" / "panel.toml"


def _functions(count, points, power):
    """Legendre polynomials on [0, 1] times x^power, and their first two derivatives: (3, c, p)."""
    out = []
    for k in range(count):
        p = legendre.Legendre.basis(k, domain=[0.0, 1.0]).convert(kind=np.polynomial.Polynomial)
        p = p * np.polynomial.Polynomial([0.0, 1.0]) ** power
        out.append([p.deriv(m)(points) if m else p(points) for m in range(3)])
    return np.array(out).swapaxes(0, 1)


def shell_frequencies(spec, terms):
    """Frequencies [Hz] by Ritz with `terms` polynomials each way, strains of Love's shell theory.

    A. Leissa, Vibration of Shells, NASA SP-288, section 1.2.
    """
    length, radius, arc, h, young, nu, rho = spec
    gauss, weight = legendre.leggauss(2 * terms + 6)
    t, weight = 0.5 * (gauss + 1.0), 0.5 * weight
    bending, sliding, free = (_functions(terms, t, power) for power in (2, 1, 0))

    def field(along, dx, around, dy):
        shape = along[dx][:, None, :, None] * around[dy][None, :, None, :]
        scale = length**-dx * (radius * arc) ** -dy
        return scale * shape.reshape(terms * terms, -1)

    # strains of u, v, w at the points; y = R θ
    def u(dx, dy):
        return field(sliding, dx, free, dy)

    def w(dx, dy):
        return field(bending, dx, free, dy)

    none = np.zeros_like(u(0, 0))
    strains = np.array([
        np.vstack([u(1, 0), none, none]),
        np.vstack([none, u(0, 1), w(0, 0) / radius]),
        np.vstack([u(0, 1), u(1, 0), none]),
        h / np.sqrt(12.0) * np.vstack([none, none, -w(2, 0)]),
        h / np.sqrt(12.0) * np.vstack([none, u(0, 1) / radius, -w(0, 2)]),
        h / np.sqrt(12.0) * np.vstack([none, 2.0 * u(1, 0) / radius, -2.0 * w(1, 1)]),
    ])  # fmt: skip
    area = np.outer(weight, weight).ravel() * length * radius * arc
    plane = young / (1.0 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1.0 - nu) / 2.0]])
    law = np.kron(np.eye(2), plane) * h
    stiffness = np.einsum("ij,ikp,jlp,p->kl", law, strains, strains, area, optimize=True)
    motion = [u(0, 0), u(0, 0), w(0, 0)]
    mass = rho * h * scipy.linalg.block_diag(*[(m * area) @ m.T for m in motion])
    size = np.sqrt(np.diag(mass))
    # powers make the functions nearly dependent: the combinations that carry mass are taken
    s, q = np.linalg.eigh(mass / np.outer(size, size))
    kept = q[:, s > 1e-11] / np.sqrt(s[s > 1e-11])
    reduced = kept.T @ (stiffness / np.outer(size, size)) @ kept
    return np.sqrt(np.abs(np.linalg.eigvalsh(reduced))[:10]) / (2.0 * np.pi)


@pytest.mark.verify
def test_solid_panel_against_a_thin_shell():
    """1 %: thickness over radius is 1/200; the mesh of the solid has its own estimate."""
    spec = (0.3048, 0.6096, 0.5, 0.003048, 2.0684e11, 0.3, 7747.73)
    shell = shell_frequencies(spec, 12)
    np.testing.assert_allclose(shell_frequencies(spec, 10)[:7], shell[:7], rtol=1e-3)
    found = run_scene(read_scene(SCENE))
    assert found is not None
    assert found.at_rest.frequency_hz[:7] == pytest.approx(shell[:7], rel=1e-2)
