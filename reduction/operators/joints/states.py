"""Pressed faces over the speed: where they lift, what they carry, and what is refused."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp
import ufl
from dolfinx import fem
from scipy.sparse.csgraph import connected_components

from solidwhirl.core.joint_states import JointState
from solidwhirl.geometry import Joint
from solidwhirl.meshing.records import seat_name
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.operators import compat, forms, kinematics
from solidwhirl.reduction.operators.dofs import motion_vectors
from solidwhirl.reduction.operators.joints.contact import Contact
from solidwhirl.reduction.operators.joints.layers import Layer
from solidwhirl.reduction.operators.kinematics import Kinematics
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S

_SPEEDS = 11
# Rounding of what springs resist of a motion, in parts of what the stiffest would everywhere.
_NOTHING = 1e-12
_LOOSE = {
    "ux": "slides across the axis",
    "uz": "slides along the axis",
    "rz": "turns about the axis",
}
# A speed of lifting is looked for up to so many times where pressure would first be gone, and found
# to this part of its square.
_FARTHEST, _CLOSE = 100.0, 1e-13
# Middles of the edges of a triangle, by the corner opposite.
_MIDDLES = np.array([[0.5, 0.5], [0.0, 0.5], [0.5, 0.0]])


class Pressures(NamedTuple):
    """Pressure of all faces over the speeds from rest to the largest."""

    speeds_rad_s: FloatArray  #: (s,)
    pressure_pa: FloatArray  #: (s, q)


def over_speeds(contact: Contact, maximum_speed_rad_s: float) -> Pressures:
    """Return the pressures up to the largest speed."""
    speeds = np.linspace(0.0, maximum_speed_rad_s, _SPEEDS if maximum_speed_rad_s else 1)
    return Pressures(speeds, np.array([contact.pressure(speed**2) for speed in speeds]))


def states_of(
    contact: Contact, pressed: Sequence[int], stress: FaceStress, over: Pressures
) -> tuple[JointState, ...]:
    """Return the states of pressed joints over the speeds."""
    at_middles = [
        stress.at_middles(contact.displacement(pressure, speed**2))
        for speed, pressure in zip(*over, strict=True)
    ]
    return tuple(
        _state(contact, k, over, np.array([stress.means(k, each) for each in at_middles]))
        for k in pressed
    )


def _state(contact: Contact, joint: int, over: Pressures, stress_pa: FloatArray) -> JointState:
    """State of one joint; `stress_pa`: (s, 2) in either section."""
    given, own = contact.joints[joint], contact.own(joint)
    pressure = over.pressure_pa[:, own]
    area = 2.0 * np.pi * contact.points.area_m2[own]
    places, plane = contact.points.places_m[own], bool(contact.clamp[own].any())
    overlap = float(np.average(contact.overlap[own], weights=area))
    first, last = _lift_speeds(contact, joint, over.pressure_pa[0])
    return JointState(
        between=given.between,
        interference_m=None if plane else overlap,
        friction=given.friction,
        area_m2=float(area.sum()),
        along_m=places[:, 1 if plane else 0],
        speeds_rad_s=over.speeds_rad_s,
        pressure_pa=pressure,
        mean_pressure_pa=pressure @ area / area.sum(),
        lifted_part=(pressure <= 0.0) @ area / area.sum(),
        torque_n_m=given.friction * (pressure @ (area * places[:, 1])),
        stress_pa=stress_pa,
        lifts_at_rad_s=first,
        loose_at_rad_s=last,
    )


def _lift_speeds(
    contact: Contact, joint: int, at_rest: FloatArray
) -> tuple[float | None, float | None]:
    """Speeds at which the first place of a face lifts and at which the last one does."""
    own = contact.own(joint)
    if not at_rest[own].any():
        return 0.0, 0.0
    shut = at_rest > 0.0
    system = contact.flexibility[np.ix_(shut, shut)] + np.diag(1.0 / contact.stiffness[shut])
    change = np.zeros(len(at_rest))
    change[shut] = np.linalg.solve(system, -contact.opening[shut])
    falls = own & (change < 0.0)
    if not falls.any():
        return None, None
    guess = float((at_rest[falls] / -change[falls]).min())
    first = _crossing(lambda square: not contact.pressure(square)[own].all(), guess)
    if first is None:
        return None, None
    if contact.clamp[own].any():  # what bolts clamp is carried by some place always
        return first, None
    last = _crossing(lambda square: not contact.pressure(square)[own].any(), max(first**2, guess))
    return first, last


def _crossing(happens: Callable[[float], bool], guess: float) -> float | None:
    """Speed from which on something happens; `guess`: of its square. None: nowhere near."""
    if happens(0.0):
        return 0.0
    low, high = 0.0, guess
    while not happens(high):
        low, high = high, 2.0 * high
        if high > _FARTHEST**2 * guess:
            return None
    while high - low > _CLOSE * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if happens(middle) else (middle, high)
    return float(np.sqrt(high))


class FaceStress:
    """Von Mises stress of an axisymmetric field beside the faces of joints."""

    def __init__(
        self, space: Any, kin: Kinematics, matter: forms.Medium, facet_tags: Mapping[str, Any]
    ) -> None:
        self._field, self._domain, self._tags = fem.Function(space), space.mesh, facet_tags
        stress = forms.stress(kin, matter, self._field)
        self._von_mises = compat.expression(
            ufl.sqrt(1.5 * ufl.inner(ufl.dev(stress), ufl.dev(stress))), _MIDDLES
        )

    def at_middles(self, displacement: FloatArray) -> FloatArray:
        """(c, 3) stress at the middles of the edges of all cells [Pa]."""
        compat.owned_values(self._field)[:] = displacement
        self._field.x.scatter_forward()
        return np.asarray(compat.evaluated(self._von_mises, self._domain))

    def means(self, joint: int, at_middles: FloatArray) -> FloatArray:
        """(2,) mean over the face of a joint of the stress in either section [Pa]."""
        return np.array([self._mean(joint, side, at_middles) for side in range(2)])

    def _mean(self, joint: int, side: int, at_middles: FloatArray) -> float:
        topology = self._domain.topology
        for dimensions in ((1, 2), (2, 1)):
            topology.create_connectivity(*dimensions)
        cells, facets = topology.connectivity(1, 2), topology.connectivity(2, 1)
        points, nodes = compat.straight_cells(self._domain)
        found, weights = [], []
        for facet in self._tags[seat_name(joint, side)].indices:
            cell = cells.links(facet)[0]
            local = int(np.flatnonzero(facets.links(cell) == facet)[0])
            ends = points[np.delete(nodes[cell], local)]
            found.append(at_middles[cell, local])
            weights.append(np.linalg.norm(ends[1] - ends[0]) * ends[:, 1].mean())
        return float(np.average(found, weights=weights))


def refuse_unsound(joint: Joint, state: JointState) -> None:
    """Refuse faces that are loose, and sections that yield.

    Raises ReductionError.
    """
    top, loose = float(state.speeds_rad_s[-1]), state.loose_at_rad_s
    if loose == 0.0:
        raise ReductionError(
            f"{joint.where} is loose at rest: its faces are not pressed together; allowed is an "
            "interference_m above what the temperature difference takes away"
        )
    if loose is not None and top >= loose:
        raise ReductionError(
            f"at {top * RPM_PER_RAD_S:.6g} rpm {joint.where} is loose, from "
            f"{loose * RPM_PER_RAD_S:.6g} rpm on (mean pressure at rest "
            f"{state.mean_pressure_pa[0]:.4g} Pa); allowed are lower speeds or more interference"
        )
    if joint.yield_pa is None:
        return
    speed, side = np.unravel_index(state.stress_pa.argmax(), state.stress_pa.shape)
    largest = float(state.stress_pa[speed, side])
    if largest > joint.yield_pa:
        raise ReductionError(
            f"at {state.speeds_rad_s[speed] * RPM_PER_RAD_S:.6g} rpm section "
            f"{joint.between[side]!r} yields at the {joint.where}: von Mises stress "
            f"{largest:.4g} Pa in the mean of the face, yield_pa is {joint.yield_pa:.4g}; "
            "allowed is less interference, or lower speeds"
        )


def refuse_loose(layer: Layer, space: Any, joints: Sequence[Joint], order: int) -> None:
    """Refuse parts that move as rigid ones against the rest of the body, which no spring resists.

    `layer`, `space`: of the meridian. `order`: circumferential order. Raises ReductionError.
    """
    nodes = compat.cell_unknowns(space).ravel()
    cells = len(compat.straight_cells(space.mesh)[1])
    of_cell = np.repeat(np.arange(cells), len(nodes) // cells)
    table = sp.csr_matrix((np.ones(len(nodes)), (of_cell, nodes)))
    parts, part = connected_components(table.T @ table, directed=False)
    area = np.repeat(layer.points.area_m2, 3)[:, None]
    springs = layer.springs_n_per_m3[:, [0, 1, 1]].reshape(-1, 1)
    kin = kinematics.harmonic(space.mesh, order)
    for motion, values in motion_vectors(space, kin, 0.0).items():
        each = np.where(np.repeat(part, 3)[:, None] == np.arange(parts), values[:, None], 0.0)
        jumps = layer.points.jumps() @ each
        s, q = np.linalg.eigh(jumps.T @ (area * springs * jumps))
        free = q[:, s <= _NOTHING * springs.max() * float((area * jumps**2).sum())]
        if free.shape[1] < 2:  # all parts as one
            continue
        apart = np.abs(jumps @ free).max(axis=1).reshape(-1, 3).max(axis=1)
        point = apart.argmax()
        raise ReductionError(
            f"{joints[layer.points.joint[point]].where}: its stiffness_n_per_m3 along the face is "
            f"{layer.springs_n_per_m3[point, 1]:g}, so that one section "
            f"{_LOOSE.get(motion, 'moves')} freely against the other; give more than "
            f"{_NOTHING:g} of that normal to the face"
            + ("" if order else ", or leave out what acts along or about the axis")
        )
