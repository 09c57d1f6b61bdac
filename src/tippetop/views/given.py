"""What a page needs to integrate a problem by itself."""

import base64
import math
from typing import Any

import numpy as np

from ..problem import Problem
from .formulas import initial_names


def given(problem: Problem) -> dict[str, Any]:
    """What a page needs to integrate a problem: parameters, law, initial numbers other than 0."""
    data, at_rest = dict(problem.initial), bool(problem.initial.get("centre_at_rest"))
    theta = data.get("theta", 0.0)
    angles = problem.system.start(data, math.sin(theta), math.cos(theta), problem.body())
    names = [n for n in initial_names(problem.system) if not (at_rest and n in ("nu_x", "nu_y"))]
    initial = {name: float(getattr(angles, name, data.get(name, 0.0))) for name in names}
    return {
        "parameters": dict(problem.parameters),
        "law": problem.law_name,
        "friction": problem.friction._asdict(),
        "atRest": at_rest,
        "initial": {name: value for name, value in initial.items() if value},
    }


def encoded(values: np.ndarray, kind: str) -> str:
    """Numbers as text, in the type `kind` of numpy."""
    return base64.b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode()
