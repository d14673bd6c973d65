"""How fine a mesh and which element order an accuracy asks for, to begin with.

The mesh of a body of revolution then follows its own error estimate (`bodies.refinement`). The rule
is a-priori: at a re-entrant corner of 270° the error of a frequency falls with the corner's element
size h as h^1.09 (twice the exponent 0.5445 of the stress singularity of plane elasticity), whatever
the element order. The constants below were measured on the reference rotor of the verification page
against its converged frequencies.
"""

from __future__ import annotations

from dataclasses import dataclass

from solidwhirl.geometry import Body, symmetry
from solidwhirl.meshing import CORNER_RATE, MeshSize
from solidwhirl.scene.records import ModelSpec

# Relative error of the first bending frequency per (corner size / thickness)^CORNER_RATE.
_CORNER_ERROR = {2: 2.3e-2, 3: 8.9e-3, 4: 4.8e-3}
# The measured error of the reference rotor stays below the asked one by this factor.
_SAFETY = 2.0
# Bodies with features: relative error per (corner size / thickness)^rate, slower as their edges are
# not all refined.
_SOLID_ERROR, _SOLID_RATE = 2.5e-2, 0.8
# Error that the first of several adapted meshes is made for.
_FIRST_MESH = 5e-2
# Elements around bodies with features.
_AROUND = 12
# Sectors of bodies of revolution, whose errors fall with the fourth power of them: with 24 a
# thin drum had three times the error that it has with 40, and a finer meridian did not mend it.
_SECTORS, _FINE = 40, 2e-3
# Finest accuracy that the rule follows for bodies with features: beyond it the number of tetrahedra
# around every corner explodes. Sizes given in the scene can go further.
_FEATURE_FLOOR = 2e-3
# Stages of different counts are many, and most of their tetrahedra in thin blades, which bend as
# well with flat ones: elements through the thickness from this accuracy on.
_COARSE, _THROUGH_STAGES = 1e-2, 0.4


@dataclass(frozen=True, kw_only=True)
class Resolution:
    """Discretisation of one body."""

    degree: int
    size: MeshSize
    #: Relative error of the first bending frequencies that the rule expects; an expectation, not an
    #: estimate from the solution
    expected_error: float
    #: Whether the mesh follows its own error estimate from there
    is_adapted: bool = False


def _is_adapted(body: Body, model: ModelSpec) -> bool:
    """Sizes that the scene gives are kept; without estimates there is nothing to follow.

    Joined stages have one mesh size rule for all their parts.
    """
    given = (model.size_m, model.corner_size_m, model.growth)
    return symmetry(body) != "staged" and model.estimates == "on" and given == (None, None, None)


def choose_resolution(body: Body, level: str, model: ModelSpec) -> Resolution:
    """Choose element order and sizes to begin with; sizes given in the scene win.

    `model`: the scene's accuracy, and sizes and order if given.
    """
    thinnest, adapted = min(_thickness(body)), _is_adapted(body, model)
    if body.features:
        degree, growth, through = 2, 0.6, 1.2
        if symmetry(body) == "staged" and model.accuracy >= _COARSE:
            through = _THROUGH_STAGES
        wanted = max(model.accuracy, _FIRST_MESH if adapted else _FEATURE_FLOOR)
        constant, rate = _SOLID_ERROR, _SOLID_RATE
    elif adapted:
        degree = model.order or _adapted_order(level, model.accuracy)
        growth, through = 0.8, 1.0
        wanted = max(model.accuracy, _FIRST_MESH)
        constant, rate = _SAFETY * _CORNER_ERROR[degree], CORNER_RATE
    else:
        degree, growth, through = _fixed_order(level, model.accuracy)
        degree = model.order or degree
        wanted, constant, rate = model.accuracy, _SAFETY * _CORNER_ERROR[degree], CORNER_RATE
    share = (wanted / constant) ** (1.0 / rate)
    coarsest = 1.0 if adapted else 0.3
    corner = model.corner_size_m or thinnest * min(max(share, 1e-5), coarsest)
    if model.corner_size_m is None and model.size_m is not None:
        corner = min(corner, model.size_m)
    largest = model.size_m or 0.25 * _extent(body)
    size = MeshSize(
        size_m=max(largest, corner),
        corner_size_m=corner,
        growth=model.growth or growth,
        through_thickness=through,
        around=_AROUND if body.features else round(_SECTORS * (_FINE / model.accuracy) ** 0.25),
    )
    expected = constant * (corner / thinnest) ** rate
    return Resolution(degree=degree, size=size, expected_error=expected, is_adapted=adapted)


def _adapted_order(level: str, accuracy: float) -> int:
    """Element order of meshes that follow their error: the cheaper of 2 and 3, as measured."""
    return 2 if level == "solid" or accuracy >= 5e-3 else 3


def _fixed_order(level: str, accuracy: float) -> tuple[int, float, float]:
    """Element order, growth and elements through the thickness for the meridian."""
    if accuracy >= 1e-2:
        return 2, 0.8, 1.0
    if level == "solid":
        return 2, 0.7, 1.0
    if accuracy >= 1e-4:
        return 3, 0.7, 1.0
    return 4, 0.6, 1.0


def _thickness(body: Body) -> list[float]:
    """Smaller dimension of every section [m]."""
    out = []
    for s in body.sections:
        radial = [o - i for i, o in zip(s.inner_radius_m, s.outer_radius_m, strict=True)]
        out.append(min(s.end_m - s.start_m, max(radial)))
    return out


def _extent(body: Body) -> float:
    """Largest dimension of the meridian [m]."""
    length = max(s.end_m for s in body.sections) - min(s.start_m for s in body.sections)
    return max(length, max(max(s.outer_radius_m) for s in body.sections))
