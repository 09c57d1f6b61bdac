"""How the source is laid out: rooms, floors and arrows, sizes of files and functions, lines of
tests.

usage: python tests/helpers/rooms.py [REPOSITORY]

Another checkout is only read, never imported.

A room is a module or package directly below `tippetop`; an arrow is an import from one room into
another; a floor is a set of rooms that import only from floors below.
"""

import ast
import functools
import statistics
import sys
from itertools import combinations
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


def functions(paths: list[Path]) -> list[int]:
    """The number of lines of every function."""
    kinds = ast.FunctionDef | ast.AsyncFunctionDef
    trees = (ast.parse(path.read_text(encoding="utf-8")) for path in paths)
    return [
        n.end_lineno - n.lineno + 1
        for tree in trees
        for n in ast.walk(tree)
        if isinstance(n, kinds)
    ]  # type: ignore[operator]


def lines(paths: list[Path]) -> list[int]:
    """The number of lines of every file."""
    return [len(path.read_text(encoding="utf-8").splitlines()) for path in paths]


def report(repository: Path) -> str:
    """All of it as text."""
    found = layout(repository / "src")
    source = sorted([*(repository / "src").rglob("*.py"), *(repository / "kernels").rglob("*.py")])
    tests, bench = (
        sorted((repository / "tests").rglob("*.py")),
        sorted((repository / "bench").rglob("*.py")),
    )
    sizes, tested, lengths = lines(source), lines(tests), functions(source)
    largest = max(zip(sizes, source, strict=True))
    crossed = sum(1 for a, b in combinations(found.rooms, 2) if {(a, b), (b, a)} <= found.arrows)
    return "\n".join(
        [
            f"rooms {len(found.rooms)}, floors {len(found.floors)}, arrows {len(found.arrows)}, "
            f"circles {len(found.circles)}, pairs that import each other {crossed}",
            *(
                f"  floor {i}: {', '.join(rooms)}"
                for i, rooms in reversed(list(enumerate(found.floors)))
            ),
            *(f"  circle: {', '.join(circle)}" for circle in found.circles),
            f"source files {len(sizes)}, lines {sum(sizes)}, median "
            f"{statistics.median(s for s in sizes if s):.0f}, "
            f"largest {largest[0]} ({largest[1].relative_to(repository)})",
            f"functions {len(lengths)}, median {statistics.median(lengths):.0f} lines, "
            f"ninth decile {statistics.quantiles(lengths, n=10)[-1]:.0f}, longest {max(lengths)}",
            f"test files {len(tested)}, lines {sum(tested)}: {sum(tested) / sum(sizes):.2f} of "
            "the source "
            f"(and {sum(lines(bench))} in bench)",
        ]
    )


if __name__ == "__main__":
    print(report(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[2]))
