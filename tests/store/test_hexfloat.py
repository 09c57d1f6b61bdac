"""A checkpoint keeps every bit of every precision, as text."""

import json

import heyoka as hy
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tippetop.store import hexfloat


def through_json(value: object) -> object:
    return json.loads(json.dumps(hexfloat.encode(value), allow_nan=False))


def same(one: object, other: object) -> bool:
    """Equal, and of one sign where zero; NaN is NaN."""
    return np.float64(one).tobytes() == np.float64(other).tobytes() or (
        np.isnan(one) and np.isnan(other)
    )


@given(st.floats())
def test_a_double_keeps_its_bits(x: float) -> None:
    assert same(hexfloat.from_hex(hexfloat.to_hex(x)), x)
    assert same(hexfloat.decode(through_json([x]))[0], x)


@given(st.floats(1e-200, 1e200), st.floats(0, 1))
def test_eighty_bits_are_kept(x: float, rest: float) -> None:
    wide = np.longdouble(x) * (1 + np.longdouble(rest) * np.longdouble(2) ** -54)
    assert hexfloat.from_hex(hexfloat.to_hex(wide), np.longdouble) == wide
    assert hexfloat.from_hex(hexfloat.to_hex(-wide), np.longdouble) == -wide


def test_quadruple_precision_is_kept(rng: np.random.Generator) -> None:
    for a, b, c in rng.uniform(-1, 1, (100, 3)).tolist():
        wide = hy.real128(a) + hy.real128(b * 2.0**-54) + hy.real128(c * 2.0**-108)
        assert hexfloat.from_hex(hexfloat.to_hex(wide), hy.real128) == wide


names = st.text("abc", min_size=1, max_size=3).map("inf".__add__)  # no number
trees = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**53), 2**53) | st.floats(allow_nan=False) | names,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(names, inner, max_size=3),
    max_leaves=8,
)


@given(trees)
def test_a_tree_comes_back_as_it_was(tree: object) -> None:
    assert hexfloat.decode(through_json(tree)) == tree
