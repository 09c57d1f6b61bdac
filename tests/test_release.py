"""Versions and Pythons agree in all files of a release."""

import re
import tomllib
from pathlib import Path

from packaging.requirements import Requirement
from packaging.version import Version


ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def text(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def test_one_version_stands_everywhere() -> None:
    assert f"\nversion: {PROJECT['version']}\n" in text("CITATION.cff")
    assert f"## {PROJECT['version']}" in text("CHANGELOG.md")


def test_every_python_that_is_promised_is_tried() -> None:
    tried = re.search(r"python: \[(.*)\]", text(".github/workflows/tests.yml"))
    assert tried
    promised = {c.rpartition(" ")[2] for c in PROJECT["classifiers"] if re.search(r":: 3\.\d+$", c)}
    assert promised <= set(re.findall(r"3\.\d+", tried[1]))


def test_the_lock_has_every_dependency_within_its_bounds() -> None:
    lines = text(f"locks/{PROJECT['version']}.txt").splitlines()
    lock = dict(line.split("==") for line in lines if "==" in line)
    names = {name.lower().replace("_", "-"): Version(version) for name, version in lock.items()}
    extras = PROJECT["optional-dependencies"]
    wanted = [
        *PROJECT["dependencies"],
        *(
            one
            for group in ("figures", "grids", "export", "sweep", "cluster", "film")
            for one in extras[group]
        ),
    ]
    for requirement in map(Requirement, wanted):
        if requirement.name != "tippetop":
            assert names[requirement.name.lower()] in requirement.specifier, requirement
