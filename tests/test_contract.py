"""The import contract is kept, and fails when a forbidden import is added; the layout stays within its goals."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import rooms


REPOSITORY = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def copied(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the source and its contract."""
    folder = tmp_path_factory.mktemp("copied")
    for name in ("src", "kernels"):
        shutil.copytree(REPOSITORY / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(REPOSITORY / "pyproject.toml", folder)
    return folder


def linted(folder: Path) -> subprocess.CompletedProcess:
    code = "from importlinter.cli import lint_imports_command; lint_imports_command()"
    environment = {"PYTHONPATH": f"{folder / 'src'}:{folder / 'kernels'}", "PYTHONDONTWRITEBYTECODE": "1"}
    command = [sys.executable, "-c", code, "--no-cache", "--no-logo"]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)


def test_the_contract_is_kept(copied: Path) -> None:
    found = linted(copied)
    assert found.returncode == 0, found.stdout + found.stderr
    assert "0 broken" in found.stdout


@pytest.mark.parametrize(
    ("module", "line", "broken"),
    [
        ("src/tippetop/mechanics/friction.py", "from ..engine import taylor", "rooms stand on floors"),
        ("src/tippetop/store/files.py", "from ..scenario import build", "rooms stand on floors"),
        ("src/tippetop/runs/run.py", "from ..ensembles import lanes", "rooms stand on floors"),
        ("src/tippetop/elsewhere.py", "", "rooms stand on floors"),
        ("src/tippetop/mechanics/friction.py", "from .systems import tippe_top", "physics, from the ground up"),
        ("src/tippetop/mechanics/friction.py", "def late():\n    import heyoka", "heyoka"),
        ("src/tippetop/runs/run.py", "import matplotlib.pyplot", "matplotlib draws figures"),
        ("src/tippetop/sweeps/sweep.py", "import zarr", "the disk is the store's"),
        ("src/tippetop/engine/taylor.py", "import pydantic", "pydantic reads"),
        ("src/tippetop/runs/run.py", "import signal", "a library does not change"),
        ("kernels/tippetop_kernels/minimise.py", "import tippetop.problem", "kernels know numbers, not tops"),
    ],
)
def test_a_forbidden_import_breaks_it(module: str, line: str, broken: str, copied: Path) -> None:
    """A module without a floor breaks it too."""
    path = copied / module
    before = path.read_text(encoding="utf-8") if path.exists() else None
    path.write_text(f"{before or ''}\n\n{line}\n", encoding="utf-8")
    try:
        found = linted(copied)
    finally:
        if before is None:
            path.unlink()
        else:
            path.write_text(before, encoding="utf-8")
    assert found.returncode == 1, found.stdout + found.stderr
    verdicts = [row for row in found.stdout.splitlines() if row.rstrip().endswith("BROKEN") or " BROKEN (" in row]
    assert any(row.startswith(broken) for row in verdicts), found.stdout


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
    """At most 20 rooms on at most 8 floors, and no circle; `__main__`, the switch of `python -m`, is no room."""
    found = rooms.layout(REPOSITORY / "src")
    assert len([room for room in found.rooms if room != "__main__"]) <= 20
    assert len([floor for floor in found.floors if floor != ("__main__",)]) <= 8
    assert found.circles == ()
    floor = {room: i for i, on_it in enumerate(found.floors) for room in on_it}
    assert all(floor[a] > floor[b] for a, b in found.arrows)
