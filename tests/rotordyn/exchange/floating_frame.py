"""A flexible body in a frame that moves with it, spinning steadily about z, on springs.

Use:

    body = floating_body(form)      # of a BodyFixedForm, or of any object or dict with the same
                                    # fields (plain arrays; nodes as records or dicts)
    floating_frame_modes(body, {"front": (1e7, 0.0)}, 400.0)   # rad/s, inertial frame

`springs` maps the name of a node to (lateral, axial) stiffness in N/m: equal along x and y, so
constant in the frame that turns. Frequencies are those of the inertial frame, |ω|, rising; to
compare with `modes_at_speed(assembled, speed).eigenvalues.imag`.

Fields needed: mass_kg, center_of_gravity_m (3,), inertia_kg_m2 (3, 3) about the ORIGIN, mass
(m, m), stiffness (m, m), stress_stiffening (m, m), I3 (3, m), I4 (3, m), I5 (3, m, m), I8 (3, 3,
m), I9 (3, 3, m, m), nodes: name, position_m (3,), translations (3, m), rotations (3, m) or missing.

Equations. With the place R of the frame's origin, its turn A, V = AᵀR', ω and s = x + φq the
velocity of a point, seen in the frame, is V + ω × s + φ q'. The kinetic energy is

    T = ½ m V² + V·(ω × (S + I3 q)) + V·I3 q' + ½ ω·J(q) ω + ω·(I4_k + I5_jk q_j) q'_k
        + ½ q'·M q',    J(q) = J0 + Σ (I8_j + I8_jᵀ) q_j − Σ I9_jk q_j q_k ,    S = m c ,

and the equations of motion are (Boltzmann, Hamel), p = ∂T/∂V, L = ∂T/∂ω about the frame's origin,

    p' + ω × p = F ,  L' + ω × L + V × p = N ,  (∂T/∂q')' − ∂T/∂q + (K + ω_z² Kgeo) q = Q .

`momenta` evaluates p, L, ∂T/∂q' and ∂T/∂q as they stand, for any motion. They are linearised in
(q, V, ω, q') about V = 0, ω = Ω e_z by steps in the complex plane, exact to rounding; with R = A_Ω
ρ and A = A_Ω (1 + ψ~) the place follows ρ' = V − Ω × ρ, ψ' = δω − Ω × ψ. The steady centrifugal
deformation is left out, as in every linear model of a spinning body.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg as la

# Of a step in the complex plane: its square vanishes beside one.
STEP = 1e-40
# A circle is at least this round: forward 1, backward −1, neither 0.
ROUND = 1e-3


class FloatingNode(NamedTuple):
    """Place (3,) and motion in the modes, each (3, m)."""

    name: str
    position_m: Any
    translations: Any
    rotations: Any


class FloatingBody(NamedTuple):
    """All that the equations need; see the head of this file."""

    mass_kg: float
    center_of_gravity_m: Any
    inertia_kg_m2: Any
    mass: Any
    stiffness: Any
    stress_stiffening: Any
    I3: Any
    I4: Any
    I5: Any
    I8: Any
    I9: Any
    nodes: tuple[FloatingNode, ...]

    @property
    def modes(self) -> int:
        return self.mass.shape[0]

    def node(self, name: str) -> FloatingNode:
        return next(node for node in self.nodes if node.name == name)


class WhirlModes(NamedTuple):
    """Frequencies in the inertial frame [rad/s], rising, and 1 forward, −1 backward, 0 neither."""

    frequencies: Any
    orders: Any


def _field(source: Any, name: str, default: Any = None) -> Any:
    if isinstance(source, Mapping):
        return source.get(name, default)
    return getattr(source, name, default)


def floating_body(source: Any) -> FloatingBody:
    """Take the fields from an object or a dict."""
    names = [name for name in FloatingBody._fields if name not in ("mass_kg", "nodes")]
    arrays = {name: np.asarray(_field(source, name), dtype=float) for name in names}
    m = arrays["mass"].shape[0]
    nodes = tuple(
        FloatingNode(
            _field(node, "name"),
            np.asarray(_field(node, "position_m"), dtype=float),
            np.asarray(_field(node, "translations"), dtype=float),
            np.asarray(_field(node, "rotations", np.zeros((3, m))), dtype=float),
        )
        for node in _field(source, "nodes")
    )
    return FloatingBody(mass_kg=float(_field(source, "mass_kg")), nodes=nodes, **arrays)


class Momenta(NamedTuple):
    """∂T/∂V, ∂T/∂ω, ∂T/∂q', ∂T/∂q of any motion."""

    linear: Any
    angular: Any
    modal: Any
    pull: Any


def momenta(body: FloatingBody, q: Any, velocity: Any, spin: Any, rate: Any) -> Momenta:
    """Derivatives of the kinetic energy, nothing left out."""
    static = body.mass_kg * body.center_of_gravity_m + body.I3 @ q
    change = body.I8 + body.I8.transpose(1, 0, 2)  # [a, b, j]
    second = 0.5 * (body.I9 + body.I9.transpose(0, 1, 3, 2))
    inertia = body.inertia_kg_m2 + change @ q - (second @ q) @ q
    turning = body.I4 + np.einsum("ajk,j->ak", body.I5, q)
    inertia_per_q = change - 2.0 * np.einsum("abjk,k->abj", second, q)
    return Momenta(
        linear=body.mass_kg * velocity + np.cross(spin, static) + body.I3 @ rate,
        angular=np.cross(static, velocity) + inertia @ spin + turning @ rate,
        modal=velocity @ body.I3 + spin @ turning + body.mass @ rate,
        pull=velocity @ np.cross(spin, body.I3.T).T
        + 0.5 * np.einsum("a,abj,b->j", spin, inertia_per_q, spin)
        + np.einsum("a,ajk,k->j", spin, body.I5, rate),
    )


def _jacobian(body: FloatingBody, speed: float) -> tuple[Momenta, Any]:
    """Momenta of the steady spin, and their rates of change with (q, V, ω, q')."""
    m = body.modes
    zero = [np.zeros(m), np.zeros(3), np.array([0.0, 0.0, speed]), np.zeros(m)]
    at = momenta(body, *zero)
    columns = np.zeros((6 + 2 * m, 6 + 2 * m))
    for k in range(columns.shape[1]):
        state = np.concatenate(zero).astype(complex)
        state[k] += 1j * STEP
        moved = momenta(body, *np.split(state, [m, m + 3, m + 6]))
        columns[:, k] = np.concatenate(moved).imag / STEP
    return at, np.split(columns, [3, 6, 6 + m])


def _cross(vector: Any) -> Any:
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def _motion(body: FloatingBody, node: FloatingNode) -> tuple[Any, Any]:
    """Translation and rotation of a node per (ρ, ψ, q), each (3, 6 + m)."""
    none = np.zeros((3, 3))
    moved = np.hstack((np.eye(3), -_cross(node.position_m), node.translations))
    return moved, np.hstack((none, np.eye(3), node.rotations))


def _first_order(body: FloatingBody, springs: Mapping[str, Sequence[float]], speed: float) -> Any:
    """A of Y' = A Y, Y = (ρ, ψ, q, V, ω, q')."""
    m = body.modes
    at, (linear, angular, modal, pull) = _jacobian(body, speed)
    axis = _cross([0.0, 0.0, speed])
    # the spin is steady only if no force is needed to keep it up
    scale = body.mass_kg * speed**2 * (np.abs(body.center_of_gravity_m).max() + 1e-9)
    assert np.abs(axis @ at.linear).max() <= 1e-9 * scale, "the mass centre is off the axis"
    turned = np.abs(axis @ at.angular).max()
    assert turned <= 1e-9 * speed**2 * np.abs(body.inertia_kg_m2).max(), "z is no principal axis"

    # force on (ρ, ψ, q), the negative stiffness
    force = np.zeros((6 + m, 6 + m))
    force[6:, 6:] = -body.stiffness - speed**2 * body.stress_stiffening
    for name, (lateral, axial) in springs.items():
        moved, _ = _motion(body, body.node(name))
        force -= moved.T @ np.diag([lateral, lateral, axial]) @ moved

    # on (q, V, ω, q')
    turning = np.zeros((6 + m, 6 + 2 * m))
    turning[:3] = axis @ linear
    turning[3:6] = axis @ angular
    turning[6:] = -pull
    turning[:3, m + 3 : m + 6] -= _cross(at.linear)
    turning[3:6, m + 3 : m + 6] -= _cross(at.angular)
    turning[3:6, m : m + 3] -= _cross(at.linear)
    inertia = np.vstack((linear, angular, modal))

    size = 12 + 2 * m
    place, rates = slice(0, 6 + m), slice(6 + m, size)
    kinematic = np.zeros((6 + m, size))
    kinematic[:, rates] = np.eye(6 + m)
    kinematic[:3, :3] = kinematic[3:6, 3:6] = -axis
    # δ(momenta)' = inertia[:, q] q' + inertia[:, V ω q'] (V ω q')'
    right = np.zeros((6 + m, size))
    right[:, place] = force
    right[:, 6 : place.stop] -= turning[:, :m]
    right[:, rates] -= turning[:, m:]
    right -= inertia[:, :m] @ kinematic[6:]
    return np.vstack((kinematic, la.solve(inertia[:, m:], right)))


def floating_frame_modes(
    body: Any, springs: Mapping[str, Sequence[float]], speed: float
) -> WhirlModes:
    """Modes of the spinning body on springs, in the inertial frame; still ones are left out."""
    body = body if isinstance(body, FloatingBody) else floating_body(body)
    values, vectors = la.eig(_first_order(body, springs, speed))
    length = max((np.abs(node.position_m).max() for node in body.nodes), default=0.0) or 1.0
    rows = [_motion(body, node) for node in body.nodes]
    forward, backward, along = (np.zeros(values.size) for _ in range(3))
    places = vectors[: 6 + body.modes]
    for moved, turned in rows:
        for motion in (moved @ places, length * turned @ places):
            forward += np.abs(motion[0] + 1j * motion[1]) ** 2
            backward += np.abs(motion[0] - 1j * motion[1]) ** 2
            along += np.abs(motion[2]) ** 2
    lateral = forward + backward > along
    orders = np.where(lateral, np.where(forward > backward, 1, -1), 0)
    found = values.imag + orders * speed
    if speed == 0.0:  # any two circles are modes
        orders = np.where(lateral, np.where(np.cumsum(lateral) % 2, 1, -1), 0)
    least = np.minimum(forward, backward) > ROUND * np.maximum(forward, backward)
    still = 1e-9 * np.abs(values).max()
    taken = found > max(still, 1e-6 * abs(speed))
    doubtful = taken & lateral & least & (speed != 0.0)
    assert not doubtful.any(), f"no circles at {values[doubtful]}"
    ordered = np.argsort(found[taken], kind="stable")
    return WhirlModes(found[taken][ordered], orders[taken][ordered])
