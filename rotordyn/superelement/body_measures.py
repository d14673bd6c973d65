"""How far a superelement is from what must hold for any body, as relative numbers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.core.arrays import FloatArray, motion_at
from solidwhirl.rotordyn.superelement.free_body import free_body_matrices
from solidwhirl.rotordyn.superelement.record import Superelement
from solidwhirl.rotordyn.superelement.rigid_body import RIGID_TURN, body_mass_matrix
from solidwhirl.rotordyn.superelement.validation import MOTIONS

# Modal coordinates slower than this part of the fastest are rigid motions that are not held.
_AT_REST = 1e-6
# ε_cab: (a × b)_c = ε_cab a_a b_b
CROSS = np.zeros((3, 3, 3))
for _a, _b, _c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    CROSS[_c, _a, _b], CROSS[_c, _b, _a] = 1.0, -1.0
CROSS.setflags(write=False)
# A coordinate softer than this part of the stiffest is scaled by its mass.
_SOFT = 1e-3


def asymmetry(matrix: FloatArray, sign: float) -> float:
    """Return the largest entry of A − sign · Aᵀ, shape (n, n), over the largest of A."""
    largest = float(np.abs(matrix).max(initial=0.0))
    return float(np.abs(matrix - sign * matrix.T).max()) / largest if largest > 0 else 0.0


def smallest_inertia(element: Superelement) -> float:
    """Return the smallest eigenvalue of M scaled to a unit diagonal."""
    mass = element.mass
    # the coordinates of a tied body are no independent ones; its free motions are
    tie = element.constraint
    return least_inertia(mass if tie is None else tie.T @ mass @ tie)


def least_inertia(mass: FloatArray) -> float:
    """Return the smallest eigenvalue of M with a unit diagonal, or its least diagonal entry."""
    diagonal = np.diag(mass)
    if not (diagonal > 0).all():
        return float(diagonal.min())
    root = np.sqrt(diagonal)
    return float(la.eigvalsh(mass / np.outer(root, root))[0])


def negative_part(element: Superelement, matrix: FloatArray) -> float:
    """Return the most negative eigenvalue over the largest, scaled by the diagonal of M."""
    diagonal = np.diag(element.mass)
    if not (diagonal > 0).all():
        return float("inf")
    root = np.sqrt(diagonal)
    values = la.eigvalsh(matrix / np.outer(root, root))
    largest = float(np.abs(values).max())
    return max(0.0, -float(values[0])) / largest if largest > 0 else 0.0


def interface_error(element: Superelement) -> float:
    """Return the largest deviation from t + θ × x, tilts compared over the body's size."""
    size = max((float(np.abs(n.position_m).max()) for n in element.interfaces), default=0.0) or 1.0
    error = 0.0
    for row, coordinate in enumerate(element.coordinates):
        if coordinate.kind != "interface":
            continue
        expected = motion_at(element.interface_node(coordinate.interface).position_m)
        difference = element.rigid_body_modes[row] - expected[MOTIONS.index(coordinate.component)]
        scale = np.array([1.0, 1.0, 1.0, size, size, size])
        present = element.rigid_body_present
        unit = 1.0 if coordinate.component in MOTIONS[:3] else 1.0 / size
        error = max(error, float(np.abs(difference / scale / unit)[present].max()))
    return error


class PropertyError(NamedTuple):
    """Largest error of RᵀMR, the motion it belongs to, and both numbers."""

    error: float
    motion: str
    found: float
    expected: float


def property_error(element: Superelement) -> PropertyError:
    """Return the largest difference of RᵀMR from the rigid body's, scaled by its diagonal."""
    present = np.flatnonzero(element.rigid_body_present)
    modes = element.rigid_body_modes[:, present]
    expected = body_mass_matrix(element)[np.ix_(present, present)]
    root = np.sqrt(np.maximum(np.diag(expected), np.finfo(float).tiny))
    found = modes.T @ element.mass @ modes
    error = np.abs(found - expected) / np.outer(root, root)
    row, column = np.unravel_index(int(error.argmax()), error.shape)
    motion = MOTIONS[present[max(row, column)]]
    return PropertyError(
        float(error[row, column]), motion, float(found[row, column]), float(expected[row, column])
    )


def tilt_error(element: Superelement) -> float:
    """Return the relative difference of RᵀGR from [[0, Ip], [−Ip, 0]] on rx and ry.

    In the rotating frame that is Ip − Ix − Iy about the origin, over the largest of them.
    """
    tilts = element.rigid_body_modes[:, [3, 4]]
    polar = size = float(element.inertia_kg_m2[2, 2])
    if element.frame == "rotating":
        about = np.diag(body_mass_matrix(element)[3:, 3:])
        polar, size = float(about[2] - about[0] - about[1]), float(about.max())
    expected = polar * np.array([[0.0, 1.0], [-1.0, 0.0]])
    error = float(np.abs(tilts.T @ element.gyroscopic @ tilts - expected).max())
    return error / size if size > 0.0 else np.inf if error else 0.0


def mass_moment_error(element: Superelement) -> float | None:
    """Return the largest difference of Σ_a ∫ φ_aj φ_ak dm from M.

    `element`: the body; M with a positive diagonal. The result is in coordinates of unit inertia;
    None without moments.
    """
    if element.moments is None:
        return None
    root = np.sqrt(np.diag(element.mass))
    whole = np.einsum("aajk->jk", element.moments.second_kg)
    return float((np.abs(whole - element.mass) / np.outer(root, root)).max())


def rigid_moment_error(element: Superelement) -> float | None:
    """Return how far moments are from what M and each other say for rigid motions.

    `element`: the body; M with a positive diagonal. Returns largest difference of ∫ φ and ∫ x × φ
    from RᵀM, and of the second moments with a rigid motion from those of lower order, each over the
    root of both inertias; None without moments or rigid motions.
    """
    present = np.flatnonzero(element.rigid_body_present)
    if element.moments is None or not present.size:
        return None
    moments, modes = element.moments, element.rigid_body_modes[:, present]
    simple, first = moments.displacement_kg, moments.first_kg_m
    momentum = np.concatenate((simple, np.einsum("cab,abj->cj", CROSS, first)))[present]
    products = np.concatenate(
        (
            np.einsum("bc,aj->abjc", np.eye(3), simple),
            np.einsum("bcd,daj->abjc", CROSS, first),
        ),
        axis=3,
    )[..., present]
    own = np.sqrt(np.diag(element.mass))
    rigid = np.sqrt(np.diag(modes.T @ element.mass @ modes))
    scale = np.outer(own, rigid)
    errors = (
        (momentum.T - element.mass @ modes) / scale,
        (moments.second_kg @ modes - products) / scale,
    )
    return float(max(np.abs(error).max() for error in errors))


def gyroscopic_moment_error(element: Superelement) -> float | None:
    """Return the difference of G + 2 M L from 2 ∫ φ_i·(n × φ_j) dm, n along +z.

    `element`: the body; M with a positive diagonal. Returns largest entry in coordinates of unit
    inertia, over that of 2 M L, in the motions that a tie leaves; None for bodies that do not know
    L or their moments. A solid's mesh mixes circumferential orders, the more the higher a mode:
    there the elastic energy at the lowest frequency of the free body counts with the inertia. In
    the rotating frame L is 0, and G is compared with its own size.
    """
    moments, turn = element.moments, element.turn
    if moments is None or turn is None:
        return None
    # tied coordinates alone do not turn: L then means nothing outside of free motions
    tie = np.eye(len(turn)) if element.constraint is None else element.constraint
    across = 2.0 * (moments.second_kg[1, 0] - moments.second_kg[0, 1])
    size = np.diag(tie.T @ element.mass @ tie)
    if element.level == "solid" and element.free_frequencies_hz.size:
        lowest = 2.0 * np.pi * float(element.free_frequencies_hz.min())
        size = size + np.diag(tie.T @ element.stiffness @ tie) / lowest**2
    scale = np.sqrt(np.outer(size, size))
    turned = tie.T @ (2.0 * element.mass @ turn) @ tie / scale
    compared = turned if turn.any() else tie.T @ element.gyroscopic @ tie / scale
    largest = float(np.abs(compared).max())
    rest = tie.T @ (element.gyroscopic - across) @ tie / scale
    error = float(np.abs(rest + turned).max())
    return error / largest if largest > 0 else error


def picture_error(element: Superelement) -> float | None:
    """Return how far the points of pictures are from t + θ × x in rigid motion.

    Returns relative to the size of the body; None without points or rigid motions. Points of beams
    and rigid bodies lie on their coordinates.
    """
    points, present = element.recovery_points_m, element.rigid_body_present
    if not len(points) or not present.any():
        return None
    expected = motion_at(points)[:, :3]
    shown = np.tensordot(element.recovery_modes, element.rigid_body_modes, axes=1)
    size = float(np.abs(points).max()) or 1.0
    scale = np.array([1.0, 1.0, 1.0, size, size, size])
    return float((np.abs(shown - expected) / scale)[:, :, present].max())


def turn_error(element: Superelement) -> float | None:
    """Return how far the matrices change in a turn of the whole field about the axis.

    `element`: the body; M positive definite. Returns largest entry of LᵀA + A L, L the spin
    generator, in coordinates of unit diagonal, over all matrices A; and of L R less R turned, R the
    rigid motions. None for bodies that do not know L and for lumped ones, which need not be bodies
    of revolution.
    """
    generator = element.spin_generator
    if generator is None or element.level == "lumped":
        return None
    tie = element.constraint
    turn = generator if tie is None else la.lstsq(tie, generator @ tie)[0]

    def free(name: str) -> FloatArray:
        """A matrix in the motions that a tie leaves."""
        matrix: FloatArray = getattr(element, name)
        return matrix if tie is None else np.asarray(tie.T @ matrix @ tie)

    inertia, stiffness = np.diag(free("mass")), free("stiffness")
    rate = np.abs(np.diag(stiffness)) / inertia
    # as in the assembly: coordinates of unit stiffness, soft ones of unit mass
    stiff = np.sqrt(np.maximum(rate, _SOFT * (float(rate.max()) or 1.0)) * inertia)
    error = _change(stiffness, turn, stiff)
    for name in ("mass", "gyroscopic", "stress_stiffening", "spin_softening"):
        error = max(error, _change(free(name), turn, np.sqrt(inertia)))
    if tie is not None:
        error = max(error, float(np.abs(generator @ tie - tie @ turn).max() / np.abs(tie).max()))
    motions = element.rigid_body_modes
    difference = np.abs(generator @ motions - motions @ RIGID_TURN)[:, element.rigid_body_present]
    return max(error, float(difference.max(initial=0.0)) / max(1.0, float(np.abs(motions).max())))


def _change(matrix: FloatArray, turn: FloatArray, size: FloatArray) -> float:
    """Return LᵀA + A L of a matrix scaled by `size` on both sides, over its largest entry."""
    scale = np.outer(size, size)
    largest = float(np.abs(matrix / scale).max())
    change = np.abs((turn.T @ matrix + matrix @ turn) / scale).max()
    return float(change) / largest if largest > 0 else 0.0


def modal_frequency_error(element: Superelement) -> float | None:
    """Return how far the modal block is from the frequencies its coordinates are named after.

    `element`: the body; M positive definite. Returns largest relative error of the squares of the
    frequencies with all interfaces held; None without modal coordinates, or where they have no
    frequencies.
    """
    modal = np.array([c.kind == "modal" for c in element.coordinates])
    if not modal.any():
        return None
    named = np.sort([c.frequency_hz for c in element.coordinates if c.kind == "modal"])
    if not named.any():
        return None
    block = np.ix_(modal, modal)
    found = la.eigvalsh(element.stiffness[block], element.mass[block])
    expected = (2.0 * np.pi * named) ** 2
    elastic = named > _AT_REST * named[-1]
    return float((np.abs(found - expected)[elastic] / expected[elastic]).max())


def lost_stiffness(element: Superelement) -> float:
    """Return the largest part of its elastic stiffness that a body loses at its top speed.

    `element`: the body; M positive definite, with a finite top speed. Returns −Ω² min θ, (Kgeo − S)
    x = θ K x over the elastic free modes x: K + Ω²(Kgeo − S) is positive if it is below 1, and the
    stiffness is lost at Ω over its root. Negative if all motions stiffen. In the rotating frame
    that of Kgeo alone.
    """
    matrices = free_body_matrices(element)
    tie = np.eye(element.size) if element.constraint is None else element.constraint
    stiffness, mass, change = (
        tie.T @ matrix @ tie
        for matrix in (matrices.stiffness, matrices.mass, matrices.centrifugal_stiffness)
    )
    if element.frame == "rotating":
        # a body that runs above a critical speed is held by Coriolis forces
        change = tie.T @ element.stress_stiffening @ tie
    if not change.any():
        return 0.0
    values, vectors = la.eigh(stiffness, mass)
    rigid = int(np.count_nonzero(element.rigid_body_present))
    if values.size <= rigid or values[rigid] <= 0.0:
        return 0.0 if values.size <= rigid else float("inf")
    elastic = vectors[:, rigid:] / np.sqrt(values[rigid:])
    theta = la.eigvalsh(elastic.T @ change @ elastic)
    return float(-theta[0] * element.maximum_speed_rad_s**2)
