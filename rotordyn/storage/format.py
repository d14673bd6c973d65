"""Names, versions and limits of the superelement file; see `files` for writing and reading."""

from __future__ import annotations

from typing import Any, NamedTuple

import h5py
import numpy as np

FORMAT = "ROTOR-SUPERELEMENT"
FORMAT_VERSION = "1.5.0"
MAJOR_VERSION = 1
UNITS = {"length": "m", "mass": "kg", "time": "s", "force": "N", "angle": "rad"}
EQUATION = (
    "M q'' + Om*G q' + (K0 + Om^2*(Kgeo + Kspin) + dOm*Keul) q = f, spin Om about spin_axis, "
    "components along axes that are fixed (frame inertial) or turn with the body (rotating)"
)

# Sizes refused before any number is read, so that a damaged or hostile header costs nothing.
LARGEST_SIZE = 20_000
LARGEST_COUNT = 500_000_000
# Numbers of a file in SI units are far smaller; products of a few of these do not overflow.
LARGEST_NUMBER = 1e60
# Whole numbers that a double holds exactly.
LARGEST_WHOLE = 2**53
# Bytes of an attribute, of a name, and of the provenance.
LONGEST_ATTRIBUTE = 64 * 1024
LONGEST_NAME = 200
LONGEST_TEXT = 16_000_000
# Characters of a message made of what a file holds.
_LONGEST_MESSAGE = 2000

COUPLING_CODES = {"rigid": "RBE2", "distributing": "RBE3", "none": "none"}
COMPONENT_CODES = {"q": 0, "ux": 1, "uy": 2, "uz": 3, "rx": 4, "ry": 5, "rz": 6}
INTERFACE_KIND, MODAL_KIND = 0, 1


class Operator(NamedTuple):
    """One affine term: which field it holds, what it multiplies, and its powers of Ω and Ω'."""

    field: str
    acts_on: str
    omega_power: int
    omega_dot_power: int
    symmetry: str
    note: str


OPERATORS = {
    "M": Operator("mass", "qdd", 0, 0, "symmetric", "mass"),
    "K0": Operator("stiffness", "q", 0, 0, "symmetric", "elastic stiffness"),
    "G": Operator(
        "gyroscopic", "qd", 1, 0, "skew", "gyroscopic; in the rotating frame of Coriolis forces"
    ),
    "Kgeo": Operator(
        "stress_stiffening", "q", 2, 0, "symmetric", "stiffness of the centrifugal stress"
    ),
    "Kspin": Operator("spin_softening", "q", 2, 0, "symmetric", "spin softening with its sign"),
}
EULER = Operator("gyroscopic", "q", 0, 1, "skew", "Euler term, half of G")

# Terms the format knows and this program does not evaluate; leaving them out would be wrong.
UNSUPPORTED = ("D0", "Kcirc", "sampled")


def printable(text: str, longest: int = _LONGEST_MESSAGE) -> str:
    """Return a text for a message: control characters escaped, the end cut off where it is long."""
    cut = text if len(text) <= longest else f"{text[:longest]}..."
    return "".join(
        c if c.isprintable() or c == "\n" else c.encode("unicode_escape").decode() for c in cut
    )


def put_numbers(group: h5py.Group, name: str, data: Any, **attributes: Any) -> None:
    """Write numbers; arrays of two and more axes compressed and with a checksum."""
    packed = np.ndim(data) >= 2 and np.size(data) > 0
    options = {"compression": "gzip", "shuffle": True, "fletcher32": True} if packed else {}
    dataset = group.create_dataset(name, data=data, track_times=False, **options)
    dataset.attrs.update(attributes)
