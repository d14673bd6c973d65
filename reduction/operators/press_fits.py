"""Faces that are pressed together: contact pressure of a spinning body, and where they lift.

The parts are pressed by an overlap, or clamped by a given pressure. Friction is left out of this
static solution, as in Lamé's of thick cylinders: the faces carry what is normal to them. With the
springs of pressed faces taken out, the opening g of every point on them follows from the pressure p
there and the square of the speed,

    g = F W p + Ω² g_1,   p = k (δ - g) where that is positive, else 0,

and the points that are closed are found by iteration (an active set).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.sparse as sp
import ufl
from dolfinx import fem

from solidwhirl.core.joint_states import JointState
from solidwhirl.geometry import Joint, Material
from solidwhirl.meshing.records import seat_name
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.operators import compat, forms, kinematics
from solidwhirl.reduction.operators.dofs import body_unknowns, motion_vectors
from solidwhirl.reduction.operators.kinematics import Kinematics
from solidwhirl.reduction.operators.layers import (
    JointSprings,
    Layer,
    LayerPoints,
    layer_in,
    with_layer,
)
from solidwhirl.reduction.operators.prestress import determinate_pins
from solidwhirl.reduction.solvers.constrained import factorise
from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray

# Springs that are as good as bonded, and those that hold parts where nothing else does, in parts of
# Young's modulus over the largest radius.
_STIFF, _SLACK = 1e7, 1e-8
_SPEEDS = 11
_PATIENCE, _MOST_STEPS = 4, 2000
# A speed of lifting is looked for up to so many times where pressure would first be gone, and found
# to this part of its square.
_FARTHEST, _CLOSE = 100.0, 1e-13
_RPM = 30.0 / np.pi
# Middles of the edges of a triangle, by the corner opposite.
_MIDDLES = np.array([[0.5, 0.5], [0.0, 0.5], [0.5, 0.0]])
# Directions that differ by less are one.
_PARALLEL = 1e-9
# Rounding of a pressure in parts of what the stiff springs would make of the overlap.
_ROUNDING = 1e-15


@dataclass(frozen=True, kw_only=True, eq=False)
class Contact:
    """Pressed faces of a body in order 0, with all that their pressure does not change."""

    joints: tuple[Joint, ...]
    points: LayerPoints
    stiffness: FloatArray  #: (q,) k [N/m³]
    overlap: FloatArray  #: (q,) δ, with what clamps the faces
    clamp: FloatArray  #: (q,) pressure that is given from outside [Pa]
    flexibility: FloatArray  #: (q, q) F W
    opening: FloatArray  #: (q,) g_1 at unit speed
    moved: FloatArray  #: (u, q) displacement by unit pressure at a point
    spun: FloatArray  #: (u,) displacement at unit speed without the pressed faces

    def pressure(self, square: float) -> FloatArray:
        """(q,) pressure at a square of the speed.

        Block principal pivoting (Júdice and Pires, Comput. Oper. Res. 21 (1994) 587-596): all
        points that are on the wrong side change it; where that does not make them fewer, the last
        one alone, which ends for a positive definite flexibility.
        """
        # beyond the clamping pressure, which parts that nothing else holds answer without bounds
        right = self.overlap - self.clamp / self.stiffness - square * self.opening
        tiny = _ROUNDING * float(((np.abs(self.overlap) + np.abs(right)) * self.stiffness).max())
        shut, fewest, patience = np.ones(len(right), dtype=bool), len(right) + 1, _PATIENCE
        for _ in range(_MOST_STEPS):
            more = -self.clamp
            own = self.flexibility[np.ix_(shut, shut)] + np.diag(1.0 / self.stiffness[shut])
            given = right[shut] - self.flexibility[np.ix_(shut, ~shut)] @ more[~shut]
            more[shut] = np.linalg.solve(own, given)
            out = more + self.clamp
            gap = self.flexibility @ more + square * self.opening - self.overlap
            wrong = np.where(shut, out, gap * self.stiffness) < -tiny
            count = int(wrong.sum())
            if not count:
                return np.where(out > tiny, out, 0.0)
            if count < fewest:
                fewest, patience = count, _PATIENCE
            elif patience:
                patience -= 1
            else:
                wrong[: np.flatnonzero(wrong)[-1]] = False
            shut = shut ^ wrong
        raise ReductionError(
            f"the pressed faces of {self.joints[0].where} find no rest at "
            f"{np.sqrt(square) * _RPM:.6g} rpm; choose another element size"
        )

    def own(self, joint: int) -> BoolArray:
        """(q,) which points are of a joint."""
        return np.asarray(self.points.joint == joint)

    def mean(self, joint: int, pressure: FloatArray) -> float:
        """Mean of a pressure (q,) over the face of a joint [Pa]."""
        own = self.own(joint)
        return float(np.average(pressure[own], weights=self.points.area_m2[own]))

    def displacement(self, pressure: FloatArray, square: float) -> FloatArray:
        """(u,) displacement of the body."""
        return np.asarray(self.moved @ (pressure - self.clamp) + square * self.spun)


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit:
    """State of a body at rest whose faces are pressed together."""

    field: Any  #: Displacement (Function)
    layer: Layer  #: With what it carries

    def stiffening(self, space: Any, kin: Kinematics, matter: forms.Medium, layer: Layer) -> Any:
        """Geometric stiffness of the stress at rest, PETSc in all of u of a space.

        `layer`: of that space.
        """
        around = kin if kin.harmonic == 0 else kinematics.harmonic(space.mesh, 0)
        u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
        dx = forms.measure(space.mesh, kin, compat.polynomial_degree(space))
        stress = forms.stress(around, matter, self.field)
        form = compat.compiled(forms.stiffening_form(kin, stress, u, v, dx))
        own = layer.carrying(self.layer).stiffening(kin)
        return with_layer(compat.assemble_matrix(form), own)


def added_matrices(
    space: Any, kin: Kinematics, matter: forms.Medium, layer: Layer | None, fit: Fit | None
) -> dict[str, Any]:
    """What joints add to the matrices of all of u, PETSc by name.

    `layer`: of the space, with what it carries at unit speed where that is known.
    """
    if layer is None:
        return {}
    out = {"stiffness": layer.stiffness(kin)}
    if fit is not None:
        own = fit.stiffening(space, kin, matter, layer)
        out["stiffness"] = with_layer(own, out["stiffness"])
    if layer.traction_pa is not None:
        out["stress_stiffening"] = layer.stiffening(kin)
    return out


@dataclass(frozen=True, kw_only=True, eq=False)
class Settled:
    """Joints of a body at rest: what is closed, and how they are over the speed."""

    springs: tuple[JointSprings, ...]
    states: tuple[JointState, ...]  #: Of the joints whose faces are pressed
    fit: Fit | None = None  #: What the pressed faces load the body with at rest


def settle(
    space: Any,
    kin: Kinematics,
    matter: forms.Medium,
    facet_tags: Mapping[str, Any],
    joints: Sequence[Joint],
    materials: Sequence[Material],
    maximum_speed_rad_s: float,
) -> Settled:
    """Find what is closed of the faces of a body's joints.

    `kin`: of order 0. `maximum_speed_rad_s`: the largest speed that is asked for. Raises
    ReductionError: pressed faces that are neither cylinders nor planes, are loose at rest or at a
    speed in the range, or press a section beyond its yield strength.
    """
    size = float(np.abs(space.tabulate_dof_coordinates()[:, 1]).max())
    unit = max(m.youngs_modulus_pa for m in materials) / size
    springs = [_springs(joint, unit) for joint in joints]
    pressed = [k for k, joint in enumerate(joints) if joint.is_pressed]
    if not pressed:
        return Settled(springs=tuple(springs), states=())
    open_faces = [
        replace(own, static_n_per_m3=(unit * _SLACK,) * 2) if joint.is_pressed else own
        for own, joint in zip(springs, joints, strict=True)
    ]
    layer = layer_in(space, facet_tags, open_faces)
    assert layer is not None
    contact = _overlapped(_contact(space, kin, matter, layer, joints, springs))
    at_rest, at_top = (contact.pressure(speed**2) for speed in (0.0, maximum_speed_rad_s))
    for k in pressed:
        own = contact.own(k)
        closed = (contact.points.places_m[own], at_rest[own] > 0.0)
        springs[k] = replace(springs[k], closed=closed, closed_at_top=at_top[own] > 0.0)
    fit = _fit(space, layer, contact, at_rest)
    stress = _FaceStress(space, kin, matter, facet_tags)
    states = tuple(_state(contact, k, stress, maximum_speed_rad_s) for k in pressed)
    for k, state in zip(pressed, states, strict=True):
        _refuse(joints[k], state)
    return Settled(springs=tuple(springs), states=states, fit=fit)


def _fit(space: Any, layer: Layer, contact: Contact, at_rest: FloatArray) -> Fit:
    """State at rest; `layer`: without the springs of pressed faces."""
    field = fem.Function(space)
    compat.owned_values(field)[:] = contact.displacement(at_rest, 0.0)
    field.x.scatter_forward()
    loaded = layer.loaded(compat.owned_values(field))
    assert loaded.traction_pa is not None
    traction = loaded.traction_pa.copy()
    pressed = [contact.joints[k].is_pressed for k in layer.points.joint]
    traction[pressed, 0] -= at_rest - contact.clamp
    return Fit(field=field, layer=replace(layer, traction_pa=traction))


def _springs(joint: Joint, unit: float) -> JointSprings:
    """Springs of a joint that is closed; `unit`: Young's modulus over the largest radius."""
    stiff = joint.stiffness_n_per_m3 or (_STIFF * unit,) * 2
    static = (stiff[0], _SLACK * unit) if joint.is_pressed else stiff
    return JointSprings(moving_n_per_m3=stiff, static_n_per_m3=static)


def _contact(
    space: Any,
    kin: Kinematics,
    matter: forms.Medium,
    layer: Layer,
    joints: Sequence[Joint],
    springs: Sequence[JointSprings],
) -> Contact:
    """Flexibility of the pressed faces, by one factorisation without their springs."""
    points, dx = layer.points, forms.measure(space.mesh, kin, compat.polynomial_degree(space))
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    matrix = compat.assemble_matrix(compat.compiled(forms.stiffness_form(kin, matter, u, v, dx)))
    matrix = with_layer(matrix, layer.static_stiffness(kin))
    load = compat.assembled_vector(compat.compiled(forms.centrifugal_form(kin, matter, v, dx)))
    chosen = np.flatnonzero([joints[k].is_pressed for k in points.joint])
    normal = points.jumps()[3 * chosen]
    forces = (normal.T @ sp.diags(2.0 * np.pi * points.area_m2[chosen])).toarray()
    unknowns = body_unknowns(space, kin, {}, [])
    motions = np.column_stack(
        [unknowns.of_motion(kin, c, m) for c, m in motion_vectors(space, kin, 0.0).items()]
    )
    factor = factorise(matrix, determinate_pins(motions, space.mesh.comm))
    moved = factor.solve(np.hstack([forces, load[:, None]]), None)[: len(load)]
    for made in (factor, matrix, unknowns):
        made.destroy()
    kept = points.at(chosen)
    overlap, clamp = (np.zeros(len(chosen)) for _ in range(2))
    for k in np.unique(kept.joint):
        there = kept.joint == k
        overlap[there], clamp[there] = _pressing(joints[k], kept, there, springs[k])
    return Contact(
        joints=tuple(joints),
        points=kept,
        stiffness=np.array([springs[k].moving_n_per_m3[0] for k in kept.joint]),
        overlap=overlap,
        clamp=clamp,
        flexibility=normal @ moved[:, :-1],
        opening=normal @ moved[:, -1],
        moved=moved[:, :-1],
        spun=moved[:, -1],
    )


def _pressing(
    joint: Joint, points: LayerPoints, there: BoolArray, springs: JointSprings
) -> tuple[FloatArray, FloatArray]:
    """Overlap (q,) of a joint's faces and the pressure (q,) that clamps them from outside.

    Of a mean pressure on a cylinder the overlap is left to `_overlapped`.
    """
    r = points.places_m[there, 1]
    normal = points.normal[there]
    if (np.abs(normal[:, 0]) < _PARALLEL).all():
        warm = joint.expansion_per_k * joint.temperature_difference_k * r
        return (joint.interference_m or 0.0) - warm, np.zeros(len(r))
    if (np.abs(normal[:, 1]) > _PARALLEL).any():
        raise ReductionError(
            f"{joint.where}: its face is neither a cylinder nor a plane, and what holds a cone on "
            "its seat is friction; give stiffness_n_per_m3 alone"
        )
    if joint.pressure_pa is None:
        raise ReductionError(
            f"{joint.where}: interference_m presses cylinders; its face is a plane: give the "
            "pressure_pa that clamps it (force of the tie bolts over its area)"
        )
    if joint.temperature_difference_k:
        raise ReductionError(
            f"{joint.where}: temperature_difference_k changes the fit of cylinders; its face is a "
            "plane, which tie bolts clamp: leave it out"
        )
    clamp = np.full(len(r), joint.pressure_pa)
    return clamp / springs.moving_n_per_m3[0], clamp


def _overlapped(contact: Contact) -> Contact:
    """With the overlaps that give the mean pressures asked for on cylinders, all faces closed."""
    asked = [
        k
        for k, joint in enumerate(contact.joints)
        if joint.pressure_pa is not None and not contact.clamp[contact.own(k)].any()
    ]
    if not asked:
        return contact
    whole = contact.flexibility + np.diag(1.0 / contact.stiffness)
    warm = contact.overlap.copy()
    units = np.zeros((len(warm), len(asked)))
    for column, k in enumerate(asked):
        units[contact.own(k), column] = 1.0
        warm[contact.own(k)] = 0.0
    clamped = warm - contact.clamp / contact.stiffness
    found = np.linalg.solve(whole, np.column_stack([units, clamped]))
    means = np.array([[contact.mean(k, column) for column in found.T] for k in asked])
    target = np.array([contact.joints[k].pressure_pa for k in asked]) - means[:, -1]
    return replace(
        contact, overlap=contact.overlap + units @ np.linalg.solve(means[:, :-1], target)
    )


def _state(
    contact: Contact, joint: int, stress: _FaceStress, maximum_speed_rad_s: float
) -> JointState:
    """One joint over the speeds from rest to the largest."""
    given, own = contact.joints[joint], contact.own(joint)
    speeds = np.linspace(0.0, maximum_speed_rad_s, _SPEEDS if maximum_speed_rad_s else 1)
    every = [contact.pressure(speed**2) for speed in speeds]
    pressure = np.array([p[own] for p in every])
    moved = [contact.displacement(p, s**2) for p, s in zip(every, speeds, strict=True)]
    area = 2.0 * np.pi * contact.points.area_m2[own]
    places, plane = contact.points.places_m[own], bool(contact.clamp[own].any())
    overlap = float(np.average(contact.overlap[own], weights=area))
    first, last = _lift_speeds(contact, joint)
    return JointState(
        between=given.between,
        interference_m=None if plane else overlap,
        friction=given.friction,
        area_m2=float(area.sum()),
        along_m=places[:, 1 if plane else 0],
        speeds_rad_s=speeds,
        pressure_pa=pressure,
        mean_pressure_pa=pressure @ area / area.sum(),
        lifted_part=(pressure <= 0.0) @ area / area.sum(),
        torque_n_m=given.friction * (pressure @ (area * places[:, 1])),
        stress_pa=np.array([stress.means(joint, u) for u in moved]),
        lifts_at_rad_s=first,
        loose_at_rad_s=last,
    )


def _lift_speeds(contact: Contact, joint: int) -> tuple[float | None, float | None]:
    """Speeds at which the first place of a face lifts and at which the last one does."""
    own, at_rest = contact.own(joint), contact.pressure(0.0)
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


class _FaceStress:
    """Von Mises stress of an axisymmetric field beside the faces of joints."""

    def __init__(
        self, space: Any, kin: Kinematics, matter: forms.Medium, facet_tags: Mapping[str, Any]
    ) -> None:
        self._field, self._domain, self._tags = fem.Function(space), space.mesh, facet_tags
        stress = forms.stress(kin, matter, self._field)
        self._von_mises = compat.expression(
            ufl.sqrt(1.5 * ufl.inner(ufl.dev(stress), ufl.dev(stress))), _MIDDLES
        )

    def means(self, joint: int, displacement: FloatArray) -> FloatArray:
        """(2,) mean over the face of a joint of the stress in either section [Pa]."""
        compat.owned_values(self._field)[:] = displacement
        self._field.x.scatter_forward()
        at_middles = np.asarray(compat.evaluated(self._von_mises, self._domain))
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


def _refuse(joint: Joint, state: JointState) -> None:
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
            f"at {top * _RPM:.6g} rpm {joint.where} is loose, from {loose * _RPM:.6g} rpm on "
            f"(mean pressure at rest {state.mean_pressure_pa[0]:.4g} Pa); allowed are lower speeds "
            "or more interference"
        )
    if joint.yield_pa is None:
        return
    speed, side = np.unravel_index(state.stress_pa.argmax(), state.stress_pa.shape)
    largest = float(state.stress_pa[speed, side])
    if largest > joint.yield_pa:
        raise ReductionError(
            f"at {state.speeds_rad_s[speed] * _RPM:.6g} rpm section {joint.between[side]!r} yields "
            f"at the {joint.where}: von Mises stress {largest:.4g} Pa in the mean of the face, "
            f"yield_pa is {joint.yield_pa:.4g}; allowed is less interference, or lower speeds"
        )
