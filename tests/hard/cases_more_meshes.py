"""Curved elements, scale, interfaces that nearly meet, rigid slabs, tips, and coarse meshes."""

from __future__ import annotations

import itertools
from functools import lru_cache

import numpy as np
from builders_body import even, meshed, reduced, tube
from builders_more import material, smallest_jacobians
from numpy.typing import NDArray
from shapes import STEEL, plane, section
from simplex import mesh_mass_kg

from solidwhirl.geometry import Body, GeometryError, Interface, mass_properties
from solidwhirl.meshing import MeshSize
from solidwhirl.reduction import ReductionError

FloatArray = NDArray[np.float64]
EIGHT = MeshSize(size_m=0.05, corner_size_m=0.05, around=8)


def _curved(level: str) -> Body:
    """Shaft, disk with fillets and a cone; the solid has the larger fillets, for its cost."""
    thick, radius = (0.1, 0.003) if level == "harmonic" else (0.12, 0.01)
    return Body(
        name="curved",
        sections=(
            section("shaft", 0.0, 0.2, 0.005, 0.02, STEEL),
            section("disk", 0.08, thick, 0.02, 0.06, STEEL),
            section("cone", 0.2, 0.25, (0.005, 0.005), (0.02, 0.04), STEEL),
        ),
        fillet_radius_m=radius,
    )


@lru_cache(maxsize=2)
def _swept(level: str) -> tuple[int, int, float]:
    """Elements that are folded and that were made straight, and the largest error of the mass."""
    body, folded, straight, error = _curved(level), 0, 0, 0.0
    exact = mass_properties(body).mass_kg
    for size_m in np.geomspace(0.003 if level == "harmonic" else 0.03, 0.06, 12):
        size = MeshSize(
            size_m=size_m,
            corner_size_m=size_m,
            around=4,
            through_thickness=0.5,
            growth=20.0,
        )
        mesh = meshed(body, level, size)
        folded += int(np.sum(smallest_jacobians(mesh.points, mesh.cells) <= 0.0))
        straight += mesh.quality.straightened_elements
        copies = 2 * mesh.sector.count if mesh.sector else 1
        error = max(error, abs(copies * mesh_mass_kg(mesh) / exact - 1.0))
    return folded, straight, float(error)


def _folded(level: str) -> float:
    """Folded elements; inf if no mesh had one to be made straight."""
    folded, straight, _ = _swept(level)
    return float(folded) if straight else np.inf


def _mass_error(level: str) -> float:
    return _swept(level)[2]


def _frequencies(level: str, scale: float) -> FloatArray:
    """Held and free frequencies of a rotor that is larger, times its scale."""
    size = {
        "harmonic": MeshSize(size_m=0.02 * scale, corner_size_m=0.02 * scale),
        "solid": MeshSize(
            size_m=0.08 * scale, corner_size_m=0.08 * scale, around=4, through_thickness=0.3
        ),
    }[level]
    body = Body(
        name="rotor",
        sections=(
            section("shaft", 0.0, 0.4 * scale, 0.0, 0.02 * scale, STEEL),
            section("disk", 0.15 * scale, 0.2 * scale, 0.02 * scale, 0.1 * scale, STEEL),
        ),
        interfaces=(plane("left", 0.05 * scale), plane("right", 0.35 * scale)),
    )
    spin = {"maximum_speed_rad_s": 500.0 / scale, "centrifugal": True, "gyroscopic": True}
    element = reduced(body, level, size, **spin)[0]
    held, free = element.fixed_interface_frequencies_hz, element.free_frequencies_hz
    return np.concatenate([held, free]) * scale


def _scale_error(level: str, scales: list[float]) -> float:
    own = _frequencies(level, 1.0)
    return max(float(np.abs(_frequencies(level, s) / own - 1.0).max()) for s in scales)


def _near_interfaces(level: str, part: float) -> float:
    """Two free frequencies with a second interface a part of the length from the first one.

    More interface motions can only make the basis larger: what counts is how far the frequencies
    rise above those of one interface.
    """
    size = even(0.02) if level == "harmonic" else EIGHT
    first, second = plane("first", 0.2), plane("second", 0.2 + 0.5 * part)
    two = reduced(tube(0.5, 0.0, 0.02, first, second), level, size)[0].free_frequencies_hz[:4]
    one = reduced(tube(0.5, 0.0, 0.02, first), level, size, modes=12)[0].free_frequencies_hz[:4]
    return float(np.abs(two / one - 1.0).max())


def _not_refused_well() -> float:
    """Two interfaces in one place, or nearly, that end otherwise than in a refusal."""
    wrong = 0
    for apart, level in itertools.product((0.0, 1e-13, 5e-11, 5e-9, 1e-7), ("harmonic",)):
        body = tube(0.5, 0.0, 0.02, plane("first", 0.2), plane("second", 0.2 + apart))
        wrong += not _refused(body, level)
    return float(wrong)


def _refused(body: Body, level: str) -> bool:
    """Whether one message says what is wrong; other exceptions and results do not count."""
    try:
        reduced(body, level, even(0.02) if level == "harmonic" else EIGHT)
    except (GeometryError, ReductionError):
        return True
    except (ArithmeticError, ValueError, np.linalg.LinAlgError):
        return False
    return False


def _stiff_middle(contrast: float) -> Body:
    middle = material(STEEL.density_kg_per_m3, STEEL.youngs_modulus_pa * contrast)
    return Body(
        name="stiff",
        sections=(
            section("left", 0.0, 0.15, 0.0, 0.02, STEEL),
            section("middle", 0.15, 0.25, 0.0, 0.02, middle),
            section("right", 0.25, 0.4, 0.0, 0.02, STEEL),
        ),
        interfaces=(plane("hub", 0.2),),
    )


def _stiff_interface(level: str) -> float:
    """The one interface lies in material 1e6 times as stiff; against 1e4, which differs by 1e-4."""
    size = even(0.01) if level == "harmonic" else EIGHT
    values = []
    for contrast in (1e4, 1e6):
        try:
            element = reduced(_stiff_middle(contrast), level, size, modes=8)[0]
        except ReductionError:
            return np.inf
        values.append(element.free_frequencies_hz[:4])
    return float(np.abs(values[1] / values[0] - 1.0).max())


def _tip(*more: Interface) -> Body:
    """Cone that ends in a point."""
    return Body(
        name="tip",
        sections=(section("cone", 0.0, 0.2, (0.0, 0.0), (0.02, 0.0), STEEL),),
        interfaces=(plane("base", 0.0), *more),
    )


def _tips_not_refused(level: str) -> float:
    wrong = 0
    for kind, coupling in itertools.product(("section", "face"), ("rigid", "distributing")):
        end = Interface(name="end", kind=kind, coupling=coupling, start_m=0.2, end_m=0.2)
        wrong += not _refused(_tip(end), level)
    return float(wrong)


def _near_tip() -> float:
    """Two free frequencies with an interface of radius 10 µm near the tip, against none there."""
    with_tip, without = (
        reduced(_tip(*more), "harmonic", even(0.002), modes=12)[0].free_frequencies_hz[:4]
        for more in ((plane("end", 0.1999),), ())
    )
    return float(np.abs(with_tip / without - 1.0).max())


def _rate() -> float:
    """4 less the rate at which the first frequency of a tube falls to its limit; inf if below.

    One element across the wall, up to 15 times as long as it is thick; the wall stays one element
    thick, so that the number of unknowns counts the elements along it.
    """
    body = tube(0.4, 0.04, 0.05)

    def first_hz(through: float, degree: int) -> tuple[int, float]:
        size = MeshSize(size_m=0.4, corner_size_m=0.4, through_thickness=through)
        element = reduced(body, "harmonic", size, components=(), degree=degree)[0]
        return element.full_dofs, float(element.free_frequencies_hz[0])

    exact = first_hz(2.0, 4)[1]
    unknowns, found = np.array([first_hz(through, 2) for through in (0.1, 0.15, 0.3)]).T
    errors = found / exact - 1.0
    if errors.min() <= 0.0:
        return np.inf
    return float(4.0 + np.polyfit(np.log(unknowns), np.log(errors), 1)[0])
