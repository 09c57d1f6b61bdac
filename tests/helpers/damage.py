"""Damaged documents and bytes: strategies."""

import copy
import math
from collections.abc import Iterator
from typing import Any

from hypothesis import strategies as st


ODD = (0, -1, 5e-324, 1e-300, 1.7e308, 10**18, 10**400, math.nan, math.inf, "../..", "é\u202e")
TEXTS = st.text(max_size=5) | st.sampled_from(["theta", "mu", "law", "run", "__class__", "x" * 300])
VALUES = st.sampled_from(ODD) | st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | TEXTS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(TEXTS, inner, max_size=3),
    max_leaves=5,
)
FOREIGN = st.binary(max_size=9) | st.sampled_from([b"[" * 2000, b"\xff\xfe", b"[[axis]]\n", b"'''"])


def places(node: Any) -> Iterator[tuple[Any, Any]]:
    """Yield (container, key) of every value in nested tables and lists."""
    for key, value in node.items() if isinstance(node, dict) else enumerate(node):
        yield node, key
        if isinstance(value, dict | list):
            yield from places(value)


@st.composite
def changed(draw: st.DrawFn, document: Any) -> Any:
    """The document with one to three values changed, removed or added."""
    document = copy.deepcopy(document)
    for _ in range(draw(st.integers(1, 3))):
        if not (found := list(places(document))):
            break
        node, key = draw(st.sampled_from(found))
        ways = ["change", "remove", "add"] if isinstance(node, dict) else ["change"]
        way = draw(st.sampled_from(ways))
        if way == "remove":
            del node[key]
        else:
            node[draw(TEXTS) if way == "add" else key] = draw(VALUES)
    return document


@st.composite
def garbled(draw: st.DrawFn, content: bytes) -> bytes:
    """The bytes with a part replaced by other bytes, or one bit flipped."""
    at = draw(st.integers(0, len(content)))
    if content[at:] and draw(st.booleans()):
        return (
            content[:at] + bytes([content[at] ^ 1 << draw(st.integers(0, 7))]) + content[at + 1 :]
        )
    cut = draw(st.integers(0, 20) | st.just(len(content)))
    return content[:at] + draw(FOREIGN) + content[at + cut :]
