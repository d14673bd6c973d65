"""Superelement files and what can be wrong with them: bytes, and content that HDF5 can hold."""

from __future__ import annotations

import dataclasses
import json
import shutil
import zlib
from functools import cache
from pathlib import Path

import h5py
import numpy as np

from solidwhirl.rotordyn import (
    Disk,
    ErrorForm,
    beam_superelement,
    rigid_superelement,
    write_superelement,
)

TEXT = h5py.string_dtype("utf-8")
SEAL_BYTES = 512
ODD_NUMBERS = (np.nan, np.inf, -np.inf, 1e308, -1e308, 5e-324, 1e-310, -0.0, -1.0, 0.0, 1e61, 0.5)
ODD_TEXTS = (
    "",
    " ",
    "../../x",
    "/etc/passwd",
    "a\nb",
    "\x1b[2J\x1b]0;owned\x07",
    "\u202eevil",
    "\u2028",
    "\x7f",
    "Ω " * 90,
    "x" * 1_000_000,
    "e\u0301\u0323" * 70,
    "🚀",
    "{}",
    "%s%n",
    "nan",
)
NUMERIC = [
    f"{group}/{name}"
    for group, names in {
        "dof": "node component kind frequency",
        "interface": "node xyz",
        "operators": "M K0 G Kgeo Kspin",
        "body": "mass com J_com rigid_modes rigid_present full_dofs maximum_speed spin_generator",
        "recovery": "xyz Phi",
        "frequencies": "free fixed_interface error_estimate",
        "moments": "displacement first second",
    }.items()
    for name in names.split()
]
TEXTS = ("interface/name", "interface/coupling")
GROUPS = ("dof", "interface", "operators", "body", "recovery", "frequencies", "provenance")
ATTRIBUTES = [
    "format",
    "format_version",
    "name",
    "level",
    "harmonics",
    "unit_system",
    "units",
    "frame",
    "spin_axis",
    "spin_origin",
]


def make_originals(folder):
    """Three files in order: a shaft with a disk, a rigid body, a body with error forms."""
    disk = Disk(name="disk", position_m=0.1, mass_kg=3.0, polar_kg_m2=0.02, diametral_kg_m2=0.011)
    shaft = beam_superelement(
        "shaft", [0.0, 0.1, 0.4], 0.02, 0.0, (2e11, 0.3, 7800.0), {"a": 0.0, "b": 0.4}, [disk]
    )
    n = shaft.size
    rng = np.random.default_rng(1)
    noise = rng.standard_normal((4 * n, 4 * n))
    forms = (
        ErrorForm(part="mesh", gram=noise @ noise.T, stiffness_change=None, safety=1.0,
                  cutoff_rad_s=np.inf),
        ErrorForm(part="mode_truncation", gram=noise @ noise.T, stiffness_change=np.eye(n),
                  safety=1.2, cutoff_rad_s=1e5),
    )  # fmt: skip
    harmonic = dataclasses.replace(
        shaft, level="harmonic", harmonics=(1,), error_forms=forms, provenance={"mesh": {"k": 1}}
    )
    rigid = rigid_superelement(
        "casing", 400.0, [0.0, 0.0, 0.2], [40.0, 40.0, 30.0], {"a": 0.0, "b": 0.5}
    )
    paths = []
    for name, element in (("shaft", shaft), ("rigid", rigid), ("harmonic", harmonic)):
        paths.append(Path(folder) / f"{name}.h5")
        write_superelement(element, paths[-1])
    return paths


def without_seal(content):
    """As a file of another program, which has no checksum."""
    return bytes(SEAL_BYTES) + content[SEAL_BYTES:]


@cache
def _used(content, start):
    return [k for k in range(start, len(content)) if content[k]]


def damage_bytes(content, rng):
    """Some bytes of a file changed, cut off, removed, doubled or added."""
    kind = rng.choice(("flip", "flip", "flip", "flip", "cut", "drop", "double", "add", "zero"))
    changed = bytearray(content)
    # empty space is most of a small file: what is not zero is hit as a rule
    start = SEAL_BYTES if content[0] == 0 else 0
    used = _used(content, start)
    at = rng.choice(used) if rng.random() < 0.9 else rng.randrange(start, len(content))
    size = rng.choice((1, 2, 8, 64, 512, 4096))
    match kind:
        case "flip":
            for _ in range(rng.choice((1, 1, 2, 5, 30))):
                at = rng.choice(used)
                flipped = changed[at] ^ (1 << rng.randrange(8))
                changed[at] = rng.choice((0, 255, 127, flipped, rng.randrange(256)))
        case "cut":
            del changed[rng.randrange(len(changed)) :]
        case "drop":
            del changed[at : at + size]
        case "double":
            changed[at:at] = changed[at : at + size]
        case "add":
            changed[at:at] = rng.randbytes(size)
        case "zero":
            changed[at : at + size] = bytes(len(changed[at : at + size]))
    return bytes(changed)


# Damage to the content: functions of an open file and a source of random numbers.


def replaced(file, place, data=None, **options):
    """Put another dataset in a place, with the attributes of the old one."""
    attributes = dict(file[place].attrs) if place in file else {}
    if place in file:
        del file[place]
    dataset = file.create_dataset(place, data=data, **options)
    for name, value in attributes.items():
        dataset.attrs[name] = value


def numeric_place(file, rng):
    found = [place for place in NUMERIC if place in file]
    found += [f"error_forms/{part}/gram" for part in file.get("error_forms", ())]
    return rng.choice(found)


def odd_number(file, rng):
    dataset = file[numeric_place(file, rng)]
    value = rng.choice(ODD_NUMBERS)
    if dataset.dtype.kind in "iu":
        info = np.iinfo(dataset.dtype)
        value = rng.choice((info.min, info.max, -1 if info.min < 0 else 7, 99))
    if dataset.size:
        dataset[tuple(rng.randrange(k) for k in dataset.shape)] = value


def odd_numbers_everywhere(file, rng):
    place = numeric_place(file, rng)
    dtype = rng.choice(("f8", "f4", "i8"))
    value = rng.choice((1e308, -1e308, 5e-324, 0.0, 1.0)) if dtype == "f8" else 3
    replaced(file, place, np.full(file[place].shape, value, dtype=dtype))


def odd_shape(file, rng):
    place = rng.choice((numeric_place(file, rng), *TEXTS))
    old = file[place]
    shape = list(old.shape)
    match rng.choice(("row", "zero", "scalar", "axis", "less")):
        case "row" if shape:
            shape[0] += 1
        case "less" if shape and shape[0]:
            shape[-1] -= 1
        case "zero" if shape:
            shape[rng.randrange(len(shape))] = 0
        case "axis":
            shape.append(1)
        case _:
            shape = []
    replaced(file, place, shape=tuple(shape), dtype=old.dtype)


def odd_type(file, rng):
    place = rng.choice((numeric_place(file, rng), *TEXTS))
    shape = file[place].shape
    types = (
        "f2", ">f8", ">i4", "f4", np.longdouble, "c16", "?", "u8", "i1", "S7", "S0", "V9", TEXT,
        h5py.vlen_dtype(np.float64), h5py.ref_dtype, h5py.regionref_dtype,
        h5py.enum_dtype({"A": 1}), np.dtype([("a", "f8"), ("b", "i4")]), np.dtype(("f8", (2,))),
        h5py.string_dtype(length=10**6),
    )  # fmt: skip
    dtype = rng.choice(types)
    if dtype == "S0":
        dtype = "S1"
    replaced(file, place, shape=shape, dtype=dtype)


def missing(file, rng):
    places = [p for p in (*NUMERIC, *TEXTS, *GROUPS) if p in file]
    del file[rng.choice(places)]


def group_for_dataset(file, rng):
    place = rng.choice((numeric_place(file, rng), *TEXTS))
    del file[place]
    file.create_group(place)


def dataset_for_group(file, rng):
    place = rng.choice(GROUPS)
    del file[place]
    file.create_dataset(place, data=rng.choice((1.0, "x")))


def link(file, rng):
    place = rng.choice((numeric_place(file, rng), *TEXTS, *GROUPS, "error_forms", "moments"))
    targets = (
        h5py.SoftLink("/nowhere"),
        h5py.SoftLink(f"/{place}"),
        h5py.SoftLink("/body"),
        h5py.SoftLink("../../.."),
        h5py.ExternalLink("/etc/passwd", "/"),
        h5py.ExternalLink("../../other.h5", "/operators"),
        h5py.ExternalLink(Path(file.filename).name, f"/{place}"),
        h5py.ExternalLink("/dev/zero", "/x"),
    )
    if place in file:
        if rng.random() < 0.3:
            file.move(place, "moved")
        else:
            del file[place]
    file[place] = rng.choice(targets)


def cyclic_group(file, rng):
    group = file[rng.choice(GROUPS)]
    group["again"] = group
    group["root"] = file["/"]
    file["a"], file["b"] = h5py.SoftLink("/b"), h5py.SoftLink("/a")


def other_file(file, rng):
    place = numeric_place(file, rng)
    shape = file[place].shape or (1,)
    del file[place]
    if rng.random() < 0.5:
        name = rng.choice(("/etc/passwd", "../secret.bin", "/dev/zero", "x.bin"))
        file.create_dataset(
            place, shape=shape, dtype="f8", external=[(name, 0, h5py.h5f.UNLIMITED)]
        )
    else:
        layout = h5py.VirtualLayout(shape=shape, dtype="f8")
        layout[...] = h5py.VirtualSource(rng.choice((".", "/etc/passwd")), "x", shape=shape)
        file.create_virtual_dataset(place, layout)


def attribute(file, rng):
    name = rng.choice(ATTRIBUTES)
    values = (
        None, 1, -1, np.nan, 1.5, "", "x", b"x\xff", "SI", "nan", [], [1.0], [0.0, 0.0, 1.0],
        [0.0, 0.0, -1.0], [1e308] * 3, list(range(8000)), "y" * 60_000, h5py.Empty("f8"),
        h5py.Empty("S1"), np.array([(1, 2.0)], dtype="i4,f8"), True,
        np.array(["a", "b"], dtype="S"),
        np.longdouble(2) ** 12000, 2**63 - 1, [-1], [2**62], 1j, file["body"].ref,
        *ODD_TEXTS[:10],
    )  # fmt: skip
    value = rng.choice(values)
    if name in file.attrs:
        del file.attrs[name]
    if value is not None:
        file.attrs[name] = value


def names(file, rng):
    choice = rng.choice(("body", "interfaces", "twice", "coupling", "raw"))
    text = rng.choice(ODD_TEXTS)
    if choice == "body" and len(text) < 60_000:
        file.attrs["name"] = text
    elif choice == "twice":
        replaced(file, "interface/name", ["a", "a"], dtype=TEXT)
    elif choice == "coupling":
        replaced(file, "interface/coupling", ["RBE2", text], dtype=TEXT)
    elif choice == "raw":
        raw = np.array([b"\xff\xfe", b"b\x00c"], dtype="S3")
        replaced(file, "interface/name", raw)
    else:
        replaced(file, "interface/name", ["a", text], dtype=TEXT)


def provenance(file, rng):
    texts = (
        "[" * 60_000, "[1]", "null", "", "{", '{"a": NaN}', '{"a": 1e999}', '{"a": "\\ud800"}',
        '{"a": %s}' % ("1" * 5000), '{"a": ' * 900 + "1" + "}" * 900, "\ufeff{}",
        '{"a": ' + "[" * 100 + "]" * 100 + "}", '{"\\u001b[2J": 1}', "{}",
    )  # fmt: skip
    group = file["provenance"]
    if rng.random() < 0.6:
        group.attrs["json"] = rng.choice(texts)
        return
    del group.attrs["json"]
    if rng.random() < 0.2:
        group.create_dataset("json", shape=(), dtype=h5py.string_dtype(length=10**9))
        return
    deep = '{"a": ' + "[" * 100_000 + "]" * 100_000 + "}"
    long = json.dumps({"a": "x" * 17_000_000}) if rng.random() < 0.05 else "{}"
    data = rng.choice((*texts, deep, long, 1.0))
    group.create_dataset("json", data=data, dtype=TEXT if isinstance(data, str) else "f8")


def error_forms(file, rng):
    if "error_forms" not in file:
        file.create_group("error_forms").create_group(rng.choice(("mesh", "weather", "\x1b[2J")))
        return
    group = file["error_forms/mesh"]
    match rng.choice(("attribute", "part", "shape", "name")):
        case "attribute":
            key = rng.choice(("safety", "cutoff_rad_s"))
            group.attrs[key] = rng.choice((0.5, -1.0, np.nan, "x", [1.0], np.inf, 1e308))
        case "part":
            file.move("error_forms/mesh", "error_forms/" + rng.choice(("x", "y" * 5000, "a\nb")))
        case "shape":
            replaced(file, "error_forms/mesh/gram", np.eye(4))
        case _:
            group.create_dataset("stiffness_change", data=np.ones((2, 3)))


def moments(file, rng):
    n = len(file["dof/kind"])
    part = rng.choice(("displacement", "first", "second"))
    match rng.choice(("missing", "shape", "size", "asymmetry", "type")):
        case "missing":
            del file[f"moments/{part}"]
        case "shape":
            shape = rng.choice(((3, n + 1), (3, 3, n, n), (6, n), (6, n, n, 1), (0,)))
            replaced(file, f"moments/{part}", np.ones(shape))
        case "size":
            replaced(file, "moments/second", shape=(6, 10**5, 10**5), dtype="f8", chunks=True)
        case "asymmetry":
            file["moments/second"][rng.randrange(3), 0, -1] = 1e9
        case _:
            del file["moments"]
            file["moments"] = rng.choice((1.0, "x"))


BOMBS = ("matrix", "many", "chunk", "swelling", "texts", "wide", "filter", "packed")


def bomb(file, rng, kind=None):
    """Few bytes that declare gigabytes."""
    n = len(file["dof/kind"])
    match kind or rng.choice(BOMBS):
        case "matrix":
            replaced(file, "operators/M", shape=(10**6, 10**6), dtype="f8", chunks=(64, 64))
        case "many":
            size = 20_000
            for place in ("dof/node", "dof/component", "dof/kind", "dof/frequency"):
                replaced(file, place, shape=(size,), dtype="f8", chunks=(4096,), fillvalue=1)
            for place in ("M", "K0", "G", "Kgeo", "Kspin"):
                replaced(file, f"operators/{place}", shape=(size, size), dtype="f8", chunks=True)
        case "chunk":
            size = (4 * 10**8,)
            replaced(file, "body/com", shape=(3,), dtype="f8", maxshape=(None,), chunks=size)
        case "swelling":
            replaced(file, "operators/M", shape=(n, n), dtype="f8", chunks=(n, n),
                     compression="gzip")  # fmt: skip
            packed = zlib.compress(bytes(60_000_000), 9)
            file["operators/M"].id.write_direct_chunk((0, 0), packed)
        case "texts":
            count = 20_000
            replaced(file, "interface/name", shape=(count,), dtype=h5py.string_dtype(length=10**6),
                     chunks=(1,))  # fmt: skip
        case "wide":
            replaced(file, "frequencies/free", shape=(4 * 10**8,), dtype="i1", chunks=(10**6,))
        case "filter":
            options = rng.choice(({"compression": "lzf"}, {"scaleoffset": 3}))
            replaced(file, "operators/K0", file["operators/K0"][()], **options)
        case _:
            replaced(file, "recovery/xyz", shape=(10**7, 3), dtype="f8", compression="gzip")
            replaced(file, "recovery/Phi", shape=(10**7, 3, n), dtype="f8", chunks=True)


def harmless(file, rng):
    """What a later minor version may add."""
    group = file.create_group("thermal")
    group.create_dataset("field", data=np.arange(5))
    for _ in range(rng.choice((1, 50))):
        group = group.create_group("x")
    file.attrs["colour"] = rng.choice(("blue", 3, [1.0, 2.0]))
    file["operators"].create_dataset("Kmagnetic", data=1.0)


def reserved_term(file, rng):
    n = len(file["dof/kind"])
    data = rng.choice((np.eye(n), np.zeros((n, n)), np.zeros(3), np.float64(0.0)))
    file["operators"].create_dataset(rng.choice(("D0", "Kcirc", "sampled")), data=data)


DAMAGES = (
    odd_number, odd_numbers_everywhere, odd_shape, odd_type, missing, group_for_dataset,
    dataset_for_group, link, cyclic_group, other_file, attribute, names, provenance, error_forms,
    moments,
    bomb, harmless, reserved_term,
)  # fmt: skip


def damage_content(original, copy, rng, kind=None):
    """Write a damaged copy of a file; the name of the damage."""
    shutil.copy(original, copy)
    with copy.open("r+b") as file:
        file.write(bytes(SEAL_BYTES))
    damages = [kind or rng.choice(DAMAGES)]
    damages += [rng.choice(DAMAGES)] if rng.random() < 0.1 else []
    with h5py.File(copy, "r+") as file:
        for damage in damages:
            try:
                damage(file, rng)
            except Exception:  # a damage before it took what this one wants
                continue
    return "+".join(damage.__name__ for damage in damages)
