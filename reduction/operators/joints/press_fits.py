"""What joints give to the matrices of a body, and the state of the faces that are pressed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import ufl
from dolfinx import fem

from solidwhirl.core.joint_states import JointState
from solidwhirl.geometry import Joint, Material
from solidwhirl.reduction.operators import compat, forms, kinematics
from solidwhirl.reduction.operators.joints.contact import contact_of, overlapped
from solidwhirl.reduction.operators.joints.layers import (
    JointSprings,
    Layer,
    LayerPoints,
    layer_in,
    layer_on,
    with_layer,
)
from solidwhirl.reduction.operators.joints.states import (
    FaceStress,
    over_speeds,
    refuse_loose,
    refuse_unsound,
    states_of,
)
from solidwhirl.reduction.operators.kinematics import Kinematics
from solidwhirl.reduction.operators.prestress import free_displacement
from solidwhirl.rotordyn.core.arrays import FloatArray

# Springs that are as good as bonded, and those that hold parts where nothing else does, in parts of
# Young's modulus over the largest radius. Planes are pressed in the direction that is held so: more
# would take part of the pressure, with less rounding would be all that is left of it.
_STIFF, _SLACK, _SLACK_OF_PLANES = 1e7, 1e-8, 1e-5


@dataclass(frozen=True, kw_only=True, eq=False)
class Pressing:
    """What presses the faces of a body at rest."""

    springs: tuple[JointSprings, ...]  #: Without those of pressed faces
    #: On the meridian, with the traction in place of these [Pa]
    layer: Layer

    def at(self, points: LayerPoints) -> tuple[Layer, FloatArray]:
        """Layer of these springs on points of some space, and the traction there, (q, 3)."""
        opened = layer_on(points, self.springs)
        return opened, opened.carried_from(self.layer)


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit:
    """State of a body at rest whose faces are pressed together."""

    field: Any  #: Displacement (Function)
    pressing: Pressing

    def stiffening(
        self, space: Any, kin: Kinematics, matter: forms.Medium, points: LayerPoints
    ) -> Any:
        """Geometric stiffness of the stress at rest, PETSc in all of u of a space.

        `points`: of the faces in that space.
        """
        whole = kin.dimension == 3 or kin.harmonic == 0
        around = kin if whole else kinematics.harmonic(space.mesh, 0)
        u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
        dx = forms.measure(space.mesh, kin, compat.polynomial_degree(space))
        stress = forms.stress(around, matter, self.field)
        form = compat.compiled(forms.stiffening_form(kin, stress, u, v, dx))
        moved = fem.Function(space)
        moved.interpolate(self.field)
        opened, given = self.pressing.at(points)
        carried = opened.loaded(compat.owned_values(moved))
        assert carried.traction_pa is not None
        carried = replace(carried, traction_pa=carried.traction_pa + given)
        return with_layer(compat.assemble_matrix(form), carried.stiffening(kin))


def fit_of(
    space: Any, kin: Kinematics, stiffness: Any, points: LayerPoints, pressing: Pressing
) -> Fit:
    """Load a body with what presses its faces.

    `kin`: of order or index 0. `stiffness`: K of all of u without joints, which is used up.
    `points`: of the faces in the space.
    """
    opened, given = pressing.at(points)
    stiffness = with_layer(stiffness, opened.static_stiffness(kin))
    field = free_displacement(space, kin, stiffness, -opened.forces(kin, given))
    stiffness.destroy()
    return Fit(field=field, pressing=pressing)


def added_matrices(
    space: Any,
    kin: Kinematics,
    matter: forms.Medium,
    layer: Layer | None,
    fit: Fit | None,
) -> dict[str, Any]:
    """What joints add to the matrices of all of u, PETSc by name.

    `layer`: of the space, with what it carries at unit speed where that is known.
    """
    if layer is None:
        return {}
    out = {"stiffness": layer.stiffness(kin)}
    if fit is not None:
        own = fit.stiffening(space, kin, matter, layer.points)
        out["stiffness"] = with_layer(own, out["stiffness"])
    if layer.traction_pa is not None:
        out["stress_stiffening"] = layer.stiffening(kin)
    return out


@dataclass(frozen=True, kw_only=True, eq=False)
class Settled:
    """Joints of a body at rest: what is closed, and how they are over the speed."""

    springs: tuple[JointSprings, ...] = ()
    states: tuple[JointState, ...] = ()  #: Of the joints whose faces are pressed
    pressing: Pressing | None = None  #: What loads the body at rest; None without pressed faces
    layer: Layer | None = None  #: Of these springs, in the space of the body
    fit: Fit | None = None  #: The body under this load


def settle(
    space: Any,
    matter: forms.Medium,
    facet_tags: Mapping[str, Any],
    joints: Sequence[Joint],
    materials: Sequence[Material],
    maximum_speed_rad_s: float,
    order: int,
) -> Settled:
    """Find what is closed of the faces of a body's joints.

    `space`, `matter`, `facet_tags`: of the body's meridian. `maximum_speed_rad_s`: the largest
    speed that is asked for. `order`: circumferential order that the joints are for. Raises
    ReductionError: parts that nothing holds in that order; pressed faces that are neither cylinders
    nor planes, are loose at rest or at a speed in the range, or press a section beyond its yield
    strength.
    """
    size = float(np.abs(space.tabulate_dof_coordinates()[:, 1]).max())
    unit = max(m.youngs_modulus_pa for m in materials) / size
    springs = [_springs(joint, unit) for joint in joints]
    pressed = [k for k, joint in enumerate(joints) if joint.is_pressed]
    opened = layer_in(space, facet_tags, springs)
    assert opened is not None
    refuse_loose(opened, space, joints, order)
    if not pressed:
        return Settled(springs=tuple(springs))
    open_springs = _opened(opened, joints, springs, unit)
    around, opened = kinematics.harmonic(space.mesh, 0), layer_on(opened.points, open_springs)
    contact = overlapped(contact_of(space, around, matter, opened, joints, springs))
    over = over_speeds(contact, maximum_speed_rad_s)
    at_rest, at_top = over.pressure_pa[[0, -1]]
    for k in pressed:
        own = contact.own(k)
        closed = (contact.points.at(np.flatnonzero(own)), at_rest[own] > 0.0)
        springs[k] = replace(springs[k], closed=closed, closed_at_top=at_top[own] > 0.0)
    stress = FaceStress(space, around, matter, facet_tags)
    states = states_of(contact, pressed, stress, over)
    for k, state in zip(pressed, states, strict=True):
        refuse_unsound(joints[k], state)
    traction = np.zeros((len(opened.points.joint), 3))
    traction[np.isin(opened.points.joint, pressed), 0] = contact.clamp - at_rest
    return Settled(
        springs=tuple(springs),
        states=states,
        pressing=Pressing(springs=open_springs, layer=replace(opened, traction_pa=traction)),
    )


def _opened(
    layer: Layer, joints: Sequence[Joint], springs: Sequence[JointSprings], unit: float
) -> tuple[JointSprings, ...]:
    """Without the springs of pressed faces, but for what holds parts that lie loose."""
    out = list(springs)
    for k, joint in enumerate(joints):
        if joint.is_pressed:
            plane = layer.points.is_plane[layer.points.joint == k].all()
            held = ((_SLACK_OF_PLANES if plane else _SLACK) * unit, _SLACK * unit)
            out[k] = replace(out[k], static_n_per_m3=held)
    return tuple(out)


def _springs(joint: Joint, unit: float) -> JointSprings:
    """Springs of a joint that is closed; `unit`: Young's modulus over the largest radius."""
    stiff = joint.stiffness_n_per_m3 or (_STIFF * unit,) * 2
    along = 0.0 if joint.is_pressed else stiff[1]
    return JointSprings(moving_n_per_m3=stiff, static_n_per_m3=(stiff[0], along or _SLACK * unit))
