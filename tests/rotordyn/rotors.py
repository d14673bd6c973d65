"""Rotors that several tests share, each made by a function."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn import (
    Bearing,
    Coordinate,
    Disk,
    End,
    InterfaceNode,
    PolynomialLaw,
    Rotor,
    Superelement,
    TableLaw,
    assemble,
    beam_superelement,
    matrices_at_speed,
    rigid_superelement,
)
from solidwhirl.rotordyn.superelement.mass_moments import projected_moments
from solidwhirl.rotordyn.superelement.record import ErrorForm
from solidwhirl.rotordyn.superelement.validation import MOTIONS

STEEL = (2e11, 0.3, 7800.0)


def ground(body, interface, kx, ky=None, cx=0.0, cy=None, **options):
    stiffness, damping = (kx, kx if ky is None else ky), (cx, cx if cy is None else cy)
    place = f"{body}.{interface}"
    return connect(place, place, stiffness=stiffness, damping=damping, **options)


def pinned(body, interface):
    return connect(f"{body}.{interface}", f"{body}.{interface}", rigid=("ux", "uy"))


def one_rotor(element, bearings=(), ratio=1.0, **options):
    return assemble({"rotor": turning(element, ratio, **options)}, tuple(bearings))


def between_bearings(element, *own, ratio=1.0, inside=None, more=(), **options):
    """Rotor on a bearing `own`, `options` at either end, left and right, and on `more`."""
    held = [ground("rotor", end, *own, **options) for end in ("left", "right")]
    return one_rotor(element, [*held, *more], ratio, internal_damping=inside)


def steel_shaft(name, stations, outer, interfaces, disks=(), inner=0.0, material=STEEL, **options):
    """Beam of steel; `disks`: position, mass, polar and diametral inertia of each."""
    wheels = [
        Disk(name=f"disk {k}", position_m=z, mass_kg=m, polar_kg_m2=polar, diametral_kg_m2=across)
        for k, (z, m, polar, across) in enumerate(disks)
    ]
    own = (stations, outer, inner, material, interfaces, wheels)
    return beam_superelement(name, *own, **options)


def state_eigenvalues(mass, velocity, stiffness, unit=1.0):
    """All eigenvalues by the state matrix of (unit·q, q'); a `unit` near |λ| keeps digits."""
    zero, one = np.zeros_like(mass), np.eye(len(mass))
    below = [-la.solve(mass, stiffness) / unit, -la.solve(mass, velocity)]
    return la.eigvals(np.block([[zero, unit * one], below]))


def eigenvalues_of(system, speed, unit=1.0):
    """All eigenvalues of a system at a speed by its state matrix."""
    mass, damping, gyroscopic, stiffness = matrices_at_speed(system, speed)
    return state_eigenvalues(mass, damping + gyroscopic, stiffness, unit)


def _lumped(name, mass, stiffness, gyroscopic, modal=0, **own):
    """Body with ux, uy, rx, ry of one hub at z = 0, then modal coordinates; `own` replaces."""
    n = len(mass)
    at_hub = {"kind": "interface", "interface": "hub", "frequency_hz": 0.0}
    held = [Coordinate(component=c, **at_hub) for c in ("ux", "uy", "rx", "ry")]
    free = Coordinate(kind="modal", interface="", component="q", frequency_hz=1.0)
    zero, none = np.zeros((n, n)), np.empty(0)
    parts = {
        "coordinates": (*held, *[free] * modal), "rigid_body_modes": np.zeros((n, 6)),
        "rigid_body_present": np.zeros(6, dtype=bool), "mass_kg": 1.0, "inertia_kg_m2": np.eye(3),
        **own,
    }  # fmt: skip
    return Superelement(
        name=name, level="lumped", harmonics=(), mass=mass, stiffness=stiffness,
        interfaces=(InterfaceNode(name="hub", position_m=np.zeros(3), coupling="none"),),
        gyroscopic=gyroscopic, stress_stiffening=zero, spin_softening=zero, full_dofs=n,
        center_of_gravity_m=np.zeros(3), maximum_speed_rad_s=np.inf,
        recovery_points_m=np.zeros((0, 3)), recovery_modes=np.zeros((0, 3, n)),
        free_frequencies_hz=none, fixed_interface_frequencies_hz=none,
        frequency_error_estimate=none, **parts,
    )  # fmt: skip


def hub(
    mass_kg=10.0, polar_kg_m2=0.1, diametral_kg_m2=0.05, stiffness=None, name="disk", present=None
):
    """Rigid disk at z = 0 with ux, uy, rx, ry; `stiffness` (4, 4) ties it to the ground."""
    held = stiffness is not None
    motion, gyroscopic = np.zeros((4, 6)), np.zeros((4, 4))
    motion[[0, 1, 2, 3], [0, 1, 3, 4]] = 1.0
    gyroscopic[2, 3], gyroscopic[3, 2] = polar_kg_m2, -polar_kg_m2
    free = np.array([True, True, False, True, True, False]) & (not held)
    return _lumped(
        name,
        np.diag([mass_kg, mass_kg, diametral_kg_m2, diametral_kg_m2]),
        np.asarray(stiffness) if held else np.zeros((4, 4)),
        gyroscopic,
        rigid_body_modes=motion,
        rigid_body_present=free if present is None else present,
        mass_kg=mass_kg,
        inertia_kg_m2=np.diag([diametral_kg_m2, diametral_kg_m2, polar_kg_m2]),
    )


def general(mass, stiffness, gyroscopic):
    """Body held to the ground with any matrices: ux, uy, rx, ry of one hub, then modal ones."""
    return _lumped("general", mass, stiffness, gyroscopic, len(mass) - 4)


def lumped_hub(name, matrices, components, generator):
    """Body with motions of one hub at z = 0, then modal coordinates; free in those motions."""
    n, held = len(matrices["mass"]), len(components)
    place = [MOTIONS.index(c) for c in components]
    motion, present = np.zeros((n, 6)), np.zeros(6, dtype=bool)
    motion[np.arange(held), place], present[place] = 1.0, True
    at_hub = {"kind": "interface", "interface": "hub", "frequency_hz": 0.0}
    free = Coordinate(kind="modal", interface="", component="q", frequency_hz=0.0)
    own = _lumped(name, *(matrices[m] for m in ("mass", "stiffness", "gyroscopic")), n - 4)
    return dataclasses.replace(
        own,
        coordinates=(
            *[Coordinate(component=c, **at_hub) for c in components], *[free] * (n - held),
        ),
        stress_stiffening=matrices["stress_stiffening"],
        spin_softening=matrices["spin_softening"],
        rigid_body_modes=motion,
        rigid_body_present=present,
        spin_generator=generator,
    )  # fmt: skip


def plane_spring(translation, coupling, tilt):
    """Stiffness (4, 4) on ux, uy, rx, ry that is equal in both planes: (ux, ry) and (uy, −rx)."""
    stiffness = np.diag([translation, translation, tilt, tilt]).astype(float)
    stiffness[0, 3] = stiffness[3, 0] = coupling
    stiffness[1, 2] = stiffness[2, 1] = -coupling
    return stiffness


def with_axial_and_torsion(shaft, length_m, radius_m, first, second):
    """Add uz and rz at two interfaces of a beam element: one rod element each, consistent mass."""
    area, polar = np.pi * radius_m**2, np.pi * radius_m**4 / 2
    spring, inertia = np.array([[1.0, -1.0], [-1.0, 1.0]]), np.array([[2.0, 1.0], [1.0, 2.0]]) / 6
    added = [
        Coordinate(kind="interface", interface=at, component=c, frequency_hz=0.0)
        for c in ("uz", "rz")
        for at in (first, second)
    ]
    held = sum(c.kind == "interface" for c in shaft.coordinates)
    order = [*range(held), *range(shaft.size, shaft.size + 4), *range(held, shaft.size)]

    def grown(matrix, block):
        return la.block_diag(matrix, block)[np.ix_(order, order)]

    mass = la.block_diag(7800 * area * length_m * inertia, 7800 * polar * length_m * inertia)
    modulus, shear = 2e11, 2e11 / 2.6
    stiffness = la.block_diag(modulus * area * spring, shear * polar * spring) / length_m
    motions = np.zeros((shaft.size + 4, 6))
    motions[: shaft.size] = shaft.rigid_body_modes
    motions[shaft.size : shaft.size + 2, 2] = motions[shaft.size + 2 :, 5] = 1.0
    coordinates = (*shaft.coordinates, *added)
    zero = np.zeros((4, 4))
    return dataclasses.replace(
        shaft,
        coordinates=tuple(coordinates[i] for i in order),
        mass=grown(shaft.mass, mass),
        stiffness=grown(shaft.stiffness, stiffness),
        gyroscopic=grown(shaft.gyroscopic, zero),
        stress_stiffening=grown(shaft.stress_stiffening, zero),
        spin_softening=grown(shaft.spin_softening, zero),
        rigid_body_modes=motions[order],
        rigid_body_present=np.ones(6, dtype=bool),
        recovery_points_m=np.zeros((0, 3)),
        recovery_modes=np.zeros((0, 3, shaft.size + 4)),
        spin_generator=grown(shaft.spin_generator, zero),
        moments=None,
        error_forms=(),
    )


@cache
def three_disk_element(splits=1):
    """Lalanne-Ferraris three-disk rotor, as in Code_Aster SDLL124; 13 elements times splits."""
    disks = [
        (0.2, 14.58013, 0.1232021, 0.0646386),
        (0.5, 45.94579, 0.976348, 0.497746),
        (1.0, 55.13495, 1.171618, 0.602349),
    ]
    stations = np.linspace(0.0, 1.3, 13 * splits + 1)
    return steel_shaft("three-disk", stations, 0.05, {"left": 0.0, "right": 1.3}, disks)


def three_disk(cx=700.0, cy=500.0):
    return between_bearings(three_disk_element(), 7e7, 5e7, cx, cy)


@cache
def twin_bodies():
    """Inner and outer rotor of the coaxial twin rotor, disks as rigid bodies at nodes."""
    inner_disk = (0.4 / 3, 16.2464, 0.186022, 0.0942293)
    outer_disk = (0.4 * 13 / 15, 6.45079, 0.0362051, 0.0185863)
    c = 0.8 / 3
    places = {"A": 0.0, "C": c, "B": 0.4}
    inner = steel_shaft("inner", np.linspace(0, 0.4, 13), 0.02, places, [inner_disk])
    ends = {"C": c, "D": 0.4}
    outer = steel_shaft("outer", np.linspace(c, 0.4, 6), 0.035, ends, [outer_disk], 0.03)
    return inner, outer


def twin_bearings(support=1e10, joint=None):
    """Supports at A, B, D; spring to ground in x at C; joint of the shafts at C, None is rigid."""

    def of(stiffness):
        return {"rigid": ("ux", "uy")} if stiffness is None else {"stiffness": stiffness}

    held = [connect(at, at, **of(support)) for at in ("inner.A", "inner.B", "outer.D")]
    shafts = connect("C", "inner.C", "outer.C", **of(joint))
    return (*held, ground("inner", "C", 8e6, 0.0), shafts)


def twin_rotors(ratio, inner_ratio=1.0, bodies=None, **damping):
    """Rotors of the twin or of other `bodies`; `damping` is that inside the inner one."""
    inner, outer = twin_bodies() if bodies is None else bodies
    return {"inner": turning(inner, inner_ratio, **damping), "outer": turning(outer, ratio)}


def twin(ratio=-1.0, support=1e10, joint=None, inner_ratio=1.0):
    return assemble(twin_rotors(ratio, inner_ratio), twin_bearings(support, joint))


def with_stress(element, factor):
    """Add Kgeo − S that vanishes in rigid motion: the mass matrix of the elastic motion, scaled."""
    modes = element.rigid_body_modes[:, element.rigid_body_present]
    out = np.eye(element.size) - modes @ la.pinv(modes)
    even = factor * out.T @ element.mass @ out
    return dataclasses.replace(
        element,
        stress_stiffening=element.mass + 0.5 * (even + even.T),
        spin_softening=element.mass,
    )


def turning_pairs(element):
    """Coordinates p and s with L p = s and L s = −p."""
    first = np.flatnonzero((element.spin_generator == 1.0).any(axis=0))
    return first, np.abs(element.spin_generator[:, first]).argmax(axis=0)


def in_the_round(element, change):
    """Real matrix (n, n) of z' = X z on the z = p + i s of all pairs; others stay as they are."""
    first, second = turning_pairs(element)
    real = np.eye(element.size)
    real[np.ix_(first, first)] = real[np.ix_(second, second)] = change.real
    real[np.ix_(second, first)], real[np.ix_(first, second)] = change.imag, -change.imag
    return real


def in_coordinates(element, basis):
    """The same body in other modal coordinates, q = basis · q'."""
    names = ("mass", "stiffness", "gyroscopic", "stress_stiffening", "spin_softening")
    return dataclasses.replace(
        element,
        **{name: basis.T @ getattr(element, name) @ basis for name in names},
        rigid_body_modes=la.solve(basis, element.rigid_body_modes),
        recovery_modes=element.recovery_modes @ basis,
        spin_generator=la.solve(basis, element.spin_generator @ basis).round(9),
        moments=projected_moments(element.moments, basis),
        error_forms=(),
        surface=None,
    )


def mixed(element, seed=3):
    """The same body with planes that couple: modal coordinates mixed by complex numbers.

    z_m = U z'_m + W z_b of modal coordinates z_m and interface ones z_b, U unitary, W any.
    """
    first, _ = turning_pairs(element)
    modal = np.array([element.coordinates[k].kind == "modal" for k in first])
    rng = np.random.default_rng(seed)
    change = rng.standard_normal((2, first.size, first.size)) @ np.eye(first.size)
    change = change[0] + 1j * change[1]
    change[~modal] = np.eye(first.size)[~modal]
    size = np.sqrt(np.diag(element.mass))[first]
    change[np.ix_(modal, modal)] = la.qr(change[np.ix_(modal, modal)])[0]
    change[np.ix_(modal, modal)] *= size[modal] / size[modal, None]
    change[np.ix_(modal, ~modal)] *= 0.3 * size[~modal] / size[modal, None]
    return in_coordinates(element, in_the_round(element, change))


def truncation_basis(full, kept, slack=0.0):
    """Columns: kept coordinates, then those left out; `slack` spoils the static shapes by these."""
    held = sum(c.kind == "interface" for c in full.coordinates)
    few, n = held + kept, full.size
    turn = np.eye(n)
    rigid = full.rigid_body_modes[:, full.rigid_body_present]
    noise = np.random.default_rng(5).standard_normal((n - few, few))
    noise[:, held:] = 0.0
    size = 1.0 / np.sqrt(np.diag(full.mass)[few:, None])
    turn[few:, :few] = slack * size * noise @ (np.eye(few) - rigid[:few] @ la.pinv(rigid[:few]))
    return turn


def truncated(full, kept, safety=1.0, cutoff=np.inf, slack=0.0):
    """Cut a body's modes after the lowest `kept`, with the form of the others by dense algebra.

    With `slack` the static shapes are wrong by that much of the modes left out, which brings in
    the residual of K. Γ = RᵀK⁻¹R is taken in the motions left out, with interfaces held.
    """
    few = sum(c.kind == "interface" for c in full.coordinates) + kept
    turn = truncation_basis(full, kept, slack)
    names = ("stiffness", "mass", "gyroscopic", "stress_stiffening", "spin_softening")
    parts = {name: turn.T @ getattr(full, name) @ turn for name in names}
    left = [parts[name][few:, :few] for name in names[:3]]
    left.append(parts["stress_stiffening"][few:, :few] - parts["spin_softening"][few:, :few])
    residual = np.hstack(left)
    gram = residual.T @ la.solve(parts["stiffness"][few:, few:], residual)
    form = ErrorForm(
        part="mode_truncation", gram=0.5 * (gram + gram.T), stiffness_change=None, safety=safety,
        cutoff_rad_s=cutoff,
    )  # fmt: skip
    return dataclasses.replace(
        full,
        coordinates=full.coordinates[:few],
        **{name: parts[name][:few, :few] for name in names},
        rigid_body_modes=full.rigid_body_modes[:few],
        recovery_modes=full.recovery_modes @ turn[:, :few],
        fixed_interface_frequencies_hz=full.fixed_interface_frequencies_hz[:kept],
        spin_generator=None if slack else full.spin_generator[:few, :few],
        error_forms=(form,),
        moments=projected_moments(full.moments, turn[:, :few]),
    )


def _end(place):
    """End of "body.interface", or the end itself."""
    if not isinstance(place, str):
        return place
    body, interface = place.split(".")
    return End(body=body, interface=interface)


SKEW = np.array([[0.0, 1.0], [-1.0, 0.0]])


def _square(value):
    """Matrix (2, 2) of a number for both planes, of one number for each, or the matrix itself."""
    value = np.asarray(value, dtype=float)
    return value if value.ndim == 2 else np.diag(np.broadcast_to(value, 2))


def connect(
    name, first, second=None, stiffness=None, damping=None, tilt=None, drag=None, **options
):
    """Bearing between two places given as "body.interface", or between one and the ground.

    `tilt`, `drag`: stiffness and damping against tilts.
    """
    given = {
        "stiffness_n_per_m": stiffness,
        "damping_n_s_per_m": damping,
        "tilt_stiffness_n_m_per_rad": tilt,
        "tilt_damping_n_m_s_per_rad": drag,
    }
    own = {key: _square(value) for key, value in given.items() if value is not None}
    return Bearing(name=name, first=_end(first), second=_end(second), **own, **options)


def turning(element, ratio=1.0, **options):
    return Rotor(element=element, speed_ratio=ratio, **options)


def rigid_body(name, mass_kg, center_m, inertia_kg_m2, seats):
    """Rigid body on the axis that moves sideways and tilts."""
    center, inertia = [0.0, 0.0, center_m], np.asarray(inertia_kg_m2)
    return rigid_superelement(name, mass_kg, center, inertia, seats, ("ux", "uy", "rx", "ry"))


def polynomial_law(stiffness_x, stiffness_y, damping_x=(1.0,), damping_y=(1.0,), top=5000.0, **own):
    """Factors of the speed in rad/s up to `top`, unless other units are named."""
    return PolynomialLaw(
        stiffness_x=stiffness_x,
        stiffness_y=stiffness_y,
        damping_x=damping_x,
        damping_y=damping_y,
        **{"name": "law", "argument_unit": "rad/s", "argument_range": (0.0, top), **own},
    )


def table_law(speeds, stiffness, damping=None, interpolation="monotone"):
    """Table over rad/s; rows of numbers are the same in both planes, no damping is zero."""

    def rows(values):
        values = np.asarray(values, dtype=float)
        return values if values.ndim == 3 else np.multiply.outer(values, np.eye(2))

    speeds = np.asarray(speeds, dtype=float)
    return TableLaw(
        name="law",
        speeds_rad_s=speeds,
        stiffness_n_per_m=rows(stiffness),
        damping_n_s_per_m=rows(np.zeros(speeds.size) if damping is None else damping),
        interpolation=interpolation,
    )
