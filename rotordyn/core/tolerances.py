"""Tolerances of the operator, its spectrum and its paths: value, meaning, source of each."""

from __future__ import annotations

import numpy as np

#: Unit roundoff.
EPS = float(np.finfo(float).eps)

# ---- the operator and its spectrum
#: Matrices are symmetric, or commute with a turn, up to this part of their largest entry: what
#: reduction leaves of the symmetry of a mesh (1e-11), with a margin.
SYMMETRIC = 1e-9
#: V is skew up to this part: rounding of the projections alone, as damping of 1e-9 is damping.
SKEW = 1e-13
#: Eigenvalues of M⁻¹K below this part of the largest are zero: a hundred roundings.
ZERO = 100 * EPS
#: Eigenvalues μ of the companion below this part of the largest belong to coordinates without
#: mass: the rounding of a μ = 0 in a Jordan block of two is the root of EPS, of one EPS.
INFINITE = 1e-13
#: A Rayleigh step beyond this part of a root is none: left and right vectors have no product.
STEP = 1e-4
#: P(s0) is singular if a pivot is below this: at most a root lies there, and another s0 is taken.
PIVOT = 1e-10
#: Roundings in a product yᴴ P x of three terms.
ROUNDINGS = 4.0

# ---- paths
#: Error of the trapezoid rule over |s| up to which two ends are one path: what is exchanged in a
#: step of that size is seen by its slopes.
DEFECT = 2e-3
#: Least share of one vector in the other, of two ends that are one path.
SHARE = 0.5
#: Where one vector is in the other by this share nothing is exchanged, and the error of the cubic,
#: about a tenth of that of the trapezoid rule, is what that limit means:
ALIKE = 0.9
DEFECT_ALIKE = 1e-2
#: How many times closer than any rival an end is that needs no share.
ALONE = 10.0
#: Part of DEFECT below which neither share nor rivals matter.
CERTAIN = 1e-3
#: The error of Re s is below this part of it, where its sign matters.
GROWTH = 0.3
#: Halvings of a first interval, after which a branch point is taken to lie inside.
HALVINGS = 14
#: Two levels couple if their coupling exceeds this part of the slower decay.
VEERING = 0.05
#: Newton's steps for an event end below this part of the parameter.
AT_REST = 1e-12
#: A root smaller than this many uncertainties is not told from zero.
UNRESOLVED = 4.0
#: A refined event is one if its function is zero to this part of |s|; its cubic may have made it.
EVENT = 1e-9
#: A motion above this damping ratio is followed by count only.
OVERDAMPED = 0.995
#: Where the sign of Re s matters, a root is followed whose decay and its change come this near to
#: the axis, as a part of |s|.
NEAR_AXIS = 0.02
