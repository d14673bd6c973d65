"""Superelement files: one HDF5 file per body, written atomically, read with suspicion."""

from __future__ import annotations

import json
from dataclasses import replace
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import h5py
import numpy as np

from solidwhirl.rotordyn.core.atomic import replacing
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.storage import format as layout
from solidwhirl.rotordyn.storage import optional_parts as parts
from solidwhirl.rotordyn.storage.checked_reads import SuperelementFile, check_header
from solidwhirl.rotordyn.storage.sandbox import SEAL_BYTES, refuse_damaged, seal_file
from solidwhirl.rotordyn.superelement import invariants
from solidwhirl.rotordyn.superelement.body_measures import asymmetry
from solidwhirl.rotordyn.superelement.invariants import Invariant
from solidwhirl.rotordyn.superelement.record import Coordinate, InterfaceNode, Superelement
from solidwhirl.rotordyn.superelement.rigid_body import body_mass_matrix

# Attributes of an HDF5 group are limited to 64 KiB.
_LONGEST_ATTRIBUTE = 60_000
# Oldest and newest layout of what is written.
_VERSIONS = ("earliest", "v110")


def write_superelement(element: Superelement, path: str | Path) -> None:
    """Write a superelement to an HDF5 file, in place of an older one.

    The file appears under its name only when it is complete, with a checksum of all its bytes in
    the first 512. All numbers are kept bit for bit; what varies between runs (date, program
    version) is in attributes of the root.

    Raises OSError: the folder does not exist or cannot be written.
    """
    with replacing(Path(path)) as temporary:
        with h5py.File(temporary, "x", libver=_VERSIONS, userblock_size=SEAL_BYTES) as file:
            _write_content(file, element)
            _write_origin(file, element)
        seal_file(temporary)


def write_superelement_again(content: bytes, element: Superelement, path: str | Path) -> None:
    """Write the file of a superelement from that of one which was made elsewhere.

    `content`: of a file that `write_superelement` of this version wrote, of an element with the
    same numbers, whose `provenance` may be another one. Much faster than anew.

    Raises OSError: the folder does not exist or cannot be written.
    """
    with replacing(Path(path)) as temporary:
        temporary.write_bytes(content)
        with h5py.File(temporary, "r+", libver=_VERSIONS) as file:
            del file["provenance"]
            _write_origin(file, element)
        seal_file(temporary)


def _write_content(file: h5py.File, element: Superelement) -> None:
    _write_header(file, element)
    _write_coordinates(file, element)
    _write_operators(file.create_group("operators"), element)
    _write_body(file, element)
    recovery = file.create_group("recovery")
    layout.put_numbers(recovery, "xyz", element.recovery_points_m, unit="m")
    axes = "point,component(ux,uy,uz),generalized_coordinate"
    layout.put_numbers(recovery, "Phi", element.recovery_modes, axes=axes)
    frequencies = file.create_group("frequencies")
    layout.put_numbers(frequencies, "free", element.free_frequencies_hz, unit="Hz")
    layout.put_numbers(
        frequencies, "fixed_interface", element.fixed_interface_frequencies_hz, unit="Hz"
    )
    layout.put_numbers(frequencies, "error_estimate", element.frequency_error_estimate, unit="1")
    parts.write_error_forms(file, element.error_forms)
    parts.write_moments(file, element.moments)
    parts.write_surface(file, element.surface)


def _write_origin(file: h5py.File, element: Superelement) -> None:
    """Write when and from what a file was made."""
    file.attrs["created_utc"] = datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    text = json.dumps(element.provenance, sort_keys=True)
    provenance = file.create_group("provenance")
    if len(text.encode()) <= _LONGEST_ATTRIBUTE:
        provenance.attrs["json"] = text
    else:
        provenance.create_dataset("json", data=text, dtype=h5py.string_dtype("utf-8"))


def program_version() -> str:
    """Return the version of the installed program, "unknown" when it is not installed."""
    try:
        return version("solidwhirl")
    except PackageNotFoundError:
        return "unknown"


def _write_header(file: h5py.File, element: Superelement) -> None:
    if element.cyclic_sectors is not None:
        file.attrs["cyclic_sectors"] = np.int64(element.cyclic_sectors)
    file.attrs.update(
        {
            "format": layout.FORMAT,
            "format_version": layout.FORMAT_VERSION,
            "generator": f"solidwhirl {program_version()}",
            "name": element.name,
            "level": element.level,
            "harmonics": np.array(element.harmonics, dtype=np.int64),
            "unit_system": "SI",
            "units": json.dumps(layout.UNITS),
            "frame": element.frame,
            "spin_axis": np.array([0.0, 0.0, 1.0]),
            "spin_origin": np.zeros(3),
            "basis": "craig-bampton",
            "rigid_modes": "included" if element.rigid_body_present.any() else "removed",
            "equation": layout.EQUATION,
        }
    )


def _write_coordinates(file: h5py.File, element: Superelement) -> None:
    names = [node.name for node in element.interfaces]
    number = {"": 0} | {name: index + 1 for index, name in enumerate(names)}
    kinds = {"interface": layout.INTERFACE_KIND, "modal": layout.MODAL_KIND}
    dof = file.create_group("dof")
    coordinates = element.coordinates
    layout.put_numbers(
        dof, "node", np.array([number[c.interface] for c in coordinates], dtype=np.int64)
    )
    codes = [layout.COMPONENT_CODES[c.component] for c in coordinates]
    layout.put_numbers(
        dof, "component", np.array(codes, dtype=np.int8), enum="0 modal, 1..6 ux uy uz rx ry rz"
    )
    layout.put_numbers(
        dof,
        "kind",
        np.array([kinds[c.kind] for c in coordinates], dtype=np.uint8),
        enum="0=interface_physical,1=fixed_interface_mode",
    )
    layout.put_numbers(dof, "frequency", np.array([c.frequency_hz for c in coordinates]), unit="Hz")
    _put_text(dof, "label", [c.label for c in coordinates])

    interface = file.create_group("interface")
    layout.put_numbers(interface, "node", np.arange(1, len(names) + 1, dtype=np.int64))
    _put_text(interface, "name", names)
    positions = np.array([node.position_m for node in element.interfaces]).reshape(-1, 3)
    layout.put_numbers(interface, "xyz", positions, unit="m")
    layout.put_numbers(interface, "R", np.tile(np.eye(3), (len(names), 1, 1)))
    _put_text(
        interface, "coupling", [layout.COUPLING_CODES[n.coupling] for n in element.interfaces]
    )


def _write_operators(group: h5py.Group, element: Superelement) -> None:
    for name, operator in {**layout.OPERATORS, "Keul": layout.EULER}.items():
        matrix = getattr(element, operator.field)
        layout.put_numbers(
            group,
            name,
            {"Kspin": -matrix, "Keul": 0.5 * matrix}.get(name, matrix),
            acts_on=operator.acts_on,
            omega_power=np.int32(operator.omega_power),
            omega_dot_power=np.int32(operator.omega_dot_power),
            symmetry=operator.symmetry,
            note=operator.note,
        )


def _write_body(file: h5py.File, element: Superelement) -> None:
    body = file.create_group("body")
    about_origin = body_mass_matrix(element)[3:, 3:]
    layout.put_numbers(body, "mass", np.float64(element.mass_kg), unit="kg")
    layout.put_numbers(body, "com", element.center_of_gravity_m, unit="m")
    layout.put_numbers(body, "S", element.mass_kg * element.center_of_gravity_m, unit="kg m")
    layout.put_numbers(body, "J_origin", about_origin, unit="kg m2")
    layout.put_numbers(body, "J_com", element.inertia_kg_m2, unit="kg m2")
    layout.put_numbers(
        body, "rigid_modes", element.rigid_body_modes, axes="coordinate,motion(ux..rz)"
    )
    layout.put_numbers(body, "rigid_present", element.rigid_body_present.astype(np.uint8))
    layout.put_numbers(body, "full_dofs", np.int64(element.full_dofs))
    layout.put_numbers(body, "maximum_speed", np.float64(element.maximum_speed_rad_s), unit="rad/s")
    if element.constraint is not None:
        layout.put_numbers(body, "constraint", element.constraint, axes="coordinate,free motion")
    if element.spin_generator is not None:
        layout.put_numbers(
            body, "spin_generator", element.spin_generator, axes="coordinate,coordinate"
        )


def _put_text(group: h5py.Group, name: str, texts: list[str]) -> None:
    group.create_dataset(name, data=texts, dtype=h5py.string_dtype("utf-8"), shape=(len(texts),))


def read_superelement(path: str | Path) -> Superelement:
    """Read a superelement from an HDF5 file.

    Returns a record equal to the one written, bit for bit.
    Raises SuperelementError: the file is missing, damaged, of another format or a newer major
    version, not in SI units or in an unknown frame, lacks a dataset, or holds wrong shapes,
    numbers that are not finite, or names that can't be printed. The message names the file and the
    place. Sizes are checked before any number is read.

    A file with the checksum of `write_superelement` is read as it is. Any other is read in a child
    process first, since the HDF5 library may crash or run forever on damaged bytes.

    Groups and operators the program does not know are ignored, as later minor versions may add
    some. Operators the format defines and the program does not evaluate (internal damping and
    circulation, sampled stiffness) are refused unless zero, as the rest alone would be wrong.
    """
    path = Path(path)
    refuse_damaged(path, _read)
    return _read(path)


def _read(path: Path) -> Superelement:
    with SuperelementFile.open(path) as file:
        check_header(file)
        n = file.count("dof/component", 1)
        count = file.count("interface/name", 0)
        points = file.length("recovery/xyz")
        operators = {name: file.operator(name, n) for name in layout.OPERATORS}
        file.refuse_unsupported_operators(n)
        try:
            interfaces = _read_interfaces(file, count)
            return Superelement(
                name=file.text_attribute("name"),
                level=file.text_attribute("level"),  # type: ignore[arg-type]
                harmonics=file.integers_attribute("harmonics"),
                cyclic_sectors=file.optional_integer_attribute("cyclic_sectors"),
                frame=file.text_attribute("frame"),  # type: ignore[arg-type]
                coordinates=_read_coordinates(file, n, interfaces),
                interfaces=interfaces,
                **{
                    op.field: operators[name]
                    for name, op in layout.OPERATORS.items()
                    if name != "Kspin"
                },
                spin_softening=-operators["Kspin"],
                rigid_body_modes=file.numbers("body/rigid_modes", (n, 6)),
                rigid_body_present=np.array(file.wholes("body/rigid_present", (6,))) != 0,
                mass_kg=float(file.numbers("body/mass", ())),
                center_of_gravity_m=file.numbers("body/com", (3,)),
                inertia_kg_m2=file.numbers("body/J_com", (3, 3)),
                full_dofs=file.wholes("body/full_dofs", ())[0],
                maximum_speed_rad_s=file.speed_limit("body/maximum_speed"),
                recovery_points_m=file.numbers("recovery/xyz", (points, 3)),
                recovery_modes=file.numbers("recovery/Phi", (points, 3, n)),
                free_frequencies_hz=file.vector("frequencies/free"),
                fixed_interface_frequencies_hz=file.vector("frequencies/fixed_interface"),
                frequency_error_estimate=file.vector("frequencies/error_estimate"),
                provenance=file.provenance(),
                constraint=file.optional_matrix("body/constraint", n),
                spin_generator=file.optional_numbers("body/spin_generator", (n, n)),
                error_forms=parts.read_error_forms(file, n),
                moments=parts.read_moments(file, n),
                surface=parts.read_surface(file, n),
            )
        except SuperelementError as error:
            raise file.named(error) from error


def _read_interfaces(file: SuperelementFile, count: int) -> tuple[InterfaceNode, ...]:
    names = file.texts("interface/name", count)
    codes = file.texts("interface/coupling", count)
    positions = file.numbers("interface/xyz", (count, 3))
    by_code = {code: coupling for coupling, code in layout.COUPLING_CODES.items()}
    for code in codes:
        if code not in by_code:
            raise file.error("interface/coupling", f"is {code!r}, allowed are {list(by_code)}")
    return tuple(
        InterfaceNode(name=name, position_m=position, coupling=by_code[code])  # type: ignore[arg-type]
        for name, position, code in zip(names, positions, codes, strict=True)
    )


def _read_coordinates(
    file: SuperelementFile, n: int, interfaces: tuple[InterfaceNode, ...]
) -> tuple[Coordinate, ...]:
    numbers = file.wholes("interface/node", (len(interfaces),))
    if len(set(numbers)) < len(numbers):
        raise file.error("interface/node", "has a number more than once")
    names = dict(zip(numbers, [node.name for node in interfaces], strict=True))
    components = {code: component for component, code in layout.COMPONENT_CODES.items()}
    coordinates = []
    columns = [file.numbers(f"dof/{c}", (n,)) for c in ("node", "component", "kind", "frequency")]
    for node, component, kind, frequency in zip(*(c.tolist() for c in columns), strict=True):
        if kind == layout.MODAL_KIND:
            coordinates.append(
                Coordinate(kind="modal", interface="", component="q", frequency_hz=frequency)
            )
            continue
        if (
            kind != layout.INTERFACE_KIND
            or node not in names
            or components.get(component, "q") == "q"
        ):
            raise file.error("dof", f"has node {node}, component {component}, kind {kind}")
        coordinates.append(
            Coordinate(
                kind="interface",
                interface=names[node],
                component=components[component],  # type: ignore[arg-type]
                frequency_hz=frequency,
            )
        )
    return tuple(coordinates)


def check_superelement_file(path: str | Path) -> tuple[Invariant, ...]:
    """Check what must hold for the body of a file.

    Returns as `check_superelement`, with the symmetry of the matrices as they are stored: the
    reader takes out what is below its limit, and refuses what is above. Raises SuperelementError if
    the file can not be read for another reason than that.
    """
    refuse_damaged(Path(path), _stored_symmetry)
    stored = _stored_symmetry(Path(path))
    if not all(check.passed for check in stored.values()):
        first = next(iter(stored.values()))
        reason = "a body whose matrices are not symmetric or skew is not read"
        rest = invariants.undecided("all other checks", first.where, first.concerns, reason)
        return (*stored.values(), rest)
    element = read_superelement(path)
    return tuple(
        replace(stored[check.name], where=element.name) if check.name in stored else check
        for check in invariants.check_superelement(element)
    )


def _stored_symmetry(path: Path) -> dict[str, Invariant]:
    """Symmetry and skewness of the operators in a file, by name of the check."""
    with SuperelementFile.open(path) as file:
        check_header(file)
        n, where = file.count("dof/component", 1), file.text_attribute("name")
        checks = []
        for name, operator in layout.OPERATORS.items():
            sign = 1.0 if operator.symmetry == "symmetric" else -1.0
            error = asymmetry(file.operator(name, n), sign)
            checks.append(invariants.symmetry_check(operator.field, where, error))
    return {check.name: check for check in checks}
