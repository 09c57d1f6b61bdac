"""Input that nobody would write: values, texts and bytes, put into TOML at random places."""

import math
from typing import Any

import numpy as np


NUMBERS = (
    0,
    -1,
    1,
    0.0,
    -0.0,
    1e-300,
    5e-324,
    1e300,
    1.7e308,
    10**18,
    10**400,
    math.nan,
    math.inf,
    -math.inf,
    1e-9,
    1e9,
)
THINGS: tuple[Any, ...] = (
    *(
        "",
        "x",
        "vector",
        "viscous",
        "none",
        "../../etc/passwd",
        "é\u202e",
        "a" * 3000,
        "0.3",
        "nan",
    ),
    *(
        True,
        False,
        [],
        {},
        [1.0, 2.0],
        [[]],
        [None.__class__.__name__],
        {"x": 1},
        {"law": "viscous"},
        [1, "x"],
    ),
)
KEYS = (
    "theta",
    "mu",
    "Theta",
    "initial",
    "run",
    "__class__",
    "a b",
    "",
    "é",
    "until",
    "eps",
    "form",
    "law",
    "x" * 300,
)


def any_value(rng: np.random.Generator) -> Any:
    """A number at the ends of the numbers, or something else."""
    if rng.random() < 0.6:
        return NUMBERS[int(rng.integers(len(NUMBERS)))]
    return THINGS[int(rng.integers(len(THINGS)))]


def distort(tables: dict[str, Any], rng: np.random.Generator) -> list[str]:
    """Changes, removes or adds a few things in nested tables; says what."""
    said = []
    for _ in range(int(rng.integers(1, 4))):
        places: list[tuple[Any, Any]] = []

        def walk(node: Any, places: list[tuple[Any, Any]] = places) -> None:
            for key, value in (
                list(node.items()) if isinstance(node, dict) else list(enumerate(node))
            ):
                places.append((node, key))
                if isinstance(value, dict | list):
                    walk(value)

        walk(tables)
        if not places:
            break
        node, key = places[int(rng.integers(len(places)))]
        way = int(rng.integers(4))
        if way == 0 and isinstance(node, dict):
            del node[key]
            said.append(f"without {key}")
        elif way == 1 and isinstance(node, dict):
            new = KEYS[int(rng.integers(len(KEYS)))]
            node[new] = any_value(rng)
            said.append(f"{new[:20]} = {str(node[new])[:30]}")
        else:
            node[key] = any_value(rng)
            said.append(f"{key} = {str(node[key])[:30]}")
    return said


def toml(value: Any) -> str:
    """A value as TOML."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, int):
        return str(value)
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if isinstance(value, dict):
        return "{" + ", ".join(f"{toml(str(k))} = {toml(v)}" for k, v in value.items()) + "}"
    return "[" + ", ".join(map(toml, value)) + "]"


def text_of(tables: dict[str, Any]) -> str:
    """Tables as a TOML text: plain keys first, each on a line."""
    return "\n".join(f"{toml(str(key))} = {toml(value)}" for key, value in tables.items()) + "\n"


def garbled(text: str, rng: np.random.Generator) -> bytes:
    """The text with some bytes flipped, cut, doubled or foreign."""
    content = bytearray(text.encode())
    for _ in range(int(rng.integers(1, 4))):
        at, way = int(rng.integers(len(content) + 1)), int(rng.integers(5))
        if way == 0 and at < len(content):
            content[at] ^= 1 << int(rng.integers(8))
        elif way == 1:
            content[at:at] = rng.bytes(int(rng.integers(1, 9)))
        elif way == 2:
            del content[at:]
        elif way == 3:
            content[at:at] = content[at : at + 200]
        else:
            content[at:at] = [
                b"[" * 2000,
                b"\x00",
                b"\xff\xfe",
                b"\r",
                b"[[axis]]\n",
                b"a.b.c=",
                b"'''",
            ][int(rng.integers(7))]
    return bytes(content)
