"""Half of the coordinates where a system is the same in all directions: z = p + i s."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.arrays import (
    BoolArray,
    ComplexArray,
    FloatArray,
    IntArray,
    Matrix,
    ReadOnlyArrays,
)
from solidwhirl.rotordyn.core.dense import uncoupled

# Parts of a matrix that break the form may reach this fraction of its entries (scaled).
_ROUNDING = 1e-11
# Matrices of a form.
_SQUARE = (
    "mass",
    "gyroscopic",
    "stiffness",
    "centrifugal_stiffness",
    "damping",
    "circulatory",
)


class ComplexMatrices(NamedTuple):
    """Matrices of A z'' + V z' + B z = f at one speed, each (m, m); A is Hermitian."""

    mass: Matrix
    velocity: ComplexArray
    stiffness: ComplexArray


class IsotropicLaw(NamedTuple):
    """Relative motion of a bearing with a speed law per z, shape (m,), and its place."""

    motion: Matrix
    place: int


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class ComplexForm(ReadOnlyArrays):
    """Hold the lateral motion of an isotropic system in z = p + i s.

    A z'' + (c − iΩ g) z' + (k + Ω² k2 − iΩ ν) z = f_p + i f_s, plus −i ½ Ω' g z while the speed
    varies. All matrices are Hermitian, shape (m, m); real where motion in one plane stays in it, as
    in bodies with a plane of symmetry through the axis. z = z0 e^{iωt} whirls forward for ω > 0 and
    backward for ω < 0.

    Attributes
    ----------
    first, second, second_sign
        p = q[first] and s = second_sign · q[second], shape (m,): the sign turns a tilt rx into
        the partner of ry, so that p holds one plane.
    rest
        Indices of the coordinates that a turn does not move (axial motion and torsion).
    mass, gyroscopic, stiffness, centrifugal_stiffness, damping, circulatory
        A, g, k, k2, c, ν without the bearings that depend on the speed.
    laws
        Those bearings.
    """

    assembled: AssembledSystem
    first: IntArray
    second: IntArray
    second_sign: FloatArray
    rest: IntArray
    mass: Matrix
    gyroscopic: Matrix
    stiffness: Matrix
    centrifugal_stiffness: Matrix
    damping: Matrix
    circulatory: Matrix
    laws: tuple[IsotropicLaw, ...]

    @property
    def size(self) -> int:
        """Number of complex coordinates m."""
        return int(self.first.size)

    def part(self, at: IntArray) -> ComplexForm:
        """Return the form of some complex coordinates, which nothing joins to the others."""
        block = np.ix_(at, at)
        laws = (law._replace(motion=law.motion[at]) for law in self.laws)
        return replace(
            self,
            first=self.first[at],
            second=self.second[at],
            second_sign=self.second_sign[at],
            **{name: getattr(self, name)[block] for name in _SQUARE},
            laws=tuple(law for law in laws if law.motion.any()),
        )

    def to_complex(self, vectors: Matrix) -> ComplexArray:
        """Return p + i s of real vectors (motions or loads) of the independent coordinates.

        `vectors`: shape (n, ...), real. Returns shape (m, ...).
        """
        sign = self.second_sign.reshape(-1, *[1] * (vectors.ndim - 1))
        return np.asarray(vectors[self.first] + 1j * sign * vectors[self.second])

    def whirl_shapes(self, forward: ComplexArray, backward: ComplexArray) -> ComplexArray:
        """Return amplitudes q of q e^{iωt} from z = forward e^{iωt} + backward e^{-iωt}.

        `forward`, `backward`: circles that turn with and against +z, shape (m, ...). Returns
        complex amplitudes of the independent coordinates, shape (n, ...), zero in `rest`.
        """
        sign = self.second_sign.reshape(-1, *[1] * (forward.ndim - 1))
        other = backward.conj()
        out = np.zeros((self.assembled.size, *forward.shape[1:]), dtype=complex)
        out[self.first] = forward + other
        out[self.second] = -1j * sign * (forward - other)
        return out

    def hermitian_parts(self, speed_rad_s: float) -> tuple[Matrix, Matrix]:
        """Return k + Ω² k2 and c at a speed with all bearings, each (m, m)."""
        stiffness = self.stiffness + speed_rad_s**2 * self.centrifugal_stiffness
        damping = self.damping
        for law in self.laws:
            k, c = self.assembled.law_joints[law.place].coefficients(speed_rad_s)
            product = np.outer(law.motion.conj(), law.motion)
            stiffness = stiffness + k[0, 0] * product
            damping = damping + c[0, 0] * product
        return stiffness, damping

    def at_speed(self, speed_rad_s: float) -> ComplexMatrices:
        """Return A, c − iΩ g and k + Ω² k2 − iΩ ν at a speed.

        `speed_rad_s`: Ω, rad/s. With the bearings that depend on the speed.
        """
        stiffness, damping = self.hermitian_parts(speed_rad_s)
        return ComplexMatrices(
            mass=self.mass,
            velocity=damping - 1j * speed_rad_s * self.gyroscopic,
            stiffness=stiffness - 1j * speed_rad_s * self.circulatory,
        )


@lru_cache(maxsize=8)
def lateral_parts(form: ComplexForm) -> tuple[IntArray, ...]:
    """Return the groups of complex coordinates that nothing joins, each rising."""
    motions = [law.motion for law in form.laws]
    return tuple(uncoupled(*(getattr(form, name) for name in _SQUARE), motions=motions))


class Pairs(NamedTuple):
    """p = q[first], s = sign · q[second], and the coordinates that do not turn."""

    first: IntArray
    second: IntArray
    sign: FloatArray
    rest: IntArray


# A system is a record that never changes; its form is wanted at every speed of an analysis.
@lru_cache(maxsize=4)
def complex_form(assembled: AssembledSystem) -> ComplexForm | None:
    """Return the complex form of a system, None where it has none.

    None if bodies do not know how they turn or are not the same after a turn, or a bearing is not
    the same in x and y, or couples them, or lateral motion couples to axial motion or torsion.

    Genta 2005, Dynamics of Rotating Systems, section 3.4 (complex coordinates).
    """
    return matrix_form(assembled) if _has_isotropic_joints(assembled) else None


def matrix_form(assembled: AssembledSystem) -> ComplexForm | None:
    """Return the complex form of the matrices of a system, whatever its bearings are.

    `assembled`: one from whose matrices all that bearings have of another kind has been taken out.
    The result is as `complex_form`.
    """
    pairs = plane_pairs(assembled)
    if pairs is None or not pairs.first.size:
        return None
    found: dict[str, _Part | None] = {}
    for name in ("mass", "stiffness", "centrifugal_stiffness", "damping"):
        found[name] = _same(getattr(assembled, name), pairs)
    for name in ("gyroscopic", "circulatory_stiffness"):
        found[name] = _crossed(getattr(assembled, name), pairs)
    laws = _isotropic_laws(assembled, pairs)
    parts = {name: part for name, part in found.items() if part is not None}
    if laws is None or len(parts) < len(found):
        return None
    # beside one that is complex nothing is saved by leaving out the rounding of the others, which
    # a sharp resonance shows thousands of times larger
    is_real = all(part.is_real for part in parts.values())
    matrices = {
        name: part.matrix.real.copy() if is_real else part.matrix for name, part in parts.items()
    }
    return ComplexForm(
        assembled=assembled,
        first=pairs.first,
        second=pairs.second,
        second_sign=pairs.sign,
        rest=pairs.rest,
        mass=matrices["mass"],
        stiffness=matrices["stiffness"],
        centrifugal_stiffness=matrices["centrifugal_stiffness"],
        damping=matrices["damping"],
        gyroscopic=matrices["gyroscopic"],
        circulatory=matrices["circulatory_stiffness"],
        laws=laws,
    )


def plane_pairs(assembled: AssembledSystem) -> Pairs | None:
    """Return pairs of coordinates that turn into each other, those of one plane first.

    The result is with L p = s and L s = −p; None if the system does not know how it turns.
    """
    generator = assembled.spin_generator
    if generator is None or not np.array_equal(generator, -generator.T):
        return None
    per_row = np.abs(generator).sum(axis=1)
    if not np.isin(generator, (-1.0, 0.0, 1.0)).all() or not np.isin(per_row, (0.0, 1.0)).all():
        return None
    partner = np.abs(generator).argmax(axis=0)
    first = np.array([j for j in np.flatnonzero(per_row) if generator[partner[j], j] == 1.0], int)
    second = partner[first]
    planes = _planes(assembled, first, second)
    return Pairs(
        first=np.where(planes, second, first),
        second=np.where(planes, first, second),
        sign=np.where(planes, -1.0, 1.0),
        rest=np.flatnonzero(per_row == 0),
    )


def _planes(assembled: AssembledSystem, first: IntArray, second: IntArray) -> BoolArray:
    """Tell which pairs are to be read as (s, −p), so that all p couple among themselves.

    Goes through the pairs along their strongest couplings in M and K.
    """
    diagonal = [np.sqrt(np.abs(np.diag(m))) for m in (assembled.mass, assembled.stiffness)]
    scaled = [
        np.abs(m) / np.maximum(np.outer(d, d), 1e-300)
        for m, d in zip((assembled.mass, assembled.stiffness), diagonal, strict=True)
    ]
    coupling = np.maximum(*scaled)
    straight, crossed = coupling[np.ix_(first, first)], coupling[np.ix_(first, second)]
    swapped = np.zeros(first.size, dtype=bool)
    waiting = set(range(first.size))
    done: list[int] = []
    while waiting:
        candidates = sorted(waiting)
        nearest = candidates[0]
        if done:
            strength = np.maximum(straight, crossed)[np.ix_(done, candidates)]
            row, column = np.unravel_index(int(strength.argmax()), strength.shape)
            if strength[row, column] > _ROUNDING:
                nearest, source = candidates[column], done[row]
                other = crossed[source, nearest] > straight[source, nearest]
                swapped[nearest] = swapped[source] ^ other
        done.append(nearest)
        waiting.remove(nearest)
    return swapped


def _block(matrix: FloatArray, rows: IntArray, columns: IntArray) -> FloatArray:
    return np.asarray(matrix[np.ix_(rows, columns)])


def _vanishes(part: FloatArray, matrix: FloatArray, rows: IntArray, columns: IntArray) -> bool:
    """Whether a part of a matrix is rounding beside its diagonal, or its largest entry."""
    diagonal = np.sqrt(np.abs(np.diag(matrix)))
    largest = float(np.abs(matrix).max(initial=0.0))
    scale = np.maximum(np.outer(diagonal[rows], diagonal[columns]), 1e-3 * _ROUNDING * largest)
    return bool((np.abs(part) <= _ROUNDING * scale + 1e-15 * largest).all())


class _Part(NamedTuple):
    """A Hermitian matrix in z, and whether its imaginary part is rounding."""

    matrix: ComplexArray
    is_real: bool


def _same(matrix: FloatArray, pairs: Pairs) -> _Part | None:
    """Return a = P − iQ of the symmetric [[P, Q], [−Q, P]].

    None if a turn changes the matrix, or it couples to what does not turn.
    """

    def is_rounding(part: FloatArray, rows: IntArray, columns: IntArray) -> bool:
        return _vanishes(part, matrix, rows, columns)

    found = _turning_parts(matrix, pairs, is_rounding)
    if found is None:
        return None
    along, across = found
    return _hermitian(along, -across, is_rounding(across, pairs.first, pairs.second))


def _crossed(matrix: FloatArray, pairs: Pairs) -> _Part | None:
    """Return b = Q + iP of [[P, Q], [−Q, P]] = −i b in z; None as above."""
    limit = _ROUNDING * np.abs(matrix).max(initial=0.0)

    def is_rounding(part: FloatArray, rows: IntArray, columns: IntArray) -> bool:
        return bool(np.abs(part).max(initial=0.0) <= limit)

    found = _turning_parts(matrix, pairs, is_rounding)
    if found is None:
        return None
    along, across = found
    return _hermitian(across, along, is_rounding(along, pairs.first, pairs.first))


def _turning_parts(
    matrix: FloatArray,
    pairs: Pairs,
    is_rounding: Callable[[FloatArray, IntArray, IntArray], bool],
) -> tuple[FloatArray, FloatArray] | None:
    """Return P and Q of [[P, Q], [−Q, P]]; None of another matrix."""
    first, second, sign, rest = pairs
    in_p = _block(matrix, first, first)
    in_s = np.outer(sign, sign) * _block(matrix, second, second)
    upper = _block(matrix, first, second) * sign
    lower = sign[:, None] * _block(matrix, second, first)
    zero = [(in_p - in_s, first, second), (upper + lower, first, second)]
    zero += [(_block(matrix, side, rest), side, rest) for side in (first, second)]
    zero += [(_block(matrix, rest, side), rest, side) for side in (first, second)]
    if not all(is_rounding(*part) for part in zero):
        return None
    return 0.5 * (in_p + in_s), 0.5 * (upper - lower)


def _hermitian(real: FloatArray, imaginary: FloatArray, is_real: bool) -> _Part | None:
    """Return a matrix; None if it, without an imaginary part that is rounding, is not Hermitian."""
    matrix = real + 1j * imaginary
    judged: Matrix = real if is_real else matrix
    error = np.abs(judged - judged.conj().T).max()
    if error > _ROUNDING * np.abs(judged).max(initial=0.0):
        return None
    return _Part(np.asarray(0.5 * (matrix + matrix.conj().T), dtype=complex), is_real)


def _isotropic_laws(assembled: AssembledSystem, pairs: Pairs) -> tuple[IsotropicLaw, ...] | None:
    """Return the speed-dependent bearings as complex motions, None if one is not isotropic."""
    laws = []
    for place, joint in enumerate(assembled.law_joints):
        along_x, along_y = joint.motion[:, pairs.first], joint.motion[:, pairs.second] * pairs.sign
        limit = _ROUNDING * np.abs(joint.motion).max(initial=0.0)
        if not (along_x.any() or along_y.any()) and joint.pieces is not None:
            continue  # on axial motion
        uneven = np.array([along_x[0] - along_y[1], along_x[1] + along_y[0]])
        if (np.abs(uneven) > limit).any() or joint.motion[:, pairs.rest].any():
            return None
        if joint.pieces is None or not joint.pieces.is_isotropic:
            return None
        # x + i y of the bearing per z; either plane may be p, so that it may be i times a real one
        is_some = (np.abs(along_x) > limit).any(axis=1)
        motion: Matrix = (
            along_x[0] + 1j * along_x[1] if is_some.all() else along_x[is_some.argmax()]
        )
        laws.append(IsotropicLaw(motion=motion, place=place))
    return tuple(laws)


def _has_isotropic_joints(assembled: AssembledSystem) -> bool:
    """Whether every constant bearing is the same in all directions, and no gear pushes sideways.

    By their own numbers: beside a stiff shaft a cross term may be rounding in the sum.
    """
    for bearing in assembled.system.bearings:
        for matrix in bearing.matrices():
            for plane in (slice(0, 2), slice(3, 5)):
                block = matrix[plane, plane]
                has_law = bearing.speed_law is not None and plane.start == 0
                if not has_law and not np.array_equal(block, block[0, 0] * np.eye(2)):
                    return False
    return all(gear.line_of_action_rad is None for gear in assembled.system.gears)
