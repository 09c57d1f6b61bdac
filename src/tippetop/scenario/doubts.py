"""Warnings about a scenario that is allowed but hardly meant: numbers left out, other units, a body
below the plane.
"""

import math

from ..mechanics.friction import PARTS
from ..mechanics.units import INERTIA, KILOGRAM, METRE
from ..problem import Problem


LARGEST = {
    KILOGRAM.symbol: (20.0, "grams"),
    METRE.symbol: (1.0, "millimetres or centimetres"),
}
"""By unit: above it, a parameter of a top that stands on a table looks like another unit."""

PLAUSIBLE = {"R": (0.01, 4.0), "l": (0.0, 100.0)}
"""Moments of inertia over mass times this size squared: of a sphere with a stem; of a disc on a
long or short leg.
"""


def doubts(problem: Problem) -> list[str]:
    """Return one sentence for each doubt; empty for most scenarios."""
    return [
        *_left_out(problem),
        *_fallen(problem),
        *_other_units(problem),
        *_odd_inertia(problem),
        *_rests(problem),
    ]


def _rests(problem: Problem) -> list[str]:
    """Return a warning where torques bring the body to rest, which is stiff."""
    given = [f"`friction.{name}`" for name in PARTS if getattr(problem.friction, name, 0.0) > 0]
    if not problem.law.torque or not given:
        return []
    return [
        f"{' and '.join(given)} can bring this body to rest, for which there is no phase: a run "
        "then takes some "
        "1e4 to 1e7 steps a second. End it before."
    ]


def _fallen(problem: Problem) -> list[str]:
    """A body that falls to the plane at theta = pi/2, and begins beyond."""
    theta = float(problem.initial.get("theta", 0.0))
    if abs(theta) < math.pi / 2 or not any(
        event.ends == "fallen" for event in problem.system.events
    ):
        return []
    return [
        f"`initial.theta` is {theta:g} rad, beyond pi/2: this body has fallen, and lies below "
        "its plane."
    ]


def _left_out(problem: Problem) -> list[str]:
    """Initial numbers that are zero because nobody gave them, where that decides the motion."""
    initial, known = problem.initial, problem.system.initial
    sentences = []
    if "omega3" in known and not {"omega3", "psi_dot"} & set(initial):
        sentences.append("`initial.omega3` is not given: this top does not spin.")
    if "omega3" in known and not {"theta", "theta_dot"} & set(initial):
        sentences.append(
            "`initial.theta` is not given: this top starts exactly upright, and stays there."
        )
    return sentences


def _other_units(problem: Problem) -> list[str]:
    """Parameters that look as if they were in another unit."""
    sentences = []
    for name, rule in problem.system.parameters.items():
        most, other = LARGEST.get(rule.unit.symbol, (float("inf"), ""))
        value = float(problem.parameters[name])
        if value > most:
            sentences.append(
                f"`parameters.{name}` is {value:g} {rule.unit.symbol}, which looks like "
                f"{other}: units are SI."
            )
    return sentences


def _odd_inertia(problem: Problem) -> list[str]:
    """Return a sentence for each moment of inertia that no body of this mass and size can have."""
    given, rules = problem.parameters, problem.system.parameters
    size = next((name for name in PLAUSIBLE if name in given), None)
    if size is None or "m" not in given:
        return []
    least, most = PLAUSIBLE[size]
    whole = given["m"] * given[size] ** 2
    return [
        f"`parameters.{name}` is {given[name]:g} kg m2, {given[name] / whole:.3g} times m "
        f"{size}^2 = "
        f"{whole:.3g} kg m2: hardly a body of this mass and size; units are SI."
        for name, rule in rules.items()
        if rule.unit == INERTIA and not least * whole <= given[name] <= most * whole
    ]
