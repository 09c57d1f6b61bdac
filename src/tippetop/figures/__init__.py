"""Labelled tables become matplotlib figures: one function per figure, no files, no physics."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from . import run, stability
from .style import save, styled


KINDS: dict[str, Callable] = {
    "theta": run.theta,
    "normal-force": run.normal_force,
    "drift": run.drift,
    "sphere": run.sphere,
    "energy": run.energy,
    "phase": stability.phase_of_run,
}


NEEDED = {"sphere": "axis", "phase": "jellett"}
"""The column without which a figure has nothing to show."""


def draw(kind: str, groups: dict[str, Any], attrs: dict[str, Any], path: Path) -> None:
    """Draws one kind of figure of a run to a file. groups: trajectory and events, Datasets or columns."""
    from ..scenario import ScenarioError

    if NEEDED.get(kind, "time") not in groups["trajectory"]:
        raise ScenarioError([f"the figure `{kind}` must have `{NEEDED[kind]}` to draw, but this system has none."])
    with styled():
        save(KINDS[kind](groups["trajectory"], groups["events"], attrs), path)


def check_kind(kind: str) -> None:
    """Raises ScenarioError if there is no such figure."""
    from ..scenario import ScenarioError

    if kind not in KINDS:
        raise ScenarioError([f"the kind of figure must be one of {', '.join(KINDS)}, but is `{kind}`."])
