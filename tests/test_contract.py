"""The import contract is kept, and fails when a forbidden import is added; the layout stays within
its goals.
"""

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest
import rooms


REPOSITORY = Path(__file__).parents[1]
FORBIDDEN = [
    ("src/tippetop/mechanics/friction.py", "from ..engine import taylor", "rooms stand on floors"),
    ("src/tippetop/store/files.py", "from ..scenario import build", "rooms stand on floors"),
    ("src/tippetop/runs/run.py", "from ..ensembles import lanes", "rooms stand on floors"),
    ("src/tippetop/elsewhere.py", "", "rooms stand on floors"),
    (
        "src/tippetop/mechanics/friction.py",
        "from .systems import tippe_top",
        "physics, from the ground up",
    ),
    ("src/tippetop/mechanics/friction.py", "def late():\n    import heyoka", "heyoka"),
    ("src/tippetop/runs/run.py", "import matplotlib.pyplot", "matplotlib draws figures"),
    ("src/tippetop/sweeps/sweep.py", "import zarr", "the disk is the store's"),
    ("src/tippetop/engine/taylor.py", "import pydantic", "pydantic reads"),
    ("src/tippetop/runs/run.py", "import signal", "a library does not change"),
    (
        "kernels/tippetop_kernels/minimise.py",
        "import tippetop.problem",
        "kernels know numbers, not tops",
    ),
]
LINTING = """
import contextlib, io, json, pathlib, sys
from importlinter.cli import lint_imports
for module, line in [("pyproject.toml", ""), *json.loads(sys.argv[1])]:
    path = pathlib.Path(module)
    before = path.read_text(encoding="utf-8") if path.exists() else None
    path.write_text(f"{before or ''}\\n\\n{line}\\n", encoding="utf-8")
    with contextlib.redirect_stdout(io.StringIO()) as out:
        code = lint_imports(cache_dir="seen", no_logo=True)
    path.unlink() if before is None else path.write_text(before, encoding="utf-8")
    print(json.dumps([code, out.getvalue()]))
"""


class Linted(NamedTuple):
    """What the contract says of the source with a line more."""

    code: int
    out: str


@pytest.fixture(scope="module")
def linted(tmp_path_factory: pytest.TempPathFactory) -> list[Linted]:
    """A copy of the source as it is, and then with each of the forbidden lines, judged in a process
    of its own.
    """
    folder = tmp_path_factory.mktemp("copied")
    for name in ("src", "kernels"):
        shutil.copytree(
            REPOSITORY / name, folder / name, ignore=shutil.ignore_patterns("__pycache__")
        )
    shutil.copy(REPOSITORY / "pyproject.toml", folder)
    environment = {
        "PYTHONPATH": f"{folder / 'src'}:{folder / 'kernels'}",
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    lines = json.dumps([(module, line) for module, line, _ in FORBIDDEN])
    command = [sys.executable, "-c", LINTING, lines]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return [Linted(*json.loads(line)) for line in done.stdout.splitlines()]


def test_the_contract_is_kept(linted: list[Linted]) -> None:
    assert linted[0].code == 0, linted[0].out
    assert "0 broken" in linted[0].out


@pytest.mark.parametrize(
    "case", range(len(FORBIDDEN)), ids=[f"{line}-{broken}" for _, line, broken in FORBIDDEN]
)
def test_a_forbidden_import_breaks_it(case: int, linted: list[Linted]) -> None:
    """A module without a floor breaks it too."""
    _, _, broken = FORBIDDEN[case]
    found = linted[1 + case]
    assert found.code == 1, found.out
    verdicts = [
        row
        for row in found.out.splitlines()
        if row.rstrip().endswith("BROKEN") or " BROKEN (" in row
    ]
    assert any(row.startswith(broken) for row in verdicts), found.out


def test_rooms_are_counted_as_grimp_counts_them() -> None:
    import grimp

    graph = grimp.build_graph("tippetop", exclude_type_checking_imports=True, cache_dir=None)
    arrows = set()
    for module in graph.modules:
        for other in graph.find_modules_directly_imported_by(module):
            ends = [name.split(".")[1] if "." in name else "" for name in (module, other)]
            if ends[0] != ends[1] and all(ends):
                arrows.add(tuple(ends))
    assert arrows == set(rooms.layout(REPOSITORY / "src").arrows)


def test_the_layout_stays_within_its_goals() -> None:
    """At most 21 rooms on at most 8 floors, and no circle.

    `python -m` and the modules of public names are no rooms.
    """
    found = rooms.layout(REPOSITORY / "src")
    doors = {"__main__", "derivatives", "extending", "friction", "landscapes", "theory"}
    assert len(set(found.rooms) - doors) <= 21
    assert len([floor for floor in found.floors if set(floor) - doors]) <= 8
    assert found.circles == ()
    floor = {room: i for i, on_it in enumerate(found.floors) for room in on_it}
    assert all(floor[a] > floor[b] for a, b in found.arrows)
