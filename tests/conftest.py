"""What several tests share: bodies, and a look at the figures that are drawn."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

sys.path.append(str(Path(__file__).parent))  # helpers of the tests can be imported
from shapes import body, plane, section, shaft_and_disk

from solidwhirl.geometry import Material

# how long a draw takes depends on what else the machine does
settings.register_profile("suite", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("suite")


@pytest.fixture(scope="session")
def reference_rotor():
    """Steel shaft 0.4 m, radius 0.02 m, with a disk of radius 0.15 m and width 0.03 m at 0.16 m.

    First free bending frequency 600.45 Hz; two independent harmonic calculations outside this
    project agree to 1e-5 on 600.45, 1178.58, 2884.60, 5499.70, 6636.76 Hz.
    """
    return shaft_and_disk()


@pytest.fixture(scope="session")
def twin_inner():
    """Inner rotor of the coaxial twin rotor with its three bearing planes."""
    third = 0.4 / 3.0
    return body(
        section("shaft", 0.0, 0.4, 0.0, 0.02),
        section("disk", third - 0.015, third + 0.015, 0.02, 0.15),
        interfaces=(plane("A", 0.0), plane("C", 2.0 * third), plane("B", 0.4)),
        name="inner",
    )


MATTER = Material(
    name="own", density_kg_per_m3=7850.0, youngs_modulus_pa=2.1e11, poissons_ratio=0.3
)


@pytest.fixture(scope="session")
def spinning_ring():
    """Thin ring of radius 0.1 m and 2 x 2 mm cross-section, E 2.1e11, nu 0.3, rho 7850."""
    return body(section("ring", 0.0, 0.002, 0.099, 0.101, MATTER), name="ring")


@pytest.fixture(scope="session")
def annular_disk():
    """Annular disk, bore 0.05 m, rim 0.2 m, thickness 10 mm, E 2.1e11, nu 0.3, rho 7850."""
    return body(section("disk", 0.0, 0.01, 0.05, 0.2, MATTER), name="disk")


@pytest.fixture
def drawn(monkeypatch):
    """The figures that are saved during a test, in their order."""
    from matplotlib.figure import Figure

    figures = []
    save = Figure.savefig

    def keep(figure, *args, **options):
        figures.append(figure)
        return save(figure, *args, **options)

    monkeypatch.setattr(Figure, "savefig", keep)
    return figures
