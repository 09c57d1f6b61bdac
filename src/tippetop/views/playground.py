"""The playground: a page that integrates a tippe top with the formulas of this package."""

from typing import Any

from ..errors import InputError
from ..mechanics.systems import SYSTEMS
from ..scenario import build
from ..scenario.reading import presets
from . import formulas, pages
from .encoding import problem_data


TITLE = "Tippe top playground"
FIRST = "inverting"


def playground() -> str:
    """Return the text of its HTML file."""
    system = SYSTEMS["tippe-top"]
    laws = {name: law for name, law in system.laws.items() if law.coefficient is not None}
    scripts = {"formulas.js": formulas.motions(system, system.forms["vector"], laws)}
    data = {
        "presets": sorted(
            filter(None, map(_preset, presets())), key=lambda p: (p["name"] != FIRST, p["name"])
        )
    }
    return pages.page(
        TITLE,
        "page_playground.js",
        data,
        scripts,
        aside=pages.source("playground.html"),
        about=ABOUT,
    )


ABOUT = "Move a slider: this page integrates the motion with the equations of tippetop."


def _preset(name: str) -> dict[str, Any] | None:
    """Return a preset as the page takes it; None for another system, or a contact that may open."""
    try:
        problem = build.load(name)
    except InputError:
        return None
    if problem.system is not SYSTEMS["tippe-top"]:
        return None
    return {
        "name": name,
        "words": problem.system.title,
        **problem_data(problem),
        "until": min(problem.until, 30.0),
    }
