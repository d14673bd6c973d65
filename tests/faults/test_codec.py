"""Records as bytes: every bit comes back, and nothing else does."""

from __future__ import annotations

import dataclasses
import math
import struct
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst

from solidwhirl.cache.codec import CodecError, Seen, fingerprint, pack, unpack


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Leaf:
    name: str
    values: object


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Tree:
    leaves: tuple
    about: object = None


class Pair(NamedTuple):
    name: str
    value: object


OWN = frozenset({__name__.split(".")[0]})


def back(value, records=OWN):
    return unpack(b"".join(pack(value, OWN)), records)


def bits(number):
    return struct.pack("<d", number)


def same(a, b):
    """Whether two values are the same to the last bit, types and memory layout included."""
    if type(a) is not type(b):
        return False
    if dataclasses.is_dataclass(a):
        return all(same(getattr(a, f.name), getattr(b, f.name)) for f in dataclasses.fields(a))
    if isinstance(a, np.ndarray | np.generic):
        x, y = np.asarray(a), np.asarray(b)
        layout = x.flags.c_contiguous == y.flags.c_contiguous or not y.flags.forc
        return (x.dtype, x.shape, x.tobytes()) == (y.dtype, y.shape, y.tobytes()) and layout
    if isinstance(a, list | tuple):
        return len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, dict):
        return len(a) == len(b) and all(
            same(p, q) and same(v, w) for (p, v), (q, w) in zip(a.items(), b.items(), strict=True)
        )
    if isinstance(a, float):
        return bits(a) == bits(b)
    if isinstance(a, complex):
        return same([a.real, a.imag], [b.real, b.imag])
    return a == b


floats = st.floats(allow_nan=True, width=64).map(lambda x: x if x == x else math.nan)
kinds = st.sampled_from(["<f8", "<f4", "<c16", "<i8", "|b1", "<U3", "|S2", ">f8"])
arrays = npst.arrays(
    dtype=kinds, shape=npst.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4)
)
turned = arrays.flatmap(
    lambda a: st.sampled_from([a, a.T, np.asfortranarray(a), a[..., ::-1] if a.ndim else a])
)
plain = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(2**70), 2**70),
    floats,
    st.text(max_size=6),
    st.binary(max_size=6),
    st.complex_numbers(allow_nan=False),
    st.lists(floats, min_size=8, max_size=12),
    turned,
    st.sampled_from([np.float64(-0.0), np.int32(3), np.str_("x"), np.bool_(True)]),
)
values = st.recursive(
    plain,
    lambda inner: st.one_of(
        st.lists(inner, max_size=3),
        st.lists(inner, max_size=3).map(tuple),
        st.dictionaries(st.text(max_size=3), inner, max_size=3),
        st.dictionaries(st.integers() | st.tuples(st.integers()), inner, max_size=2),
        st.builds(Leaf, name=st.text(max_size=3), values=inner),
        st.builds(Pair, name=st.text(max_size=3), value=inner),
        st.builds(Tree, leaves=st.lists(inner, max_size=2).map(tuple), about=inner),
    ),
    max_leaves=8,
)


@settings(max_examples=100, deadline=None)
@given(values)
def test_every_bit_comes_back(value):
    found = back(value)
    assert same(found, value)
    assert fingerprint(found) == fingerprint(value)


def test_layout_comes_back():
    """BLAS adds up in another order where the layout is another: results would differ."""
    for order in ([0, 1, 2], [2, 1, 0], [1, 0, 2], [2, 0, 1]):
        given_array = np.arange(24.0).reshape(2, 3, 4).transpose(order)
        found = back(given_array)
        assert found.strides == given_array.strides
        assert not found.flags.writeable


@pytest.mark.parametrize(
    ("first", "second"),
    [
        (0.0, -0.0),
        (1, 1.0),
        (1, True),
        ("1", 1),
        ((1,), [1]),
        ({"a": 1, "b": 2}, {"b": 2, "a": 1}),  # order of bodies is order of coordinates
        (1.0, np.nextafter(1.0, 2.0)),
        (np.arange(3), np.arange(3.0)),
        (np.zeros((2, 3)), np.zeros((3, 2))),
        ([np.zeros(2), np.zeros(1)], [np.zeros(1), np.zeros(2)]),
        (Leaf(name="a", values=None), Leaf(name="b", values=None)),
        (["ab", "c"], ["a", "bc"]),
    ],
)
def test_fingerprints_tell_apart(first, second):
    assert fingerprint(first) != fingerprint(second)
    assert fingerprint(first) == fingerprint(first)


def test_fields_that_do_not_count():
    leaf = f"{__name__}.Leaf"
    for large in (frozenset(), frozenset({leaf})):
        seen = Seen(left_out={leaf: frozenset({"name"})}, large=large)
        leaves = [Leaf(name=n, values=v) for n, v in (("a", 1), ("b", 1), ("b", 2))]
        assert len({fingerprint([one], seen) for one in leaves}) == 2
        assert len(seen.digests) == len(large) * len(leaves)
        assert fingerprint([leaves[0]], seen) == fingerprint([leaves[0]], seen)


@pytest.mark.parametrize("value", [object(), {1, 2}, len, np.array([None]), Leaf])
def test_what_is_no_data_is_refused(value):
    for holder in (value, [value], Leaf(name="", values=value)):
        with pytest.raises(CodecError):
            pack(holder, OWN)
        with pytest.raises(CodecError):
            fingerprint(holder)


def test_cycles_and_depths_end():
    endless: list = []
    endless.append(endless)
    with pytest.raises(CodecError):
        pack(endless, OWN)
    head = b"[" * 50_000 + b"]" * 50_000
    with pytest.raises(CodecError):
        unpack(len(head).to_bytes(8, "little") + head, OWN)


@pytest.mark.parametrize(
    "name",
    [
        "os.system",
        "solidwhirl.__main__.main",
        "solidwhirl.nowhere.Modes",
        "solidwhirl.cache.codec.pack",
        "solidwhirl.cache.codec.CodecError",
        "solidwhirl.pipeline.cached_stages.Scene",
        f"{__name__}.Trees",
    ],
)
def test_only_frozen_records_of_the_program_are_made(name):
    """Not by a name in the file, whatever it is: no call of anything else."""
    data = b"".join(pack(Leaf(name="a", values=1), OWN))
    with pytest.raises(CodecError, match="none of this program"):
        unpack(data)
    renamed = _entry(f'{{"r":["{name}",{{}}]}}')
    with pytest.raises(CodecError, match="none of this program"):
        unpack(renamed, OWN | {"solidwhirl"})
    with pytest.raises(CodecError, match="other fields"):
        unpack(_entry(f'{{"r":["{__name__}.Tree",{{}}]}}'), OWN)


def _entry(node):
    head = f"[{node},[3]]".encode()
    return len(head).to_bytes(8, "little") + head + b"abc" + bytes(5)


NODES = [
    '{"q":1}',
    '{"t":[1],"m":{}}',
    '{"a":[0,"<f8",[1000000000,1000000000],[0,1]]}',  # 8e18 bytes: no allocation
    '{"a":[0,"|O",[1],[0]]}',
    '{"a":[0,"<f8",[-1],[0]]}',
    '{"a":[0,"<f8",[2],[0,0]]}',
    '{"a":[9,"<f8",[1],[0]]}',
    '{"b":7}',
    '{"f":0}',
    '{"c":[1,2,3]}',
    '{"r":["Leaf"]}',
    '{"r":["Leaf",{"name":"a"}]}',
    '{"d":[[[1],2]]}',
]


@pytest.mark.parametrize("node", NODES)
def test_nodes_that_mean_nothing(node):
    with pytest.raises(CodecError):
        unpack(_entry(node), OWN)
