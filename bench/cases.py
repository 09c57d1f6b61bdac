"""The named cases: each gives a table of numbers, and writes it to results/NAME.json."""

from collections.abc import Callable
from functools import partial
from typing import Any

from . import ensemble, formulations, landscape, precision, scaling, startup, storing, sweeps
from .precision import Course


COURSES = {
    "inversion": Course("The canonical inversion", "inverting", 10.0, 10.0, "quad", True),
    "rolling": Course("A long rolling run", "rolling", 400.0, 50.0, "longdouble", False),
    "heavy-top": Course("A heavy top with a fixed tip", "heavy-top", 100.0, 10.0, "longdouble", True),
    "cylinder": Course("An eccentric cylinder that glides", "gliding-cylinder", 4.0, 4.0, "longdouble", True),
}
CASES: dict[str, Callable[[bool], dict[str, Any]]] = {
    **{name: partial(precision.compare, course) for name, course in COURSES.items()},
    "ensemble": ensemble.compare,
    "formulations": formulations.compare,
    "sweep": sweeps.compare,
    "surface": landscape.compare,
    "storing": storing.compare,
    "startup": startup.compare,
    "scaling": scaling.compare,
}
