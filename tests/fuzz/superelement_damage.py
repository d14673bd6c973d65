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
TEXTS = ("interface/name", "interface/coupling")
TYPES = (
    "f2", ">f8", ">i4", "f4", np.longdouble, "c16", "?", "u8", "i1", "S7", "S1", "V9", TEXT,
    h5py.vlen_dtype(np.float64), h5py.ref_dtype, h5py.regionref_dtype, h5py.enum_dtype({"A": 1}),
    np.dtype([("a", "f8"), ("b", "i4")]), np.dtype(("f8", (2,))), h5py.string_dtype(length=10**6),
)  # fmt: skip
ATTRIBUTES = (
    None, 1, -1, np.nan, np.inf, 0.5, 1.5, 1e308, b"x\xff", "SI", [], [1.0], [0.0, 0.0, 1.0],
    [0.0, 0.0, -1.0], [1e308] * 3, list(range(8000)), "y" * 60_000, h5py.Empty("f8"),
    h5py.Empty("S1"), np.array([(1, 2.0)], dtype="i4,f8"), True, np.array(["a", "b"], dtype="S"),
    np.longdouble(2) ** 12000, 2**63 - 1, [-1], [2**62], 1j,
    *(text for text in ODD_TEXTS if len(text) < 60_000),
)  # fmt: skip


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


def items(file, kind=(h5py.Dataset, h5py.Group)):
    """Names of what is in a file."""
    found = []
    file.visititems(lambda name, item: found.append(name) if isinstance(item, kind) else None)
    return found


def odd_number(file, rng):
    """One number of a dataset, or all of them."""
    datasets = [file[name] for name in items(file, h5py.Dataset)]
    dataset = rng.choice([d for d in datasets if d.dtype.kind in "fiu" and 0 < d.size < 10**6])
    value = rng.choice(ODD_NUMBERS)
    if dataset.dtype.kind in "iu":
        info = np.iinfo(dataset.dtype)
        value = rng.choice((info.min, info.max, -1 if info.min < 0 else 7, 99))
    everywhere = rng.random() < 0.3
    dataset[() if everywhere else tuple(rng.randrange(k) for k in dataset.shape)] = value


def odd_dataset(file, rng):
    """A dataset of another type or shape."""
    place = rng.choice(items(file, h5py.Dataset))
    old = file[place]
    if rng.random() < 0.5:
        replaced(file, place, shape=old.shape, dtype=rng.choice(TYPES))
        return
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


def missing(file, rng):
    """Nothing, or something else, in the place of a dataset or a group."""
    place = rng.choice(items(file))
    shape = getattr(file[place], "shape", ()) or (1,)
    if rng.random() < 0.3:
        file.move(place, "moved")
    else:
        del file[place]
    match rng.choice(("nothing", "group", "dataset", "link", "link", "cycle", "other", "virtual")):
        case "group":
            file.create_group(place)
        case "dataset":
            file.create_dataset(place, data=rng.choice((1.0, "x")))
        case "link":
            paths = ("/nowhere", f"/{place}", "/body", "../../..", "/moved")
            files = ("/etc/passwd", "../../other.h5", Path(file.filename).name, "/dev/zero")
            links = [h5py.SoftLink(path) for path in paths]
            links += [h5py.ExternalLink(name, f"/{place}") for name in files]
            file[place] = rng.choice(links)
        case "cycle":
            file[place] = file["/"]
        case "other":
            name = rng.choice(("/etc/passwd", "../secret.bin", "/dev/zero", "x.bin"))
            data = [(name, 0, h5py.h5f.UNLIMITED)]
            file.create_dataset(place, shape=shape, dtype="f8", external=data)
        case "virtual":
            layout = h5py.VirtualLayout(shape=shape, dtype="f8")
            layout[...] = h5py.VirtualSource(rng.choice((".", "/etc/passwd")), "x", shape=shape)
            file.create_virtual_dataset(place, layout)


def attribute(file, rng):
    """An attribute of the file or of something in it."""
    holder = file[rng.choice(("/", rng.choice(items(file))))].attrs
    name, value = rng.choice([*holder] or ["new"]), rng.choice((*ATTRIBUTES, file["body"].ref))
    if name in holder:
        del holder[name]
    if value is not None:
        holder[name] = value


def names(file, rng):
    if rng.random() < 0.2:
        replaced(file, TEXTS[0], np.array([b"\xff\xfe", b"b\x00c"], dtype="S3"))
        return
    place, first = rng.choice(((TEXTS[0], "a"), (TEXTS[1], "RBE2")))
    replaced(file, place, [first, rng.choice(("a", *ODD_TEXTS))], dtype=TEXT)


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
    file.move("error_forms/mesh", "error_forms/" + rng.choice(("x", "y" * 5000, "a\nb")))


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


def added(file, rng):
    """What a later minor version may add, and terms that this program does not know."""
    if rng.random() < 0.5:
        n = len(file["dof/kind"])
        data = rng.choice((np.eye(n), np.zeros((n, n)), np.zeros(3), np.float64(0.0)))
        file["operators"].create_dataset(rng.choice(("D0", "Kcirc", "sampled")), data=data)
        return
    group = file.create_group("thermal")
    group.create_dataset("field", data=np.arange(5))
    for _ in range(rng.choice((1, 50))):
        group = group.create_group("x")
    file.attrs["colour"] = rng.choice(("blue", 3, [1.0, 2.0]))
    file["operators"].create_dataset("Kmagnetic", data=1.0)


DAMAGES = (
    odd_number, odd_number, odd_dataset, odd_dataset, missing, missing, missing, attribute,
    attribute, names, provenance, error_forms, bomb, added,
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
