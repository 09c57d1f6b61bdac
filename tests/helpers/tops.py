"""Strategies for scenarios: random systems, bodies, friction laws, contacts and starts."""

import math
from typing import Any

from hypothesis import strategies as st

from tippetop.mechanics.friction import LAWS
from tippetop.mechanics.systems import SYSTEMS, opening_systems


RANGES = {
    "theta": (0.1, math.pi),
    "mu": (1e-3, 1.0),
    "eps": (1e-4, 0.1),
    "patch": (1e-5, 2e-3),
    "mu_r": (1e-7, 1e-4),
}
SHORT = {"nu_x", "nu_y", "x", "y"}


def spread(low: float, high: float) -> st.SearchStrategy[float]:
    """Numbers between two positive ones, evenly in their logarithm."""
    return st.floats(math.log(low), math.log(high)).map(math.exp)


def signed(low: float, high: float) -> st.SearchStrategy[float]:
    """The same with either sign."""
    return st.tuples(st.sampled_from([-1, 1]), spread(low, high)).map(math.prod)


def friction(law: Any) -> st.SearchStrategy[dict[str, Any]]:
    """The table of a friction law."""
    numbers = {name: spread(*RANGES.get(name, (0.01, 1.0))) for name in law.parameters}
    return st.fixed_dictionaries({"law": st.just(law.key), **numbers})


@st.composite
def bodies(draw: st.DrawFn, system: Any, scale: float) -> dict[str, float]:
    """Parameters of a ball or a bar whose size is within a factor `scale` of two centimetres."""
    m, R = (0.02 * draw(spread(1 / scale, scale)) for _ in "mR")
    I3 = m * R * R * draw(spread(0.2, 1.0))
    I1 = I3 * draw(st.floats(0.55, 3.0))  # every body of revolution has I3 <= 2 I1
    alpha = draw(st.floats(0.02, 0.9))
    if "alpha" in system.parameters and system.parameters["alpha"].nonzero:
        alpha *= draw(st.sampled_from([-1, 1]))
    numbers = {
        "m": m,
        "R": R,
        "l": R * draw(spread(0.3, 3.0)),
        "g": draw(st.just(9.82) | spread(9.82 / scale, 9.82 * scale)),
        "alpha": alpha,
        "I3": I3,
        "I1": I1,
        "I2": abs(I1 - I3) + 2 * min(I1, I3) * draw(st.floats(0.01, 0.99)),  # triangle inequality
        "I": m * R * R * draw(st.floats(0.2, 0.9)),
        "a": R * draw(spread(0.3, 3.0)),
        "b": R,
        "c": alpha * R,
        "delta": draw(st.floats(-1.5, 1.5)),
        **{name: R * draw(st.floats(-0.3, 0.3)) for name in "xyh"},
        "ring": R,
        "tube": R * draw(spread(0.01, 1.0)),
    }
    return {name: numbers[name] for name in system.parameters}


def starts(system: Any, fastest: float) -> st.SearchStrategy[dict[str, float]]:
    """A start at any inclination, with rates up to `fastest`."""
    rival = {name for a in system.alternatives for name in (a.name, *a.others)}
    rates = {
        name: signed(1e-3 * most, most)
        for name in {*system.initial} - rival - {"theta"}
        for most in [1.0 if name in SHORT else fastest]
    }
    return st.fixed_dictionaries({"theta": st.floats(0.002, math.pi - 0.002)}, optional=rates)


@st.composite
def scenarios(
    draw: st.DrawFn, name: str, law: str = "", scale: float = 30.0, fastest: float = 400.0
) -> dict[str, Any]:
    """The tables of a scenario of a system and a law (any by default), without [run]."""
    system = SYSTEMS[name]
    tables: dict[str, Any] = {
        "system": name,
        "form": draw(st.sampled_from(sorted(system.forms))),
        "parameters": draw(bodies(system, scale)),
        "initial": draw(starts(system, fastest)),
    }
    if system.frictional:
        smooth = sorted(key for key, record in system.laws.items() if not record.regions)
        tables["friction"] = draw(friction(system.laws[law or draw(st.sampled_from(smooth))]))
    return tables


@st.composite
def openings(draw: st.DrawFn, tables: dict[str, Any]) -> dict[str, Any]:
    """The same with a contact that sticks, opens and closes, if the system has one."""
    if tables["system"] not in opening_systems():
        return tables
    round_body = tables["system"] == "tippe-top"
    laws = [LAWS["coulomb"].given(()), *([LAWS["contensou"]] if round_body else [])]
    choices = {
        "friction": st.sampled_from(laws).flatmap(friction),
        "contact": st.fixed_dictionaries(
            {
                "restitution": st.sampled_from(["energetic", "poisson", "newton"]),
                "e_n": st.floats(0.0, 1.0),
            }
        ),
    }
    if round_body:
        R = tables["parameters"]["R"]
        choices["stem"] = st.tuples(st.floats(0.1, 0.9), st.floats(0.01, 1.0)).map(
            lambda sizes: {"r": R * sizes[0], "h": R * (1 - sizes[0] + sizes[1])}
        )
    closed = {key: value for key, value in tables.items() if key != "form"}
    above = {"gap": spread(1e-7, 1e-2), "nu_z": st.floats(-0.5, 0.5)}
    initial = tables["initial"] | draw(st.fixed_dictionaries({}, optional=above))
    return closed | draw(st.fixed_dictionaries({}, optional=choices)) | {"initial": initial}
