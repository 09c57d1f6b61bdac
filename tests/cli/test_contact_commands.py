"""A top whose contact changes its phase, from the command line."""

from pathlib import Path

import pytest
from typed import answered, reported, typed


SCENARIO = """
system = "tippe-top"
[parameters]
m = 0.02
R = 0.02
alpha = 0.3
I1 = 2.994285714285714e-06
I3 = 3.2e-06
g = 9.82
[friction]
law = "coulomb"
mu = 0.3
[contact]
e_n = 0.5
[initial]
theta = 0.5
omega3 = 60
gap = 0.01
[run]
until = 0.2
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("contact")
    (folder / "a.toml").write_text(SCENARIO)
    assert typed(f"run {folder}/a.toml --out {folder}/a.zarr") == 0
    return folder


def test_info_tells_the_phases_in_a_line(folder: Path) -> None:
    _, out, _ = answered("info", folder / "a.zarr")
    line = " ".join(out.partition("phases")[2].split())
    assert "rolls once, flies" in line
    assert "first flies until 0.0451294 s" in line
    assert "at last rolls from 0.1337" in line
    phases = reported(f"info {folder}/a.zarr")["contact_phases"]
    assert phases["counts"]["roll"] == 1
    assert phases["impacts"] == phases["counts"]["flight"]


def test_a_check_says_the_phase_of_the_start(folder: Path) -> None:
    start = reported(f"check {folder}/a.toml")["at_start"]
    assert start["phase"]["value"] == "flight"
    assert start["normal_force"]["value"] == 0
    assert "jellett_taken" not in start
