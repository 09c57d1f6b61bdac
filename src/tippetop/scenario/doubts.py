"""Warnings about a scenario that is allowed but hardly meant.

A checked problem goes in; sentences come out, which the library issues as warnings.
"""

import math

from ..mechanics.friction import PARTS, is_frictionless
from ..mechanics.units import INERTIA, KILOGRAM, METRE
from ..problem import Problem
from .contact import touches


# by unit: a larger parameter of a top looks like another unit
LARGEST = {KILOGRAM: (20.0, "grams"), METRE: (1.0, "millimetres or centimetres")}
# moments of inertia over mass times this size squared: of a sphere with a stem; of a disc on a leg
PLAUSIBLE = {"R": (0.01, 4.0), "l": (0.0, 100.0)}


def doubts(problem: Problem) -> list[str]:
    """Return one sentence for each doubt; empty for most scenarios."""
    initial = problem.initial
    given = problem.parameters
    sentences = []
    theta = float(initial.get("theta", 0.0))
    if "omega3" in problem.system.initial:
        turns = initial.get("phi_dot", 0.0) != 0 and theta not in (0.0, math.pi)
        if not turns and not {"omega3", "psi_dot", "spin"} & set(initial):
            sentences.append("`initial.omega3` is not given: this top does not spin.")
        if "theta" not in initial and starts_at_pole(problem):
            sentences.append(
                "`initial.theta` is not given: this top starts exactly upright, and stays there."
            )
    if problem.law.set_valued and (start := contact_start(problem)):
        sentences.append(
            f"the contact point starts {start}. Under Coulomb's law itself it may never slide."
        )
    falls = any(event.ends == "fallen" for event in problem.system.events)
    if falls and abs(theta) >= math.pi / 2:
        sentences.append(
            f"`initial.theta` is {theta:g} rad, beyond pi/2: this body has fallen, and lies below "
            "its plane."
        )
    size = next((name for name in PLAUSIBLE if name in given), "")
    whole = given.get("m", 0.0) * given.get(size, 0.0) ** 2
    for name, rule in problem.system.parameters.items():
        value = float(given[name])
        most, other = LARGEST.get(rule.unit, (math.inf, ""))
        if value > most:
            sentences.append(
                f"`parameters.{name}` is {value:g} {rule.unit.symbol}, which looks like "
                f"{other}: units are SI."
            )
        low, high = PLAUSIBLE.get(size, (0.0, math.inf))
        if rule.unit == INERTIA and whole and not low * whole <= value <= high * whole:
            sentences.append(
                f"`parameters.{name}` is {value:g} kg m2, {value / whole:.3g} times m {size}^2 = "
                f"{whole:.3g} kg m2: hardly a body of this mass and size; units are SI."
            )
    parts = [f"`friction.{name}`" for name in PARTS if getattr(problem.friction, name, 0.0) > 0]
    lies_flat = any(event.ends == "flat" for event in problem.system.events)
    if problem.law.torque and parts and not lies_flat:
        sentences.append(
            f"{' and '.join(parts)} can bring this body to rest, for which there is no phase: a "
            "run then takes some 1e4 to 1e7 steps a second. End it before."
        )
    return sentences


def starts_at_pole(problem: Problem) -> bool:
    """Return whether the axis starts exactly vertical, with nothing that turns it away."""
    initial = problem.initial
    if "tilt" in problem.system.initial:  # it has no axis of symmetry
        return False
    if any(problem.surroundings.get(key) for key in ("plane.tilt", "plane.omega")):
        return False
    turning = ["theta_dot"]
    if not is_frictionless(problem.friction):
        turning += ["nu_x", "nu_y"]
    at_rest = not any(initial.get(name) for name in turning)
    return at_rest and initial.get("theta", 0.0) in (0.0, math.pi)


def contact_start(problem: Problem) -> str:
    """Return how the contact point starts where the scenario leaves that out, or an empty text.

    The clause continues "the contact point starts" in `doubts`; `forecast` shows it alone.
    """
    given = {"nu_x", "nu_y", "nu_z", "centre_at_rest", "spin"} & set(problem.initial)
    stands = problem.contact is None or touches(problem)
    if given or not stands or is_frictionless(problem.friction) or starts_at_pole(problem):
        return ""
    return (
        "at rest, so that the body rolls at first, if friction can hold it: "
        "`initial.centre_at_rest = true` starts with sliding, `initial.nu_x = 0` confirms this "
        "start"
    )
