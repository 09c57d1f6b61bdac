"""Data of pages: the numbers of a problem, and arrays as text."""

import base64
import math
from typing import Any

import numpy as np

from ..problem import Problem
from .formulas import initial_names


def problem_data(problem: Problem) -> dict[str, Any]:
    """Return parameters, friction law and initial numbers other than 0."""
    data, at_rest = dict(problem.initial), bool(problem.initial.get("centre_at_rest"))
    theta = data.get("theta", 0.0)
    angles = problem.system.start(data, math.sin(theta), math.cos(theta), problem.body())
    names = [n for n in initial_names(problem.system) if not (at_rest and n in ("nu_x", "nu_y"))]
    initial = {name: float(getattr(angles, name, data.get(name, 0.0))) for name in names}
    return {
        "parameters": dict(problem.parameters),
        "law": problem.law.key,
        "friction": problem.friction._asdict(),
        "atRest": at_rest,
        "initial": {name: value for name, value in initial.items() if value},
    }


def encode(values: np.ndarray, kind: str) -> str:
    """Return an array in base64, in the type `kind` of numpy."""
    return base64.b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode()
