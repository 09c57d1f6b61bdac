"""Scenarios whose contact may change its phase: which they are, and what they say of
the contact.
"""

import math
from typing import Any

import numpy as np

from ..errors import InputError
from ..mechanics.contact.opening import ABOVE, SETTLED, kind_of, opened
from ..mechanics.contact.restitution import ContactLaw, stem_faults
from ..mechanics.contact.single_contact import LEAST_PATCH
from ..mechanics.contact.uniqueness import painleve_bound
from ..mechanics.friction import LAWS, PARTS, has_parts
from ..mechanics.system import System
from ..mechanics.systems import laws_of, opening_systems
from ..problem import Problem
from .law_change import law_name
from .own_records import own_records, with_records


def system_with_contact(system: System, tables: dict[str, Any]) -> System:
    """The system of a scenario: one whose contact may open where the scenario says so, by
    `[contact]`, `[stem]`, a Coulomb law without `eps`, or `on_liftoff = "fly"`. Raises InputError
    where it cannot.
    """
    friction, run = tables.get("friction"), tables.get("run")
    name = law_name(tables)
    law = system.laws.get(name, LAWS.get(name)) if isinstance(name, str) else None
    law = law and law.given(friction)
    law = law or LAWS["none"]  # an unknown law is refused later
    opening = system.opening
    asked = [f"`{name}`" for name in ("contact", "stem") if name in tables]
    if isinstance(run, dict) and run.get("on_liftoff") == "fly":
        asked.append('`run.on_liftoff = "fly"`')
    if law.regions:
        asked.append(f'`friction.law = "{name}"`')
    parts = [f"`friction.{part}`" for part in PARTS if law.torque and part in (friction or ())]
    asked += parts
    if not (asked or (law.set_valued and opening)):
        initial = tables.get("initial")
        above = [name for name in ABOVE if isinstance(initial, dict) and name in initial]
        if above and opening:
            raise InputError(
                f"`initial.{above[0]}` must stand with a contact that may open: give [contact], "
                "[stem], Coulomb's "
                'law without eps, or run.on_liftoff = "fly".'
            )
        return system
    bodies = opening_systems()
    spheres = [name for name, one in bodies.items() if one.opening and one.opening.sphere]
    if "stem" in tables and not (opening and opening.sphere):
        raise InputError(
            f"`stem` must be of a {' or '.join(spheres)}, but the system is {system.name}."
        )
    what = asked[0] if asked else f'`friction.law = "{name}"` without eps'
    if opening is None:
        raise InputError(
            f"{what} must be of a {' or '.join(bodies)}, but the system is {system.name}."
        )
    if not any(kind_of(law)):
        raise InputError(
            f'`friction.law` must not be "{name}" where the contact may open, by {what}.'
        )
    must = " or ".join(spheres)
    if parts and not opening.sphere:
        raise InputError(f"{parts[0]} must be of a {must}, but the system is {system.name}.")
    if law.regions and name not in laws_of(system):
        raise InputError(
            f'`friction.law = "{name}"` must be of a {must}, but the system is {system.name}.'
        )
    own = own_records(system)
    contact = opened(bodies[system.name], law, 2 if "stem" in tables else 1)
    taken = {event.name for event in contact.events} | {
        quantity.name for quantity in contact.quantities
    }
    names = [*(event.name for event in own[0]), *(quantity.name for quantity in own[1])]
    if clash := [name for name in names if name in taken]:
        raise InputError(
            f"`{clash[0]}` must be a new name, but `{system.name}` with {what} has it."
        )
    if isinstance(run, dict) and run.get("stop_when") == "settled":
        contact = with_records(contact, (SETTLED,), ())
    return with_records(contact, *own)


def rules_of(scenario: Any, system: System) -> ContactLaw | None:
    """What a checked scenario says of the contact; None where that never opens."""
    if system.contact is None:
        return None
    contact = scenario.contact.model_dump() if scenario.contact is not None else {}
    stem = scenario.stem.model_dump() if getattr(scenario, "stem", None) is not None else {}
    return ContactLaw(
        **{key: value for key, value in {**contact, **stem}.items() if value is not None}
    )


def contact_tables(problem: Problem) -> dict[str, dict[str, Any]]:
    """The tables of a resolved scenario that say how the contact opens and closes."""
    tables: dict[str, Any] = {
        n: dict(problem.tables[n]) for n in ("contact", "stem") if n in problem.tables
    }
    if problem.contact is not None:
        tables["contact"] = {"restitution": problem.contact.restitution, **tables["contact"]}
    return tables


HIGHEST = 1e6  # gap of a start, by the radius: beyond it a landing has no digits


def contact_faults(problem: Problem) -> list[str]:
    """What a contact that opens cannot be asked, in sentences."""
    if problem.contact is None:
        return []
    faults = []
    if problem.stop_when == "settled" and has_parts(problem.friction):
        faults.append(
            '`run.stop_when` must be "until" with `friction.mu_r` or `friction.mu_d`, but is '
            '"settled".'
        )
    if problem.precision == "quad" and problem.law.torque:
        of = (
            f"under `{problem.law_name}`"
            if problem.law.regions
            else "with `friction.mu_r` or `friction.mu_d`"
        )
        faults.append(f'`run.precision` must be "double" or "longdouble" {of}, but is "quad".')
    if problem.on_liftoff == "continue":
        faults.append(
            '`run.on_liftoff` must be "fly" or "stop" where the contact may change its phase.'
        )
    body, gap = problem.body(), float(problem.initial.get("gap", 0.0))
    R = max(body.R, abs(body.c))  # the length of a heavy top, whose tip has no radius
    if gap > HIGHEST * R:
        faults.append(
            f"`initial.gap` must be at most {HIGHEST:g} times the body = {HIGHEST * R:.6g}, but "
            f"is {gap:g}."
        )
    fastest = math.sqrt(2 * body.g * HIGHEST * R)  # of a fall from there
    if not abs(problem.initial.get("nu_z", 0.0)) <= fastest:
        faults.append(
            f"`initial.nu_z` must be within {fastest:.6g} m/s, that of a fall from {HIGHEST:g} "
            "times the body, but is "
            f"{problem.initial['nu_z']:g}."
        )
    least = (1 - 1e-12) * LEAST_PATCH * R  # which may be written
    if problem.law.regions and not least <= problem.friction.patch <= R:
        small = (
            ' A smaller disc slides as a point does: `law = "coulomb"`, without patch and mu_r.'
            if problem.friction.patch < R
            else ""
        )
        faults.append(
            f"`friction.patch` must be from {LEAST_PATCH * R:.3g} to parameters.R = {R:.6g}, "
            "but is "
            f"{problem.friction.patch:.9g}.{small}"
        )
    rules = problem.contact
    if rules.stem and stem_faults(problem.parameters["R"], rules.r, rules.h):
        return faults  # which are found already
    if problem.law.set_valued or problem.law.regions:
        faults += _unique(problem)
    if not faults and (mu_r := getattr(problem.friction, "mu_r", 0.0)):
        faults += _pressing(problem, mu_r)
    return faults + _under(problem)


UNDER = 1e-9  # of the radius: a stem that is deeper under the plane is no rounding


def on_stem(initial: dict[str, Any], R: float, rules: ContactLaw | None) -> dict[str, Any]:
    """The start with the gap at which the stem touches, where none is given and the sphere on the
    plane would put the stem under it.
    """
    if rules is None or not rules.stem or "gap" in initial:
        return initial
    least = _least_gap(initial, R, rules)
    return {**initial, "gap": least} if least > 0 else initial


def touches(problem: Problem) -> bool:
    """Whether a body starts on the plane because no gap was given: on its sphere, or on
    its stem.
    """
    rules, gap = problem.contact, problem.initial.get("gap")
    if rules is None or gap is None:
        return rules is not None
    return rules.stem and gap > 0 and gap == _least_gap(problem.initial, problem.body().R, rules)


def _least_gap(initial: dict[str, Any], R: float, rules: ContactLaw) -> float:
    """Height of the sphere above the plane where the stem touches it [m]; negative where the sphere
    does first.
    """
    return rules.r - R - rules.h * math.cos(float(initial.get("theta", 0.0)))


def _under(problem: Problem) -> list[str]:
    """A stem may not start under the plane."""
    rules, start = problem.contact, problem.initial
    assert rules is not None
    if not rules.stem:
        return []
    R, gap = problem.body().R, float(start.get("gap", 0.0))
    least = _least_gap(start, R, rules)
    if not gap < least - UNDER * R:
        return []
    return [
        f"`initial.gap` must be at least {least:.17g}, but is {gap:g}: the stem would be under "
        "the plane."
    ]


def _pressing(problem: Problem, mu_r: float) -> list[str]:
    """Rolling resistance presses a body into the plane or lifts it; where it lifts more than the
    force presses there is no normal force.
    """
    body, rules = problem.body(), problem.contact
    assert rules is not None
    mu = problem.friction.mu if problem.law.set_valued or problem.law.regions else 0.0
    s = np.sin(np.linspace(0, np.pi, 2001)[1:-1])
    z = np.cos(np.linspace(0, np.pi, 2001)[1:-1])
    bounds = []
    for R, c in [(body.R, body.c), *([(rules.r, body.c + rules.h)] if rules.stem else [])]:
        lever = np.abs(c * s)
        bounds.append(
            float(((body.I1 / body.m + lever * (lever - mu * np.abs(R - c * z))) / lever).min())
        )
    if mu_r < min(bounds):
        return []
    return [
        f"`friction.mu_r` must be less than {min(bounds):.3g}, or the contact force is not "
        f"unique, but is {mu_r:g}."
    ]


def _unique(problem: Problem) -> list[str]:
    """Coulomb friction has one contact force below Painleve's bound alone. [contact 2.6]"""
    rules = problem.contact
    assert rules is not None
    body = problem.body()
    balls = {"body": (body.c, body.R)} | (
        {"stem": (body.c + rules.h, rules.r)} if rules.stem else {}
    )
    bounds = {name: float(painleve_bound(body.m, body.I1, *ball)) for name, ball in balls.items()}
    name, least = min(bounds.items(), key=lambda item: item[1])
    mu = problem.friction.mu
    if mu < least:
        return []
    return [
        f"`friction.mu` must be less than {least:.4f}, but is {mu:g}: above it the contact "
        f"force of this {name} is not "
        "unique (Painleve)."
    ]
