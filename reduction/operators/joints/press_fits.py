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
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.operators import compat, forms, kinematics
from solidwhirl.reduction.operators.joints.contact import Contact, contact_of, overlapped
from solidwhirl.reduction.operators.joints.layers import (
    JointSprings,
    Layer,
    layer_in,
    layer_on,
    with_layer,
)
from solidwhirl.reduction.operators.joints.states import (
    FaceStress,
    over_speeds,
    refuse_unsound,
    states_of,
)
from solidwhirl.reduction.operators.kinematics import Kinematics
from solidwhirl.rotordyn.core.arrays import FloatArray

# Springs that are as good as bonded, and those that hold parts where nothing else does, in parts of
# Young's modulus over the largest radius. Planes are pressed in the direction that is held so: more
# would take part of the pressure, with less rounding would be all that is left of it.
_STIFF, _SLACK, _SLACK_OF_PLANES = 1e7, 1e-8, 1e-5


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

    springs: tuple[JointSprings, ...] = ()
    layer: Layer | None = None  #: Of these springs; None without joints
    states: tuple[JointState, ...] = ()  #: Of the joints whose faces are pressed
    fit: Fit | None = None  #: What the pressed faces load the body with at rest


def settle(
    space: Any,
    matter: forms.Medium,
    facet_tags: Mapping[str, Any],
    joints: Sequence[Joint],
    materials: Sequence[Material],
    maximum_speed_rad_s: float,
) -> Settled:
    """Find what is closed of the faces of a body's joints.

    `maximum_speed_rad_s`: the largest speed that is asked for. Raises ReductionError: joints of a
    solid; pressed faces that are neither cylinders nor planes, are loose at rest or at a speed in
    the range, or press a section beyond its yield strength.
    """
    if not joints:
        return Settled()
    if space.mesh.topology.dim == 3:
        raise ReductionError(f"{joints[0].where}: joints at level solid are not built")
    size = float(np.abs(space.tabulate_dof_coordinates()[:, 1]).max())
    unit = max(m.youngs_modulus_pa for m in materials) / size
    springs = [_springs(joint, unit) for joint in joints]
    pressed = [k for k, joint in enumerate(joints) if joint.is_pressed]
    layer = layer_in(space, facet_tags, springs)
    assert layer is not None
    if not pressed:
        return Settled(springs=tuple(springs), layer=layer)
    around, opened = kinematics.harmonic(space.mesh, 0), _opened(layer, joints, unit)
    contact = overlapped(contact_of(space, around, matter, opened, joints, springs))
    over = over_speeds(contact, maximum_speed_rad_s)
    at_rest, at_top = over.pressure_pa[[0, -1]]
    for k in pressed:
        own = contact.own(k)
        closed = (contact.points.places_m[own], at_rest[own] > 0.0)
        springs[k] = replace(springs[k], closed=closed, closed_at_top=at_top[own] > 0.0)
    stress = FaceStress(space, around, matter, facet_tags)
    states = states_of(contact, pressed, stress, over)
    for k, state in zip(pressed, states, strict=True):
        refuse_unsound(joints[k], state)
    return Settled(
        springs=tuple(springs),
        layer=layer_on(layer.points, springs),
        states=states,
        fit=_fit(space, opened, contact, at_rest),
    )


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


def _opened(layer: Layer, joints: Sequence[Joint], unit: float) -> Layer:
    """Without the springs of pressed faces, but for what holds parts that lie loose."""
    static = layer.static_n_per_m3.copy()
    pressed = np.array([joints[k].is_pressed for k in layer.points.joint])
    static[pressed] = _SLACK * unit
    static[pressed & layer.points.is_plane, 0] = _SLACK_OF_PLANES * unit
    return replace(layer, static_n_per_m3=static)


def _springs(joint: Joint, unit: float) -> JointSprings:
    """Springs of a joint that is closed; `unit`: Young's modulus over the largest radius."""
    stiff = joint.stiffness_n_per_m3 or (_STIFF * unit,) * 2
    static = (stiff[0], _SLACK * unit) if joint.is_pressed else stiff
    return JointSprings(moving_n_per_m3=stiff, static_n_per_m3=static)
