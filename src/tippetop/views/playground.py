"""The playground: a page that integrates a tippe top with the formulas of this package."""

from typing import Any

from ..mechanics.friction import LAWS
from ..runs.starting import load
from ..scenario.reading import presets
from . import pages
from .phase_formulas import contacts, is_movable, numbers_for_page


TITLE = "Tippe top playground"
FIRST = "inverting"
BY_NAME = {
    "viscous": LAWS["viscous"],
    "contensou": LAWS["contensou"],
    "coulomb": LAWS["coulomb"].without,
    "regularised": LAWS["coulomb"],
    **{name: LAWS[name] for name in ("mixed", "stribeck", "latitude", "none")},
}
"""The laws of the page, by the name under which it offers them."""
ABOUT = "Move a slider: this page integrates the motion with the equations of tippetop."


def playground() -> str:
    """Return the text of its HTML file."""
    tops = filter(None, map(_preset, presets()))
    data = {"presets": sorted(tops, key=lambda p: (p["name"] != FIRST, p["name"]))}
    aside = pages.source("playground.html")
    return pages.page(
        TITLE, "page_playground.js", data, contacts(BY_NAME), aside=aside, about=ABOUT
    )


def _preset(name: str) -> dict[str, Any] | None:
    """Return a preset as JSON for the page; None of a body that it cannot integrate.

    Its law must be in `BY_NAME`; the page integrates 30 s at most.
    """
    problem = load(name)
    if not is_movable(problem):
        return None
    law = next(law for law, record in BY_NAME.items() if record is type(problem.friction))
    about = numbers_for_page(problem)
    title = presets()[name].partition("\n")[0].strip("# .")
    about |= {"name": name, "words": title, "law": law}
    return about | {"until": min(about["until"], 30.0)}
