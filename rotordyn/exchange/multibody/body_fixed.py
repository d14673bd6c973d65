"""A spinning body in the frame that moves and turns with it, its rigid motions taken out.

Programs for flexible multibody systems describe a body by a frame that carries its large motion,
and by small elastic deformations seen from there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.core.arrays import FloatArray, ReadOnlyArrays
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.superelement.body_measures import (
    CROSS,
    gyroscopic_moment_error,
    least_inertia,
)
from solidwhirl.rotordyn.superelement.free_body import free_body_matrices, free_body_problems
from solidwhirl.rotordyn.superelement.mass_moments import MassMoments, projected_moments
from solidwhirl.rotordyn.superelement.record import Superelement
from solidwhirl.rotordyn.superelement.rigid_body import body_mass_matrix
from solidwhirl.rotordyn.superelement.validation import MOTIONS

# Frequencies closer than this (relative) are one mode with two shapes.
_SAME_FREQUENCY = 1e-6
# A mode of a pair turns into the other; of a single one this part at most is left by a turn.
_TURNS = 1e-3
# G of a solid's mesh and that of its moments differ by its mesh error; without G this is 1.
_GYROSCOPIC_LIMIT = 2e-2
_LATERAL = (0, 1, 3, 4)
_ELASTIC = {2: ("uz", "axial motion"), 5: ("rz", "torsion")}


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class BodyFixedNode(ReadOnlyArrays):
    """Hold the motion of an interface in the elastic modes.

    `name`: of the interface.
    `position_m`: place of its master node in the body's frame, shape (3,), m.
    `translations`, `rotations`: its motion along and about x, y, z per mode, each of shape (3, m);
    0 where the body has no such coordinate.
    """

    name: str
    position_m: FloatArray
    translations: FloatArray
    rotations: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class BodyFixedForm(ReadOnlyArrays):
    """Hold a body in its own frame: m elastic modes of the free body at rest, mass-normalised.

    The frame lies in the undeformed body, its origin and axes those of the superelement at rest.
    φ_j is the displacement of mode j, x the place, integrals are over the mass; n is an axis of
    spin. At the spin Ω about z, seen in the frame,

    M q'' + Ω C q' + [K + Ω² (Kgeo + Kspin)] q = f,
    C_ij = 2 ∫ φ_i·(n × φ_j), Kspin_ij = −∫ (n × φ_i)·(n × φ_j).

    `name`: name of the body.
    `frequencies_hz`: of the modes, rising, shape (m,).
    `shapes`: in the coordinates of the superelement, shape (n, m).
    `mass_kg`, `center_of_gravity_m`, `inertia_kg_m2`: mass, centre of gravity (3,) and inertia
    tensor (3, 3) about the *origin*.
    `mass`, `stiffness`: unit matrix, and diagonal of (2πf)², each (m, m).
    `I3`: ∫ φ_j, shape (3, m), kg: [a, j].
    `I4`: ∫ x × φ_j, shape (3, m), kg m.
    `I5`: ∫ φ_j × φ_k, shape (3, m, m), kg: [a, j, k].
    `I8`: −∫ x~ φ_j~, shape (3, 3, m), kg m, with a~ b = a × b; J changes by I8_j + I8_jᵀ.
    `I9`: ∫ φ_j~ φ_k~, shape (3, 3, m, m), kg.
    `stress_stiffening`: Kgeo at 1 rad/s about z, shape (m, m), symmetric, kg; with the tilts of
    rigid disks and of sections in it, for which the inertial frame needs no such term.
    `nodes`: interfaces.
    `points_m`, `point_modes`: recovery points (p, 3) and their displacement per mode (p, 3, m).
    """

    name: str
    frequencies_hz: FloatArray
    shapes: FloatArray
    mass_kg: float
    center_of_gravity_m: FloatArray
    inertia_kg_m2: FloatArray
    mass: FloatArray
    stiffness: FloatArray
    I3: FloatArray
    I4: FloatArray
    I5: FloatArray
    I8: FloatArray
    I9: FloatArray
    stress_stiffening: FloatArray
    nodes: tuple[BodyFixedNode, ...]
    points_m: FloatArray
    point_modes: FloatArray


def body_fixed_form(element: Superelement, *, modes: int | None = None) -> BodyFixedForm:
    """Return a body in the frame that moves with it.

    `element`: a free body that knows its moments, in the frame that turns with it or of revolution
    with its spin generator; `modes`:
    number of elastic modes, the lowest; one more where that would part a pair of equal frequency.
    None for all: n less the rigid motions the body has. The modes are orthogonal to
    the rigid motions in the mass: for those the moving frame stands, also for motions that the body
    has no coordinates for. The two modes of a pair lie in the planes of x and y as far as
    interfaces show it. Raises SuperelementError if the body is tied (`constraint`), does not know
    its moments or spin generator, can not make the four lateral rigid motions, resists one it has,
    has no elastic motion or not as many modes, or if its gyroscopic matrix is not that of its
    moments.

    A fixed displacement q of the inertial frame is e^{ΩtL} p of the body's, L the spin generator,
    and all matrices stay the same in a turn. Hence C = G + 2 M L and Kgeo + Kspin = K2 + G L +
    M L², K2 that of the inertial frame, from which Kgeo follows with Kspin of the moments. The
    matrices of a body in the rotating frame are those of its own: L is 0.
    """
    moments, turn = _checked(element)
    frequencies, shapes = _elastic_modes(element)
    shapes = _in_planes(element, turn, frequencies, shapes)
    kept = _kept(element, frequencies, modes)
    frequencies, shapes = frequencies[:kept], shapes[:, :kept]
    modal = projected_moments(moments, shapes)
    assert modal is not None
    return BodyFixedForm(
        name=element.name,
        frequencies_hz=frequencies / (2.0 * np.pi),
        shapes=shapes,
        mass_kg=element.mass_kg,
        center_of_gravity_m=element.center_of_gravity_m,
        inertia_kg_m2=body_mass_matrix(element)[3:, 3:],
        mass=np.eye(kept),
        stiffness=np.diag(frequencies**2),
        I3=modal.displacement_kg,
        I4=np.einsum("cab,abj->cj", CROSS, modal.first_kg_m),
        I5=np.einsum("cab,abjk->cjk", CROSS, modal.second_kg),
        **_inertia_changes(modal),
        stress_stiffening=_stress_stiffening(element, turn, shapes, modal),
        nodes=tuple(_node(element, name, shapes) for name in (i.name for i in element.interfaces)),
        points_m=element.recovery_points_m,
        point_modes=element.recovery_modes @ shapes,
    )


def _checked(element: Superelement) -> tuple[MassMoments, FloatArray]:
    """Moments of a body that has a body-fixed form, and L, 0 in the rotating frame."""
    where = f"superelement {element.name!r} in a frame that moves with it"
    if element.constraint is not None:
        raise SuperelementError(
            f"{where}: its coordinates are tied (constraint); bodies with independent ones are "
            "allowed"
        )
    if element.moments is None:
        raise SuperelementError(
            f"{where}: the moments of its displacement over the mass are not known (files before "
            "1.3 have none); make the body again"
        )
    turn = element.turn
    if turn is None:
        raise SuperelementError(
            f"{where}: its spin generator is not known; a body of revolution whose modes pair up "
            "in a turn is needed, or one in the rotating frame"
        )
    missing = [MOTIONS[k] for k in _LATERAL if not element.rigid_body_present[k]]
    if missing:
        raise SuperelementError(
            f"{where}: it has no rigid motion {', '.join(missing)}; a body that is held to the "
            "ground has no frame of its own"
        )
    problems = free_body_problems(element)
    if not problems and least_inertia(element.mass) <= 0.0:
        problems = ("the mass matrix is not positive definite",)
    if problems:
        raise SuperelementError(f"{where}: {'; '.join(problems)}")
    error = gyroscopic_moment_error(element)
    if error is not None and error > _GYROSCOPIC_LIMIT:
        raise SuperelementError(
            f"{where}: the gyroscopic matrix differs by {error:.2e} from that of its moments, "
            f"allowed is {_GYROSCOPIC_LIMIT:g}; a body made without gyroscopic effects can not be "
            "turned into it"
        )
    return element.moments, turn


def _elastic_modes(element: Superelement) -> tuple[FloatArray, FloatArray]:
    """Return ω of the elastic modes of the free body at rest, rising, and M-normalised shapes.

    Rigid motions R are known and taken out, not told apart by their frequency: with K + s M R
    (RᵀMR)⁻¹ RᵀM = LLᵀ and M = NNᵀ, the columns of Nᵀ L⁻ᵀ across LᵀR have the singular values 1/ω.
    Nothing is squared, and the lowest modes are the most accurate.
    """
    matrices = free_body_matrices(element)
    root = np.sqrt(np.diag(matrices.mass))
    scale = np.outer(root, root)
    mass, stiffness = matrices.mass / scale, matrices.stiffness / scale
    rigid = root[:, None] * element.rigid_body_modes[:, element.rigid_body_present]
    inertia = np.asarray(la.cholesky(mass, lower=True))
    motion, _ = la.qr(inertia.T @ rigid, mode="economic")
    if motion.shape[1] == mass.shape[0]:
        raise SuperelementError(
            f"superelement {element.name!r} has no elastic motion; a rigid body needs no modes"
        )
    held = inertia @ motion
    # as large as the diagonal of the stiffness across the rigid motions, so that none drowns
    size = float(np.median(np.diag(stiffness)))
    try:
        factor = la.cholesky(stiffness + size * held @ held.T, lower=True)
    except la.LinAlgError as error:
        raise SuperelementError(
            f"superelement {element.name!r}: its stiffness is not positive beside the rigid "
            f"motions ({error})"
        ) from error
    solved = la.solve_triangular(factor, inertia, lower=True).T
    across, _ = la.qr(factor.T @ la.solve_triangular(inertia.T, motion))
    left, period, _ = la.svd(solved @ across[:, motion.shape[1] :], full_matrices=False)
    left -= motion @ (motion.T @ left)
    shapes = la.solve_triangular(inertia.T, left) / root[:, None]
    return 1.0 / period, np.asarray(shapes)


def _in_planes(
    element: Superelement, turn: FloatArray, frequencies: FloatArray, shapes: FloatArray
) -> FloatArray:
    """Return the modes with those of equal frequency in pairs: in one plane, and turned by 90°.

    Of each pair the first is that with the least motion of interfaces along y and about x.
    """
    root = np.sqrt(np.diag(element.mass))
    other = [k for k, c in enumerate(element.coordinates) if c.component in ("uy", "rx")]
    result, start = shapes.copy(), 0
    while start < frequencies.size:
        near = np.abs(frequencies[start:] - frequencies[start])
        stop = start + int(np.count_nonzero(near <= _SAME_FREQUENCY * frequencies[start]))
        group = shapes[:, start:stop]
        inner = group.T @ element.mass @ turn @ group
        left, size, _ = la.svd(0.5 * (inner - inner.T))
        turning, still = left[:, size > _TURNS], left[:, size <= _TURNS]
        columns = [group @ _signed(still, root[:, None] * group)]
        if turning.shape[1] % 2 == 0 and turning.size:
            *_, across = la.svd((root[:, None] * group)[other] @ turning)
            plane = _signed(turning @ across[across.shape[0] // 2 :].T, root[:, None] * group)
            partner = inner @ plane
            partner -= plane @ (plane.T @ partner)
            rows, _, columns_of = la.svd(partner, full_matrices=False)
            partner = rows @ columns_of
            pairs = np.stack((plane, partner), axis=2).reshape(stop - start, -1)
            columns.insert(0, group @ pairs)
        else:
            columns.insert(0, group @ _signed(turning, root[:, None] * group))
        result[:, start:stop] = np.hstack(columns)
        start = stop
    return result


def _signed(columns: FloatArray, shapes: FloatArray) -> FloatArray:
    """Return the columns with the largest entry of each shapes · column positive."""
    seen = shapes @ columns
    largest = seen[np.abs(seen).argmax(axis=0), np.arange(columns.shape[1])]
    return np.asarray(columns * np.where(largest < 0.0, -1.0, 1.0))


def _kept(element: Superelement, frequencies: FloatArray, modes: int | None) -> int:
    """Number of modes, no pair of equal frequency parted."""
    if modes is None:
        return frequencies.size
    if not 1 <= modes <= frequencies.size:
        raise SuperelementError(
            f"superelement {element.name!r}: {modes} modes; it has 1 to {frequencies.size} elastic "
            "ones"
        )
    last = frequencies[modes - 1]
    return int(np.count_nonzero(frequencies <= last * (1.0 + _SAME_FREQUENCY)))


def _inertia_changes(modal: MassMoments) -> dict[str, FloatArray]:
    """I8 and I9, from a~ b~ = b aᵀ − (a·b) 1."""
    first, second, unit = modal.first_kg_m, modal.second_kg, np.eye(3)
    return {
        "I8": np.einsum("ab,ccj->abj", unit, first) - first.transpose(1, 0, 2),
        "I9": second.transpose(1, 0, 2, 3) - np.einsum("ab,ccjk->abjk", unit, second),
    }


def _stress_stiffening(
    element: Superelement, turn: FloatArray, shapes: FloatArray, modal: MassMoments
) -> FloatArray:
    """Kgeo of the body's frame, from that of the inertial one and the moments."""
    turned = turn @ shapes
    change = element.stress_stiffening - element.spin_softening
    whole = shapes.T @ (change @ shapes + element.gyroscopic @ turned)
    # M L² = −LᵀM L, as a turn keeps M
    whole -= turned.T @ element.mass @ turned
    kept = whole + modal.second_kg[0, 0] + modal.second_kg[1, 1]
    return np.asarray(0.5 * (kept + kept.T))


def _node(element: Superelement, name: str, shapes: FloatArray) -> BodyFixedNode:
    motion = np.zeros((6, shapes.shape[1]))
    for row, coordinate in enumerate(element.coordinates):
        if coordinate.interface == name:
            motion[MOTIONS.index(coordinate.component)] = shapes[row]
    return BodyFixedNode(
        name=name,
        position_m=element.interface_node(name).position_m,
        translations=motion[:3],
        rotations=motion[3:],
    )


def body_fixed_limits(element: Superelement, form: BodyFixedForm) -> tuple[str, ...]:
    """Say what of a body is lost in its form in the body's frame, whatever the file."""
    sentences = [
        "Stiffening by spin about x and y, by acceleration and by interface forces is not known "
        "and is written as zero.",
        "Estimates of the error of the reduction are not written.",
    ]
    written = form.frequencies_hz.size
    all_of_them = element.size - int(np.count_nonzero(element.rigid_body_present))
    if written < all_of_them:
        sentences.append(
            f"{written} of {all_of_them} elastic modes are written, up to "
            f"{form.frequencies_hz[-1]:.6g} Hz; what the others give under load is lost."
        )
    for motion, (component, words) in _ELASTIC.items():
        if not element.rigid_body_present[motion]:
            sentences.append(
                f"The body has no {component} coordinates: in the file it is rigid in {words}."
            )
    sentences += _still_interfaces(element)
    if np.isfinite(element.maximum_speed_rad_s):
        sentences.append(
            f"The modes were made for speeds up to {element.maximum_speed_rad_s:.6g} rad/s, which "
            "the program that reads the file will not know."
        )
    return tuple(sentences)


def modal_damping_matrix(form: BodyFixedForm, modal_damping: float) -> FloatArray:
    """Return the damping matrix of modes with one ratio ζ from 0 to 1: diagonal 2 ζ ω, 1/s."""
    if not 0.0 <= modal_damping <= 1.0:
        raise SuperelementError(f"modal_damping is {modal_damping}, allowed are 0 to 1")
    return np.diag(4.0 * np.pi * modal_damping * form.frequencies_hz)


def _still_interfaces(element: Superelement) -> list[str]:
    """Say at which interfaces motions are missing that the body has."""
    able = [motion for motion, has in zip(MOTIONS, element.rigid_body_present, strict=True) if has]
    places: dict[str, list[str]] = {}
    for node in element.interfaces:
        has = element.components_at(node.name)
        missing = ", ".join(motion for motion in able if motion not in has)
        places.setdefault(missing, []).append(repr(node.name))
    return [
        f"Interfaces without coordinates {missing}: {', '.join(names)}. The modes do not move them "
        "in these, and nothing may be attached that loads them so."
        for missing, names in places.items()
        if missing
    ]
