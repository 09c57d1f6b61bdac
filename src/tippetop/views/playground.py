"""The playground: a page that integrates the tippe top of whoever opens it, by the formulas of this package."""

import math
from typing import Any

from ..errors import InputError
from ..mechanics.friction import LAWS
from ..mechanics.systems import SYSTEMS
from ..problem import Problem
from ..scenario import build
from ..scenario.reading import presets
from . import formulas, pages


TITLE = "Tippe top playground"
FIRST = "inverting"


def playground() -> str:
    """The text of its HTML file."""
    system = SYSTEMS["tippe-top"]
    scripts = {"formulas.js": formulas.motions(system, system.forms["vector"], dict(LAWS))}
    data = {"presets": sorted(filter(None, map(_preset, presets())), key=lambda p: (p["name"] != FIRST, p["name"]))}
    return pages.page(TITLE, "page_playground.js", data, scripts, aside=pages.source("playground.html"), about=ABOUT)


ABOUT = "Change anything: the motion is integrated here, by the equations of the engine. tippetop runs it to rounding."


def _preset(name: str) -> dict[str, Any] | None:
    """A preset as the page takes it; None where it is of another system, or its contact changes its phase."""
    try:
        problem = build.load(name)
    except InputError:
        return None
    if problem.system is not SYSTEMS["tippe-top"]:
        return None
    return {"name": name, "words": problem.system.title, **given(problem), "until": min(problem.until, 30.0)}


def given(problem: Problem) -> dict[str, Any]:
    """What a page needs to integrate a problem: parameters, law, initial numbers other than 0."""
    data, at_rest = dict(problem.initial), bool(problem.initial.get("centre_at_rest"))
    theta = data.get("theta", 0.0)
    angles = problem.system.start(data, math.sin(theta), math.cos(theta), problem.body())
    names = [n for n in formulas.initial_names(problem.system) if not (at_rest and n in ("nu_x", "nu_y"))]
    initial = {name: float(getattr(angles, name, data.get(name, 0.0))) for name in names}
    return {
        "parameters": dict(problem.parameters),
        "law": problem.law_name,
        "friction": problem.friction._asdict(),
        "atRest": at_rest,
        "initial": {name: value for name, value in initial.items() if value},
    }
