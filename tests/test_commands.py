"""Every command of the README and the manual runs as it is written there; long ones over a shorter
time.
"""

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from measured import AXIS, written

import tippetop as tt
from tippetop import benchmark


ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
SHORTER = {
    "1e6": "12",
    "2e6": "13",
    "5e5": "9",
    "500001": "9.01",
    "--step 1e-5": "--step 1e-3",
    "benchmark export DIR": "benchmark export DIR joint",
    "benchmark export cases  ": "benchmark export cases joint",
    "ENGINE/SETTING/mine": "cases/mine/reference.csv",
    "mine.csv --case bounce": "ENGINE/best/joint/dt=1e-3.csv --case joint",
}
DONE_ALREADY = ("resume RUN.zarr  ", "resume LONG.zarr  ")
"""They continue an unfinished run; what is finished is refused, in a sentence."""
PLAN = """
scenario = "inverting"
runs = [0]
[[axis]]
of = "initial.omega3"
linspace = [60.0, 200.0]
n = 4
[[axis]]
of = "friction.mu"
values = [0.2, 0.3]
"""


def commands(page: Path) -> list[str]:
    """Return the commands in the shell blocks of a page that begin with `tippetop`."""
    blocks = re.findall(r"```sh\n(.*?)```", page.read_text(encoding="utf-8"), flags=re.S)
    joined = [block.replace("\\\n", " ") for block in blocks]
    lines = [re.sub(r"\s+#.*", "  ", line) for block in joined for line in block.splitlines()]
    return [
        part.strip(" ") + "  "
        for line in lines
        for part in re.split("&&|;", line)
        if part.strip().startswith("tippetop ")
    ]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the commands find: scenarios, a plan, runs, motions in tables, and results of
    simulators.
    """
    place = tmp_path_factory.mktemp("typed")
    tt_words(place, "new tippe-top --out SCENARIO.toml")
    (place / "PLAN.toml").write_text(PLAN, encoding="utf-8")
    for name, mu in (("A", 0.3), ("B", 0.2), ("RUN", 0.3)):
        tt.run("inverting", friction={"mu": mu}, until=1.0).save(place / f"{name}.zarr")
    tt.run("rolling", until=2.0, output="keyframes", out=place / "LONG.zarr")
    tt.sweep(place / "PLAN.toml", place / "S.zarr")
    t = np.arange(1, 61) / 60
    axis = tt.run("inverting", until=1.0, output_times=t.tolist()).trajectory.axis.values
    axis = axis + 0.005 * np.random.default_rng(1).standard_normal(axis.shape)
    table = {"t [s]": t, AXIS: axis / np.linalg.norm(axis, axis=1)[:, None]}
    for name in ("MINE", "mine", "FILM", "film", "dt=1e-3", "dt=5e-4", "dt=2.5e-4"):
        written(place / f"{name}.csv", table)
    made = benchmark.export(place / "exported", ["joint"])
    (reference,) = (path for path in made if path.name == "reference.csv")
    for name in ("ENGINE", "OUT"):
        result = place / name / "best" / "joint"
        result.mkdir(parents=True)
        shutil.copy(reference, result / "dt=1e-3.csv")
    return place


def tt_words(place: Path, words: str) -> subprocess.CompletedProcess[str]:
    """A command, in a process of its own."""
    environment = os.environ | {"MPLBACKEND": "Agg", "COLUMNS": "120"}
    return subprocess.run(
        [sys.executable, "-m", "tippetop", *shlex.split(words)],
        cwd=place, env=environment, capture_output=True, text=True, timeout=300,
    )  # fmt: skip


def test_pages_have_commands() -> None:
    assert sum(len(commands(page)) for page in PAGES) > 45


@pytest.mark.slow
@pytest.mark.parametrize(
    "page", [page for page in PAGES if commands(page)], ids=lambda page: str(page.relative_to(ROOT))
)
def test_each_command_of_a_page_runs(page: Path, folder: Path, tmp_path: Path) -> None:
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    for line in commands(page):
        words = line.partition(" ")[2]
        for long, short in SHORTER.items():
            words = words.replace(long, short)
        made = re.search(r"(?:--out|^benchmark export) (\S+)", words)
        if made and (tmp_path / made[1]).exists():
            words += " --overwrite" * (not re.search("--overwrite|^sweep", words))
        done = tt_words(tmp_path, words)
        refused = line.partition(" ")[2] in DONE_ALREADY
        assert (done.returncode == 0) != refused, f"{words}: {done.returncode}: {done.stderr}"
        assert "Traceback" not in done.stderr
