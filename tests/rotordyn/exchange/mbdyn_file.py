"""Strict readers of MBDyn's modal .fem files and of the inputs that use them."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np
from point_bodies import skew

LONGEST_LINE = 8191  # of the reader in C++
VALUE = r"-?\d\.\d{16}e[+-]\d\d\d?"
NEEDED = {1, 2, 5, 6, 7, 8, 9, 10}
INVARIANTS = {14, 15, 16, 17, 18}


class FemError(ValueError):
    """A file off the format."""


@dataclass(frozen=True)
class FemFile:
    """All that a .fem file says; what is not there is None."""

    groups: tuple[int, ...]
    labels: tuple[str, ...]
    amplitudes: np.ndarray | None
    rates: np.ndarray | None
    places: np.ndarray
    shapes: np.ndarray
    mass: np.ndarray
    stiffness: np.ndarray
    lumped: np.ndarray | None
    inertia: tuple[float, np.ndarray, np.ndarray] | None
    damping: np.ndarray | None
    I3: np.ndarray | None
    I4: np.ndarray | None
    I5: np.ndarray | None
    I8: np.ndarray | None
    I9: np.ndarray | None
    stiffening: dict[int, np.ndarray] = field(default_factory=dict)


class _Lines:
    def __init__(self, text):
        if not text.isascii() or not text.endswith("\n") or "\r" in text or "\t" in text:
            raise FemError("ASCII lines without tabs that end in a line feed are wanted")
        self.lines = text[:-1].split("\n")
        if max(map(len, self.lines)) > LONGEST_LINE:
            raise FemError("a line is longer than the reader's buffer")
        self.at = 0

    def next(self):
        if self.at == len(self.lines):
            raise FemError("the file ends too early")
        self.at += 1
        return self.lines[self.at - 1]

    def tokens(self, count, pattern):
        """Take whole lines until a number of words is complete."""
        found = []
        while len(found) < count:
            words = self.next().split()
            if not words or any(not re.fullmatch(pattern, word) for word in words):
                raise FemError(f"line {self.at}: {self.lines[self.at - 1]!r}")
            found += words
        if len(found) != count:
            raise FemError(f"line {self.at}: {len(found)} values, {count} wanted")
        return found

    def numbers(self, *shape):
        values = self.tokens(int(np.prod(shape)), VALUE)
        return np.array([float(v) for v in values]).reshape(shape)

    def integer(self):
        return int(self.tokens(1, r"\d+")[0])


def parse_fem(text):
    """Return the contents of a .fem file; FemError if anything is off the format."""
    lines = _Lines(text)
    found, groups = {}, []
    n = m = None
    while True:
        line = lines.next()
        if line == "** END OF FILE":
            break
        head = re.fullmatch(r"\*\* RECORD GROUP (\d+),[ A-Z0-9.,-]*", line)
        if not head:
            if line.startswith("** RECORD") or (line and not line.startswith("**")):
                raise FemError(f"line {lines.at}: {line!r} outside of records")
            continue
        group = int(head.group(1))
        if (not groups and group != 1) or (groups and group <= groups[-1]):
            raise FemError(f"record group {group} after {groups}")
        groups.append(group)
        if group == 1:
            if not lines.next().startswith("**"):
                raise FemError("record group 1 begins with a comment")
            revision, *numbers = lines.next().split()
            n, normal, attached, constraint, rejected = map(int, numbers)
            m = normal + attached + constraint - rejected
            if revision != "REV0" or m < 1 or n < 1:
                raise FemError(f"header {revision, *numbers}")
            continue
        found[group] = _record(lines, group, n, m)
    if lines.at != len(lines.lines):
        raise FemError("text behind the end")
    missing = NEEDED - set(groups)
    if missing or (INVARIANTS & set(groups)) not in (set(), INVARIANTS):
        raise FemError(f"record groups {groups}")
    if (11 in groups) == (12 in groups) or (11 in groups and INVARIANTS & set(groups)):
        raise FemError(f"inertia in two ways or none: {groups}")
    labels = tuple(found[2])
    if len(set(labels)) != n:
        raise FemError("a label comes twice")
    return FemFile(
        groups=tuple(groups),
        labels=labels,
        amplitudes=found.get(3),
        rates=found.get(4),
        places=np.stack([found[5], found[6], found[7]], axis=1),
        shapes=found[8],
        mass=found[9],
        stiffness=found[10],
        lumped=found.get(11),
        inertia=found.get(12),
        damping=found.get(13),
        I3=found.get(14),
        I4=found.get(15),
        I5=found.get(17),
        I8=found.get(16),
        I9=found.get(18),
        stiffening=found.get(19, {}),
    )


def _record(lines, group, n, m):
    if group == 2:
        return lines.tokens(n, r"[^\s*]\S*")
    if group == 8:
        shapes = np.zeros((n, 6, m))
        for mode in range(m):
            if not re.fullmatch(rf"\*\*    NORMAL MODE SHAPE # *{mode + 1}", lines.next()):
                raise FemError(f"line {lines.at}: mode {mode + 1} is not announced")
            shapes[:, :, mode] = lines.numbers(n, 6)
        return shapes
    if group == 12:
        return float(lines.numbers(1)[0]), lines.numbers(3), lines.numbers(3, 3)
    if group == 16:
        return lines.numbers(3, m, 3).transpose(0, 2, 1)
    if group == 18:
        return lines.numbers(3, m, m, 3).transpose(0, 3, 1, 2)
    if group == 19:
        matrices = {}
        for _ in range(lines.integer()):
            index = lines.integer()
            if index in matrices or index < 1:
                raise FemError(f"stiffening {index} after {list(matrices)}")
            matrices[index] = lines.numbers(m, m)
        return matrices
    shapes = {
        **{3: (m,), 4: (m,), 5: (n,), 6: (n,), 7: (n,), 9: (m, m), 10: (m, m), 11: (n, 6)},
        **{13: (m, m), 14: (3, m), 15: (3, m), 17: (3, m, m)},
    }
    if group not in shapes:
        raise FemError(f"record group {group} is unknown")
    return lines.numbers(*shapes[group])


def statements(text):
    """(block, key, words) of each statement of an input, comments and line ends dropped."""
    plain = " ".join(line.split("#")[0].strip() for line in text.split("\n"))
    parts = re.findall(r'(?:"[^"]*"|[^;"])+;', plain)
    if "".join(parts).replace(" ", "") != plain.replace(" ", ""):
        raise FemError("a statement has no end")
    found, block = [], None
    for part in parts:
        key, _, rest = part[:-1].strip().partition(":")
        words = [" ".join(w.split()) for w in re.findall(r'(?:"[^"]*"|[^,"])+', rest)]
        if key in ("begin", "end"):
            if words[0] != block if key == "end" else block is not None:
                raise FemError(f"{key} {words} in {block}")
            block = words[0] if key == "begin" else None
        else:
            found.append((block, key.strip(), words))
    if block is not None:
        raise FemError(f"{block} has no end")
    return found


# Words of the joint, in the order in which MBDyn reads them; its manual shows the last earlier,
# where the program does not take it.
MODAL = re.compile(
    r'\w+, modal, \w+, (\d+), from file, (no damping|damping from file), "([^"]+)", '
    r'origin position, null, (\d+)((?:, "[^"]+", [^",]+, \w+)*)(, use invariant 9)?'
)


def modal_joint(words):
    """The joint's settings by name; its interfaces: (label, node, offset)."""
    found = MODAL.fullmatch(", ".join(words))
    interfaces = found and re.findall(r', "([^"]+)", ([^",]+), (\w+)', found[5])
    if not found or len(interfaces) != int(found[4]):
        raise FemError(f"no modal joint: {words}")
    return {
        "modes": int(found[1]),
        "damping": found[2],
        "file": found[3],
        "interfaces": interfaces,
        "use invariant 9": found[6] is not None,
    }


def lumped_integrals(fem):
    """Return inertia and invariants as sums over the masses of record group 11."""
    mass = fem.lumped[:, 0]
    assert np.array_equal(fem.lumped[:, :3], np.repeat(mass[:, None], 3, axis=1))
    assert not fem.lumped[:, 3:].any()
    x, phi = fem.places, fem.shapes[:, :3]
    place, shape = skew(x), skew(phi.transpose(0, 2, 1))
    return {
        "mass_kg": mass.sum(),
        "center_of_gravity_m": mass @ x / mass.sum(),
        "inertia_kg_m2": -np.einsum("p,pab,pbc->ac", mass, place, place),
        "I3": np.einsum("p,paj->aj", mass, phi),
        "I4": np.einsum("p,pab,pbj->aj", mass, place, phi),
        "I5": np.einsum("p,pjab,pbk->ajk", mass, shape, phi),
        "I8": -np.einsum("p,pab,pjbc->acj", mass, place, shape),
        "I9": np.einsum("p,pjab,pkbc->acjk", mass, shape, shape),
    }


def fields(fem, names):
    """Return what the file says in the fields of `floating_frame.floating_body`."""
    if fem.lumped is not None:
        inertia = lumped_integrals(fem)
    else:
        mass, centre, about_centre = fem.inertia
        steiner = mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
        inertia = {key: getattr(fem, key) for key in ("I3", "I4", "I5", "I8", "I9")} | {
            "mass_kg": mass,
            "center_of_gravity_m": centre,
            "inertia_kg_m2": about_centre + steiner,
        }
    return inertia | {
        "mass": fem.mass,
        "stiffness": fem.stiffness,
        "stress_stiffening": fem.stiffening.get(3, np.zeros_like(fem.mass)),
        "nodes": [
            {
                "name": name,
                "position_m": fem.places[fem.labels.index(name)],
                "translations": fem.shapes[fem.labels.index(name), :3],
                "rotations": fem.shapes[fem.labels.index(name), 3:],
            }
            for name in names
        ],
    }
