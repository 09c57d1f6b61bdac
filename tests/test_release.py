"""What releases are made of says the same in every file: versions, dependencies, Pythons."""

import re
import tomllib
from pathlib import Path


ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
ELSEWHERE = {"heyoka": "heyoka.py", "matplotlib": "matplotlib-base"}
"""Names that conda-forge has of its own."""


def text(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def parted(requirement: str) -> tuple[str, str]:
    """heyoka>=7,<8: ("heyoka.py", ">=7,<8")."""
    found = re.fullmatch(r"([\w.-]+?) ?([<>=].*)", requirement)
    assert found, requirement
    return ELSEWHERE.get(found[1], found[1]), found[2]


def test_the_conda_recipe_has_the_dependencies_of_a_run_that_is_drawn() -> None:
    extras = PROJECT["optional-dependencies"]
    wanted: dict[str, str] = {}
    for requirement in [
        *PROJECT["dependencies"],
        *extras["figures"],
        *extras["grids"],
        *extras["sweep"],
    ]:
        if requirement.startswith("tippetop"):
            continue
        name, bound = parted(requirement)
        wanted[name] = max(bound, wanted.get(name, ""))
    recipe = re.search(r"  run:\n((?:    - .*\n)+)", text("packaging/conda/recipe.yaml"))
    assert recipe
    given = dict(parted(line) for line in re.findall(r"- (.*)", recipe[1]))
    assert given.pop("python") == PROJECT["requires-python"]
    assert given == wanted


def test_one_version_stands_everywhere() -> None:
    assert f"\nversion: {PROJECT['version']}\n" in text("CITATION.cff")
    assert f'version: "{PROJECT["version"]}"' in text("packaging/conda/recipe.yaml")
    assert f"## {PROJECT['version']}" in text("CHANGELOG.md")


def test_every_python_that_is_promised_is_tried() -> None:
    tried = re.search(r"python: \[(.*)\]", text(".github/workflows/tests.yml"))
    assert tried
    promised = {c.rpartition(" ")[2] for c in PROJECT["classifiers"] if re.search(r":: 3\.\d+$", c)}
    assert promised <= set(re.findall(r"3\.\d+", tried[1]))


def test_the_dockerfile_is_short_and_runs_as_a_user() -> None:
    lines = text("packaging/Dockerfile").splitlines()
    assert len(lines) <= 20
    assert lines.index("USER user") < next(
        i for i, line in enumerate(lines) if line.startswith("RUN tippetop")
    )
