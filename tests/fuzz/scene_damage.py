"""What can be wrong with the text of a scene or problem file."""

from __future__ import annotations

import re

NUMBER = re.compile(rb"(?<![\w.\"])[-+]?\d[\d_]*(?:\.\d+)?(?:[eE][-+]?\d+)?(?![\w\"])")
TEXT = re.compile(rb"\"[^\"\n]*\"")
VALUE = re.compile(rb"= ([^\n,{}\[\]]+)")
NAMES = (
    "../x", "/etc/x", "a/b", "a\\b", "..", ".", "", " ", "CON", "nul", "com1", "x.", "x ", "x" * 64,
    "x" * 65, "x" * 300, "a\\u0000b", "\U0001f680", "Rotor", "rotor", "ROTOR", "ground", "-x", "_x",
    "a.b", "$HOME", "~", "%00", "a\\nb", "\\u001b[2J", "\u202ex", "e\u0301", "\u0660", "results",
    "steel", "lp.C", "inner.A", "x" * 1_000_000,
)  # fmt: skip
ODD_VALUES = (
    b"0", b"-1", b"1e308", b"-1e308", b"1e999", b"-1e999", b"5e-324", b"1e-300", b"nan", b"-inf",
    b"inf", b"0x" + b"f" * 5000, b"0b" + b"1" * 9000, b"1" + b"0" * 5000, b"-" + b"9" * 4000,
    b"1" + b"0" * 400, b"1_000", b"1__0", b"0x1F", b"0o17", b"01", b"+1", b".5", b"1.", b"1e30",
    b"1e31", b"true", b"false", b"True", b"none", b"1979-05-27", b"1979-05-27T07:32:00Z",
    b"07:32:00", b"1979-13-45", b"0000-00-00", b"9999-12-31T23:59:59.999999+23:59", b"[]", b"{}",
    b"[[]]", b"[{}]", b"''", b'""', b'"""\n"""', b"[1, 2]", b"[1e30, 1e30]", b"{ a = 1 }",
    b"[[1, 2], [3, 4]]", b"[1, 2, 3]", b'"x"', b"2001", b"1000000",
)  # fmt: skip
INSERTED = (
    b"\x00", b"\x1b[2J", b"\x7f", b"\r", b"\t", b"\xff", b"\xc3", b"\xed\xa0\x80",
    b"\xf4\x90\x80\x80",
    "\ufeff".encode(), "\u202e".encode(), "\u2066".encode(), "\u200b".encode(), "\u2028".encode(),
    "\u00a0".encode(), "Ω".encode(), "\U0001f680".encode(), b'"', b"'", b'"""', b"#", b"[", b"]",
    b"[[", b"{", b"}", b"=", b",", b".", b"\\", b"\\u0000", b"\\ud800", b"\\U00110000", b"\\x41",
)  # fmt: skip


def flip_bytes(text, rng):
    changed = bytearray(text)
    for _ in range(rng.choice((1, 1, 2, 8))):
        at = rng.randrange(len(changed))
        changed[at] = rng.choice((changed[at] ^ (1 << rng.randrange(8)), rng.randrange(256)))
    return bytes(changed)


def lines(text, rng):
    """Lines left out, doubled, swapped, moved or joined."""
    found = text.split(b"\n")
    a, b = rng.randrange(len(found)), rng.randrange(len(found))
    match rng.choice(("drop", "double", "swap", "move", "join", "end", "crlf")):
        case "drop":
            del found[a : a + rng.choice((1, 1, 3))]
        case "double":
            found.insert(b, found[a])
        case "swap":
            found[a], found[b] = found[b], found[a]
        case "move":
            found.insert(b, found.pop(a))
        case "join" if a + 1 < len(found):
            found[a : a + 2] = [found[a] + found[a + 1]]
        case "crlf":
            return text.replace(b"\n", rng.choice((b"\r\n", b"\r")))
        case _:
            return text[: rng.randrange(len(text))]
    return b"\n".join(found)


def _spot(pattern, text, rng):
    found = list(pattern.finditer(text))
    return rng.choice(found) if found else None


def _put(text, spot, content):
    return text[: spot.start()] + content + text[spot.end() :]


def odd_value(text, rng):
    spot = _spot(rng.choice((NUMBER, NUMBER, TEXT)), text, rng)
    return _put(text, spot, rng.choice(ODD_VALUES))


def scale_number(text, rng):
    spot = _spot(NUMBER, text, rng)
    try:
        value = float(spot[0]) * rng.choice((-1.0, 0.5, 1.01, 2.0, 1e3, 1e-3, 1e9, 1e-9))
    except ValueError:
        return text
    return _put(text, spot, repr(value).encode())


def insert(text, rng):
    at = rng.choice((0, len(text), rng.randrange(len(text)), rng.randrange(len(text))))
    return text[:at] + rng.choice(INSERTED) * rng.choice((1, 1, 1, 3)) + text[at:]


def nest(text, rng):
    """Something nested thousands deep as a value, a key or a table."""
    deep = rng.choice((17, 40, 900, 10_000))
    values = (
        b"[" * deep + b"]" * deep,
        b"[" * deep,
        b"{ a = " * deep + b"1" + b" }" * deep,
        b"{ " + b"a." * deep + b"a = 1 }",
        b"[{ a = " * deep + b"1" + b" }]" * deep,
    )
    if rng.random() < 0.7:
        return _put(text, _spot(rng.choice((NUMBER, TEXT)), text, rng), rng.choice(values))
    heads = (
        b"a." * deep + b"a = 1\n",
        b"[" + b"a." * deep + b"a]\n",
        b'"a" . ' * deep + b"a = 1\n",
    )
    return rng.choice((lambda h: h + text, lambda h: text + b"\n" + h))(rng.choice(heads))


def name(text, rng):
    """A text that becomes a name, a reference or a file name."""
    spot = _spot(TEXT, text, rng)
    return _put(text, spot, b'"' + rng.choice(NAMES).encode() + b'"')


def table_name(text, rng):
    spot = _spot(re.compile(rb"(?m)^\[+(\w+\.)?(\w+)"), text, rng)
    if spot is None:
        return text
    new = rng.choice(
        (b'"../x"', b'"a/b"', b"CON", b"Rotor", b'"\\u0000"', b"x" * 300, b'""', b"a.b")
    )
    return text[: spot.start(2)] + new + text[spot.end(2) :]


def double_key(text, rng):
    found = [line for line in text.split(b"\n") if b" = " in line and not line.startswith(b"#")]
    return text + b"\n" + rng.choice(found) + b"\n" + rng.choice(found)


DAMAGES = (
    flip_bytes, lines, odd_value, odd_value, scale_number, insert, nest, name, name, table_name,
    double_key,
)  # fmt: skip


def damage_text(text, rng):
    """The text with one damage, sometimes two or three; and the name of the first."""
    first = rng.choice(DAMAGES)
    changed = first(text, rng)
    while rng.random() < 0.15 and 0 < len(changed) < 100_000:
        try:
            changed = rng.choice(DAMAGES)(changed, rng)
        except (AttributeError, IndexError):  # the first damage left nothing to change
            break
    return changed, first.__name__
