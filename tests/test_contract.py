"""The layout stays within its goals; `lint-imports` itself checks that the contract is kept."""

import tomllib
from pathlib import Path


REPOSITORY = Path(__file__).parents[1]


def test_the_layout_stays_within_its_goals() -> None:
    """At most 26 parts in at most 11 layers below `python -m`."""
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text(encoding="utf-8"))
    layers = project["tool"]["importlinter"]["contracts"][0]["layers"][1:]
    assert len(layers) <= 11
    assert len(" | ".join(layers).split(" | ")) <= 26
