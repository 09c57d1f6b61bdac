"""How the source is laid out: rooms, floors and arrows, sizes of files and functions, lines of
tests.

usage: python tests/helpers/rooms.py [REPOSITORY]

Another checkout is only read, never imported.

A room is a module or package directly below `tippetop`; an arrow is an import from one room into
another; a floor is a set of rooms that import only from floors below.
"""

import ast
import functools
from pathlib import Path
from typing import NamedTuple


class Layout(NamedTuple):
    """What was counted."""

    rooms: tuple[str, ...]
    arrows: frozenset[tuple[str, str]]
    floors: tuple[tuple[str, ...], ...]  # from the ground up; the rooms of a circle share one
    circles: tuple[tuple[str, ...], ...]


def modules(source: Path, package: str = "tippetop") -> dict[str, Path]:
    """Every module of a package, by its name."""
    found = {}
    for path in sorted((source / package).rglob("*.py")):
        parts = path.relative_to(source).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def imports(name: str, path: Path, known: set[str]) -> set[str]:
    """The modules that a module imports, anywhere in it, unless only for types."""
    nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
    typing = {
        node
        for test in nodes
        if isinstance(test, ast.If) and getattr(test.test, "id", "") == "TYPE_CHECKING"
        for node in ast.walk(test)
    }
    package = name if path.name == "__init__.py" else name.rpartition(".")[0]
    found = set()
    for node in nodes:
        if node in typing:
            continue
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names if alias.name in known}
        elif isinstance(node, ast.ImportFrom):
            above = (
                package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
            )
            base = ".".join([*above, *([node.module] if node.module else [])])
            for alias in node.names:
                found |= {f"{base}.{alias.name}"} & known or {base} & known
    return found


@functools.cache
def layout(source: Path, package: str = "tippetop") -> Layout:
    """Rooms, arrows and floors of a package.

    The package's own `__init__` is no room: it is the public face.
    """
    paths = modules(source, package)
    arrows = set()
    for name, path in paths.items():
        for other in imports(name, path, set(paths)):
            ends = [
                part[1] if len(part := module.split(".")) > 1 else "" for module in (name, other)
            ]
            if ends[0] != ends[1] and all(ends):
                arrows.add((ends[0], ends[1]))
    rooms = sorted({name.split(".")[1] for name in paths if "." in name})
    reach = {room: {room} for room in rooms}
    for _ in rooms:
        for a, b in arrows:
            reach[a] |= reach[b]
    circles = {tuple(sorted(o for o in reach[r] if r in reach[o])) for r in rooms}
    circle = {room: c for c in circles for room in c}
    floor: dict[str, int] = {}
    while len(floor) < len(rooms):
        for c in circles:
            below = {b for a, b in arrows if a in c} - set(c)
            if c[0] not in floor and below <= set(floor):
                floor |= dict.fromkeys(c, max((floor[b] for b in below), default=-1) + 1)
    floors = tuple(
        tuple(r for r in rooms if floor[r] == i) for i in range(max(floor.values(), default=-1) + 1)
    )
    return Layout(
        tuple(rooms),
        frozenset(arrows),
        floors,
        tuple(c for c in set(circle.values()) if len(c) > 1),
    )
