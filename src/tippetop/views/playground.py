"""The playground: a page that integrates a tippe top with the formulas of this package."""

from typing import Any

from ..mechanics.friction import LAWS
from ..scenario import build
from ..scenario.reading import presets
from . import formulas, pages
from .encoding import problem_data
from .playground_formulas import TOP, contacts


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
    scripts = {"formulas.js": formulas.NOTHING, "phases.js": contacts(BY_NAME)}
    aside = pages.source("playground.html")
    return pages.page(TITLE, "page_playground.js", data, scripts, aside=aside, about=ABOUT)


def _preset(name: str) -> dict[str, Any] | None:
    """Return a preset of a tippe top that slides as the page takes it; None for another system."""
    problem = build.load(name)
    if problem.system.name != TOP.name:
        return None
    about = {"name": name, "words": problem.system.title, "until": min(problem.until, 30.0)}
    return about | given(problem)


def given(problem: Any) -> dict[str, Any]:
    """Return the numbers of a tippe top as the page takes them."""
    contact, about = problem.contact, problem_data(problem)
    about["law"] = next(name for name, law in BY_NAME.items() if law is type(problem.friction))
    stem = {"r": contact.r, "h": contact.h} if contact and contact.stem else None
    return about | {"e_n": contact.e_n if contact else 0.0, "stem": stem}
