"""The superelement: one spinning body as dense matrices in named coordinates, affine in speed.

It is the only record that crosses from the reduction of a body to the assembly of an engine.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.core.reprs import hertz, lines_of, row
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.superelement import validation
from solidwhirl.rotordyn.superelement.mass_moments import MassMoments
from solidwhirl.rotordyn.superelement.residual_energy import ErrorForm, checked_forms
from solidwhirl.rotordyn.superelement.surface import Surface

__all__ = ["Coordinate", "ErrorForm", "InterfaceNode", "MassMoments", "Superelement"]

# Inertias about three axes of a body: none above the sum of the others, to this.
_INERTIA_LIMIT = 1e-6
_LONGEST_NAME = 200
# Of two sectors, bending is not the same in all directions.
_FEWEST_SECTORS = 3


@dataclass(frozen=True, kw_only=True)
class Coordinate:
    """Name one generalised coordinate of a superelement.

    Attributes
    ----------
    kind
        "interface" for a displacement or rotation of an interface node, "modal" for the amplitude
        of a fixed-interface mode.
    interface
        Name of the interface node; empty for a modal coordinate.
    component
        "ux" to "rz" at an interface (m, rad; rotations are true rotations about +x, +y, +z),
        "q" for a modal coordinate.
    frequency_hz
        Fixed-interface frequency of a modal coordinate; 0 for an interface coordinate.
    """

    kind: Literal["interface", "modal"]
    interface: str
    component: validation.Component
    frequency_hz: float

    @property
    def label(self) -> str:
        """Short text for tables, such as "front.ux" or "mode 412.7 Hz"."""
        if self.kind == "interface":
            return f"{self.interface}.{self.component}"
        return f"mode {self.frequency_hz:.6g} Hz"


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class InterfaceNode:
    """Describe a place where a body can be held, joined or loaded.

    Attributes
    ----------
    name
        Unique within the body.
    position_m
        Place of the master node, shape (3,), m.
    coupling
        How the surface follows the node: "rigid" (the surface moves with the node),
        "distributing" (the node is the weighted mean of the surface), "none" (the node is a point
        of the body itself, as in a beam).
    """

    name: str
    position_m: FloatArray
    coupling: validation.Coupling

    def __post_init__(self) -> None:
        where = f"interface {self.name!r}"
        object.__setattr__(
            self, "position_m", validation.finite_array(where, "position_m", self.position_m, (3,))
        )
        if not self.name:
            raise SuperelementError("an interface has an empty name; give each a unique name")
        if self.coupling not in validation.COUPLINGS:
            raise SuperelementError(
                f"{where}: coupling is {self.coupling!r}, allowed are {validation.COUPLINGS}"
            )


@dataclass(frozen=True, kw_only=True, eq=False, slots=True, weakref_slot=True)
class Superelement:
    """Hold one body at unit spin.

    With spin speed Ω about +z the free body obeys
    M q'' + Ω G q' + [K + Ω² (Kgeo − S)] q = f, plus ½ Ω' G q when the speed varies.

    In the inertial frame that takes a body that is the same in all directions. The coordinates of
    any other are motions in the axes that turn with it: `frame` "rotating", G = 2 ∫ρ v·(e_z×u),
    S = ∫ρ (e_z×v)·(e_z×u). `asymmetric.assembly` puts such bodies together.

    Attributes
    ----------
    level
        Model behind the matrices: "solid", "harmonic", "beam", "lumped", or "imported" from
        elsewhere.
    harmonics
        Circumferential harmonics of a "harmonic" model, cyclic indices of a sector; empty for
        whole solids and beams.
    coordinates
        The n coordinates, interface coordinates first.
    interfaces
        Interface nodes the coordinates refer to.
    mass
        M, shape (n, n), symmetric; kg for translations.
    stiffness
        K, elastic stiffness, shape (n, n), symmetric, N/m.
    gyroscopic
        G at Ω = 1 rad/s, shape (n, n), skew, kg.
    stress_stiffening
        Kgeo at Ω = 1 rad/s, from the centrifugal stress, shape (n, n), symmetric, kg.
    spin_softening
        S at Ω = 1 rad/s, shape (n, n), symmetric, kg.
    rigid_body_modes
        Motions ux, uy, uz, rx, ry, rz of the body about the origin, in the coordinates;
        shape (n, 6). Column of a motion that is absent: zero.
    rigid_body_present
        Which of the six motions the model can make, shape (6,), bool.
    mass_kg, center_of_gravity_m, inertia_kg_m2
        Mass, centre of gravity (3,) and inertia tensor (3, 3) about the centre of gravity.
    full_dofs
        Number of degrees of freedom before reduction.
    maximum_speed_rad_s
        Largest |Ω| the basis was made for; inf where no basis depends on speed.
    recovery_points_m
        Points for pictures, shape (m, 3); m may be 0.
    recovery_modes
        Displacement of the points per unit coordinate, shape (m, 3, n).
    free_frequencies_hz
        Elastic frequencies of lateral motion of the free body at rest, shape (k,); empty when not
        known.
    fixed_interface_frequencies_hz
        Frequencies of the fixed-interface modes, shape (j,).
    frequency_error_estimate
        Relative error estimate of those, shape (j,) or empty.
    provenance
        How the body was made; anything JSON can hold.
    spin_generator
        L at unit angle, shape (n, n): a turn of the whole displacement field by a small angle α
        about +z changes q by α L q (L ux = uy, L uy = −ux, likewise tilts; pairs of modes turn
        into each other; 0 for axial motion and torsion). None when it is not known; internal
        damping needs it.
    constraint
        Shape (n, r): the coordinates are q = constraint · r and nothing else, as in a rigid body
        with several interfaces. None when all are independent.
    error_forms
        What the reduction left out, one form for each part; empty when it is not known.
    moments
        Moments of the displacement over the mass; None when they are not known. Formats with a
        frame that moves with the body need them.
    surface
        Points of the surface and how they move, for pictures of modes; None when not known.
    cyclic_sectors
        Number N of equal sectors of a body that was reduced from one of them; None of others.
    frame
        "inertial", or "rotating": axes x, y of the body itself.

    Raises
    ------
    SuperelementError
        If shapes disagree, a number is not finite, a matrix is not symmetric or skew to 1e-10 of
        its largest entry, or the coordinates and interfaces contradict each other.
    """

    name: str
    level: validation.Level
    harmonics: tuple[int, ...]
    coordinates: tuple[Coordinate, ...]
    interfaces: tuple[InterfaceNode, ...]
    mass: FloatArray
    stiffness: FloatArray
    gyroscopic: FloatArray
    stress_stiffening: FloatArray
    spin_softening: FloatArray
    rigid_body_modes: FloatArray
    rigid_body_present: BoolArray
    mass_kg: float
    center_of_gravity_m: FloatArray
    inertia_kg_m2: FloatArray
    full_dofs: int
    maximum_speed_rad_s: float
    recovery_points_m: FloatArray
    recovery_modes: FloatArray
    free_frequencies_hz: FloatArray
    fixed_interface_frequencies_hz: FloatArray
    frequency_error_estimate: FloatArray
    provenance: Mapping[str, Any] = field(default_factory=dict)
    spin_generator: FloatArray | None = None
    constraint: FloatArray | None = None
    error_forms: tuple[ErrorForm, ...] = ()
    moments: MassMoments | None = None
    surface: Surface | None = None
    cyclic_sectors: int | None = None
    frame: validation.Frame = "inertial"

    def __post_init__(self) -> None:
        where = f"superelement {self.name!r}"
        n = len(self.coordinates)
        _check_names(self, where)
        _check_coordinates(self, where)
        for name, shape in _array_shapes(self, n).items():
            if getattr(self, name) is not None or name not in ("spin_generator", "constraint"):
                array = validation.finite_array(where, name, getattr(self, name), shape)
                object.__setattr__(self, name, array)
        for name in (*validation.SYMMETRIC_MATRICES, "gyroscopic"):
            sign = -1.0 if name == "gyroscopic" else 1.0
            object.__setattr__(
                self, name, validation.symmetrised(where, name, getattr(self, name), sign)
            )
        present = np.array(self.rigid_body_present, dtype=bool)
        if present.shape != (6,):
            raise SuperelementError(
                f"{where}: rigid_body_present has shape {present.shape}, allowed is (6,)"
            )
        present.setflags(write=False)
        object.__setattr__(self, "rigid_body_present", present)
        _check_scalars(self, where)
        object.__setattr__(self, "mass_kg", float(self.mass_kg))
        object.__setattr__(self, "maximum_speed_rad_s", float(self.maximum_speed_rad_s))
        object.__setattr__(self, "provenance", validation.plain_json(where, self.provenance))
        object.__setattr__(self, "error_forms", checked_forms(where, self.error_forms, n))
        validation.part_of_body(where, "moments", self.moments, MassMoments, n)
        validation.part_of_body(where, "surface", self.surface, Surface, n)
        _check_sectors(self, where)
        _check_frame(self, where)

    def __repr__(self) -> str:
        return _superelement_text(self)

    @property
    def size(self) -> int:
        """Number of coordinates n."""
        return len(self.coordinates)

    @property
    def turn(self) -> FloatArray | None:
        """L of q_fixed = e^{θL} q at an angle θ of the axes that turn with the body, (n, n).

        `spin_generator`, None where that is not known; 0 in the rotating frame, whose coordinates
        are those of these axes.
        """
        return np.zeros_like(self.mass) if self.frame == "rotating" else self.spin_generator

    def interface_index(self, interface: str, component: str) -> int:
        """Return the position of a coordinate, "ux" to "rz" of an interface, or refuse it."""
        for index, c in enumerate(self.coordinates):
            if c.interface == interface and c.component == component:
                return index
        self.interface_node(interface)
        raise SuperelementError(
            f"superelement {self.name!r}, interface {interface!r} has no component "
            f"{component!r}; it has {list(self.components_at(interface))}"
        )

    def components_at(self, interface: str) -> tuple[validation.Component, ...]:
        """Return the components an interface has, in coordinate order; empty without any."""
        return tuple(c.component for c in self.coordinates if c.interface == interface != "")

    def interface_node(self, interface: str) -> InterfaceNode:
        """Return the interface node of a given name, or say which there are."""
        for node in self.interfaces:
            if node.name == interface:
                return node
        names = [node.name for node in self.interfaces]
        raise SuperelementError(
            f"superelement {self.name!r} has no interface {interface!r}; it has {names}"
        )


def _superelement_text(element: Superelement) -> str:
    """Name, mass, size, interfaces, modes, and the speed it is good for."""
    top = element.maximum_speed_rad_s * RPM_PER_RAD_S
    seats = row(f"{n.name} {n.position_m[2]:.4g}" for n in element.interfaces)
    return lines_of(
        f"Superelement {element.name!r}: {element.level}, {element.frame} frame, "
        f"{element.mass_kg:.5g} kg, "
        f"{len(element.coordinates)} coordinates of {element.full_dofs}",
        [
            f"interfaces at z: {seats} m",
            f"free modes: {hertz(element.free_frequencies_hz)}",
            f"good up to {top:.6g} rpm" if np.isfinite(top) else "good at all speeds",
        ],
    )


def _array_shapes(element: Superelement, n: int) -> dict[str, tuple[int | None, ...]]:
    """Return the shape each array must have; None stands for any length."""
    points = np.shape(element.recovery_points_m)[0] if np.ndim(element.recovery_points_m) else 0
    square = dict.fromkeys((*validation.SYMMETRIC_MATRICES, "gyroscopic"), (n, n))
    return {
        **square,
        "rigid_body_modes": (n, 6),
        "center_of_gravity_m": (3,),
        "inertia_kg_m2": (3, 3),
        "recovery_points_m": (None, 3),
        "recovery_modes": (points, 3, n),
        "free_frequencies_hz": (None,),
        "fixed_interface_frequencies_hz": (None,),
        "frequency_error_estimate": (None,),
        "spin_generator": (n, n),
        "constraint": (n, None),
    }


def _check_names(element: Superelement, where: str) -> None:
    """Refuse names that are empty, long or can't be printed, repeated ones, an unknown level."""
    if not element.name:
        raise SuperelementError("a superelement has an empty name; give it one")
    names = [node.name for node in element.interfaces]
    for name in (element.name, *names):
        if len(name) > _LONGEST_NAME or not name.isprintable():
            raise SuperelementError(
                f"superelement: {name[:_LONGEST_NAME]!r} is no name; at most {_LONGEST_NAME} "
                "printable characters are allowed"
            )
    if element.level not in validation.LEVELS:
        raise SuperelementError(
            f"{where}: level is {element.level!r}, allowed are {validation.LEVELS}"
        )
    repeated = sorted(name for name, count in Counter(names).items() if count > 1)
    if repeated:
        raise SuperelementError(f"{where}: interface names {repeated} occur more than once")


def _check_coordinates(element: Superelement, where: str) -> None:
    """Refuse coordinates that are out of order, repeated or at an unknown interface."""
    names = {node.name: None for node in element.interfaces}
    seen: set[tuple[str, str]] = set()
    modal_at: int | None = None
    if not element.coordinates:
        raise SuperelementError(f"{where}: has no coordinates; at least one is needed")
    for index, c in enumerate(element.coordinates):
        place = f"{where}: coordinate {index}"
        if c.kind == "modal":
            modal_at = index if modal_at is None else modal_at
            if c.component != "q" or c.interface or not (np.isfinite(c.frequency_hz)):
                raise SuperelementError(
                    f"{place} is modal and needs component 'q', no interface and a finite "
                    f"frequency; found {c}"
                )
            continue
        if c.kind != "interface" or c.component not in validation.MOTIONS:
            raise SuperelementError(
                f"{place}: {c} is neither modal nor one of {validation.MOTIONS}"
            )
        if modal_at is not None:
            raise SuperelementError(
                f"{place} ({c.label}) follows modal coordinate {modal_at}; interface coordinates "
                "come first"
            )
        if c.interface not in names:
            raise SuperelementError(
                f"{place} names interface {c.interface!r}; the body has {list(names)}"
            )
        if (c.interface, c.component) in seen:
            raise SuperelementError(f"{place}: {c.label} occurs more than once")
        seen.add((c.interface, c.component))


def _check_scalars(element: Superelement, where: str) -> None:
    """Refuse scalars out of range and short vectors whose lengths disagree."""
    checks = {
        "mass_kg": (np.isfinite(element.mass_kg) and element.mass_kg > 0, "a positive number"),
        "maximum_speed_rad_s": (element.maximum_speed_rad_s >= 0, "0 or more, or inf"),
        "full_dofs": (element.full_dofs >= 0, "0 or more"),
    }
    for name, (passed, allowed) in checks.items():
        if not passed:
            raise SuperelementError(
                f"{where}: {name} is {getattr(element, name)}, allowed is {allowed}"
            )
    errors, fixed = element.frequency_error_estimate, element.fixed_interface_frequencies_hz
    if errors.size not in (0, fixed.size):
        raise SuperelementError(
            f"{where}: frequency_error_estimate has {errors.size} entries, allowed is 0 or "
            f"{fixed.size}, one for each fixed-interface frequency"
        )
    for name in ("free_frequencies_hz", "fixed_interface_frequencies_hz"):
        if (getattr(element, name) < 0).any():
            raise SuperelementError(f"{where}: {name} has a negative frequency")
    _check_mass(element, where)


def _check_sectors(element: Superelement, where: str) -> None:
    """Refuse sectors that bending can not be told by, and the surface of other ones."""
    count = element.cyclic_sectors
    if count is not None and not (isinstance(count, int) and count >= _FEWEST_SECTORS):
        raise SuperelementError(
            f"{where}: cyclic_sectors is {count!r}, allowed are whole numbers from "
            f"{_FEWEST_SECTORS}, or None"
        )
    copies = None if element.surface is None else element.surface.copies
    if copies is not None and copies.count != count:
        raise SuperelementError(
            f"{where}: surface is of one of {copies.count} sectors, cyclic_sectors is {count}"
        )


def _check_frame(element: Superelement, where: str) -> None:
    """Refuse an unknown frame, and in a rotating one what only the inertial one has."""
    if element.frame not in validation.FRAMES:
        raise SuperelementError(
            f"{where}: frame is {element.frame!r}, allowed are {validation.FRAMES}"
        )
    if element.frame == "inertial":
        return
    for name in ("spin_generator", "cyclic_sectors"):
        if getattr(element, name) is not None:
            raise SuperelementError(
                f"{where}: frame is 'rotating' and {name} is given; a body that is the same after "
                "a turn is in the inertial frame"
            )
    if element.moments is None:
        raise SuperelementError(
            f"{where}: frame is 'rotating' and moments is None; the body's own unbalance is in them"
        )


def _check_mass(element: Superelement, where: str) -> None:
    """Refuse what no body can have."""
    inertia = element.inertia_kg_m2
    largest = max(float(np.abs(inertia).max()), 1e-300)
    if (np.abs(inertia / largest - inertia.T / largest) > validation.SYMMETRY_LIMIT).any():
        raise SuperelementError(f"{where}: inertia_kg_m2 is not symmetric: {inertia.tolist()}")
    principal = np.linalg.eigvalsh(inertia / largest)  # ascending
    if principal[0] < -_INERTIA_LIMIT or principal[2] > principal[:2].sum() + _INERTIA_LIMIT:
        raise SuperelementError(
            f"{where}: inertia_kg_m2 has the principal values {(largest * principal).tolist()}; "
            "in a body none is negative, and none above the sum of the others"
        )
