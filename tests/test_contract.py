"""The import contract is kept, and fails when a forbidden import is added; the layout stays within
its goals.
"""

import json
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import NamedTuple

import pytest


REPOSITORY = Path(__file__).parents[1]
FORBIDDEN = [
    ("src/tippetop/mechanics/friction.py", "from ..engine import taylor", "layers of the package"),
    ("src/tippetop/elsewhere.py", "", "layers of the package"),
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
    """A module outside the layers breaks it too."""
    found = linted[1 + case]
    assert found.code == 1, found.out
    assert re.search(rf"^{re.escape(FORBIDDEN[case][2])}.* BROKEN", found.out, re.MULTILINE)


def test_the_layout_stays_within_its_goals() -> None:
    """At most 26 parts in at most 11 layers below `python -m`."""
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text(encoding="utf-8"))
    layers = project["tool"]["importlinter"]["contracts"][0]["layers"][1:]
    assert len(layers) <= 11
    assert len(" | ".join(layers).split(" | ")) <= 26
