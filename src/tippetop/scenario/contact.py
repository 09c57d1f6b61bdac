"""Scenarios whose contact may change its phase: their systems, and their faults.

`build` calls it: tables go in, a system with phases and sentences come out.
"""

import math
from collections.abc import Mapping
from typing import Any

from ..arguments import PlainData
from ..errors import InputError, true_sentences
from ..mechanics.contact.body import size
from ..mechanics.contact.contact_phases import LEAST_PATCH
from ..mechanics.contact.frame import Asymmetric
from ..mechanics.contact.opening import ABOVE, SETTLED, kind_of, opened
from ..mechanics.contact.restitution import ContactLaw, stem_faults
from ..mechanics.contact.rows import energy
from ..mechanics.contact.surrounded import surrounded_rolling
from ..mechanics.contact.surroundings import TABLES, groups_in
from ..mechanics.contact.uniqueness import most_rolling, painleve_bound
from ..mechanics.friction import LAWS, PARTS, has_parts
from ..mechanics.system import System
from ..mechanics.systems import opening_systems, surroundable_systems
from ..mechanics.units import METRE
from ..problem import Problem
from .identity import user_records
from .reading import law_name
from .schema import ContactTable


HIGHEST = 1e6  # gap of a start, by the radius: beyond it a landing has no digits
UNDER = 1e-9  # of the radius: a stem that is deeper under the plane is not there by rounding


def system_with_contact(system: System, tables: PlainData) -> System:
    """Return the system of a scenario, with a contact that may open if the scenario requires it.

    `[contact]`, `[stem]`, a Coulomb law without `eps`, and `on_liftoff = "fly"` require it; the
    tables are not checked yet. Raises InputError, which names the first of these, if it cannot.
    """
    friction, run, initial = (
        table if isinstance(table := tables.get(name), dict) else {}
        for name in ("friction", "run", "initial")
    )
    name = law_name(tables)
    law = system.laws.get(name, LAWS.get(name, LAWS["none"])).given(friction)
    opening = system.opening
    around = groups_in(tables)
    given = [name for name in TABLES if name in tables]
    takes = surroundable_systems() if around else {}
    if around and system.name not in takes:
        raise InputError(
            f"`{given[0]}` must be of a {' or '.join(takes)}, but the system is {system.name}."
        )
    if "turntable" in around and ("tilt" in around or "axis" not in system.vectors):
        raise InputError(
            "a plane that turns (`plane.omega`) must be level, without `plane.tilt` and "
            "`plane.azimuth`, and its body no cylinder."
        )
    if around and not opening:
        return surrounded_rolling(takes[system.name], around).with_records(*user_records(system))
    features = (  # the requirement, whether it is given, and the Opening that has it; "": any
        ("`contact`", "contact" in tables, ""),
        ("`stem`", "stem" in tables, "sphere"),
        *((f"`{name}`", True, "") for name in given),
        ('`run.on_liftoff = "fly"`', run.get("on_liftoff") == "fly", ""),
        (f'`friction.law = "{name}"`', bool(law.regions), "rounded"),
        *((f"`friction.{part}`", law.torque and part in friction, "rounded") for part in PARTS),
        (f'`friction.law = "{name}"` without eps', law.set_valued and opening, ""),
    )
    asked = [(feature, kind) for feature, given, kind in features if given]
    if not asked:
        above = [key for key in ABOVE if key in initial]
        if above and opening:
            raise InputError(
                f"`initial.{above[0]}` requires a contact that may open: give [contact], [stem], "
                'Coulomb\'s law without eps, or run.on_liftoff = "fly".'
            )
        return system
    bodies = opening_systems()
    for feature, kind in asked:
        fits = [key for key, body in bodies.items() if not kind or getattr(body.opening, kind)]
        if system.name not in fits:
            raise InputError(
                f"{feature} must be of a {' or '.join(fits)}, but the system is {system.name}."
            )
    if not any(kind_of(law)):
        raise InputError(
            f'`friction.law` must not be "{name}" where the contact may open, by {asked[0][0]}.'
        )
    own = user_records(system)
    contact = opened(bodies[system.name], law, 2 if "stem" in tables else 1, around)
    clash = [r.name for records in own for r in records if r.name in contact.record_names]
    if clash:
        raise InputError(
            f"`{clash[0]}` must be a new name, but `{system.name}` with {asked[0][0]} has it."
        )
    if run.get("stop_when") == "settled":
        contact = contact.with_records((SETTLED,), ())
    return contact.with_records(*own)


def rules_of(scenario: Any, system: System) -> ContactLaw | None:
    """Return the contact law of a checked scenario; None where the contact never opens."""
    if system.contact is None:
        return None
    stem = getattr(scenario, "stem", None)
    return ContactLaw(**dict(scenario.contact or ContactTable()), **dict(stem or {}))


def contact_faults(problem: Problem) -> list[str]:
    """Return sentences on the faults of a contact that opens; [] where it never opens."""
    rules = problem.contact
    law = problem.law
    friction = problem.friction
    if rules is None:
        return []
    body = problem.body()
    gap = float(problem.initial.get("gap", 0.0))
    R = size(body)
    fastest = math.sqrt(2 * body.g * HIGHEST * R)
    nu_z = problem.initial.get("nu_z", 0.0)
    parts = "`friction.mu_r` or `friction.mu_d`"
    patch = getattr(friction, "patch", R)
    disc = bool(law.regions)
    under = f"under `{problem.law.key}`" if disc else f"with {parts}"
    smaller = (
        ' A smaller disc slides as a point does: `law = "coulomb"`, without patch and mu_r.'
        if patch < R
        else ""
    )
    faults = true_sentences(
        {
            '`run.stop_when` must be "until" in air or on a tilted plane, but is "settled".': (
                problem.stop_when == "settled" and problem.surroundings
            ),
            "`plane.azimuth` must be 0 for a cylinder, which moves along x.": (
                "axis" not in problem.system.vectors and problem.surroundings.get("plane.azimuth")
            ),
            f'`run.stop_when` must be "until" with {parts}, but is "settled".': (
                problem.stop_when == "settled" and has_parts(friction)
            ),
            f'`run.precision` must be "double" or "longdouble" {under}, but is "quad".': (
                problem.precision == "quad" and law.torque
            ),
            '`run.on_liftoff` must be "fly" or "stop" where the contact may change its phase.': (
                problem.on_liftoff == "continue"
            ),
            f"`initial.gap` must be at most {HIGHEST:g} times the body = {HIGHEST * R:.6g}, "
            f"but is {gap:g}.": (gap > HIGHEST * R),
            f"`initial.nu_z` must be within {fastest:.6g} m/s, that of a fall from "
            f"{HIGHEST:g} times the body, but is {nu_z:g}.": (not abs(nu_z) <= fastest),
            f"`friction.patch` must be from {LEAST_PATCH * R:.3g} to the size of the body = "
            f"{R:.6g}, but is {patch:.9g}.{smaller}": (
                disc and not (1 - 1e-12) * LEAST_PATCH * R <= patch <= R  # the least is allowed
            ),
        }
    )
    if rules.stem and stem_faults(problem.parameters["R"], rules.r, rules.h):
        return faults  # which are found already
    coefficients = {getattr(friction, name): name for name in law.bounded_by}
    mu = max(coefficients, default=0.0)
    mu_r = getattr(friction, "mu_r", 0.0)
    # Coulomb friction has one contact force only below Painleve's bound.
    balls = problem.balls
    highest = _highest(problem) if isinstance(body, Asymmetric) else math.inf
    bounds = {name: painleve_bound(ball, highest) for name, ball in balls.items()}
    name = min(bounds, key=bounds.__getitem__)
    if mu >= bounds[name]:
        faults.append(
            f"`friction.{coefficients[mu]}` must be less than {bounds[name]:.4f}, but is {mu:g}: "
            f"above it the contact force of this {name} is not unique (Painleve)."
        )
    most = min(most_rolling(ball, mu) for ball in balls.values()) if mu_r else math.inf
    if not faults and mu_r >= most:
        faults.append(
            f"`friction.mu_r` must be less than {most:.3g}, or the contact force is not unique, "
            f"but is {mu_r:g}."
        )
    least = _least_gap(problem.initial, body.R, rules) if rules.stem else -math.inf
    if gap < least - UNDER * R:
        faults.append(
            f"`initial.gap` must be at least {least:.17g}, but is {gap:g}: the stem would be "
            "under the plane."
        )
    return faults


def _highest(problem: Problem) -> float:
    """Return the height to which the energy of the start can raise the centre of mass [m]."""
    q, _ = problem.variables.split(problem.start().astype(float))
    b = problem.internal_body
    height = energy(problem.form.scalars(q, b), b) / (b.m * b.g)
    return float(height) * problem.unit(METRE)


def on_stem(
    initial: PlainData, parameters: Mapping[str, float], rules: ContactLaw | None
) -> PlainData:
    """Return the start with the gap at which the stem touches, where none is given.

    Only where the stem would be under the plane if the sphere touched it.
    """
    if rules is None or not rules.stem or "gap" in initial:
        return initial
    least = _least_gap(initial, parameters["R"], rules)
    return {**initial, "gap": least} if least > 0 else initial


def touches(problem: Problem) -> bool:
    """Return whether a body starts on the plane, on its sphere or its stem: no gap was given.

    A gap that `on_stem` added equals that of `_least_gap` to the bit, which computed it.
    """
    rules = problem.contact
    gap = problem.initial.get("gap")
    if rules is None or gap is None:
        return rules is not None
    return rules.stem and gap > 0 and gap == _least_gap(problem.initial, problem.body().R, rules)


def _least_gap(initial: PlainData, R: float, rules: ContactLaw) -> float:
    """Return the gap of the sphere where the stem touches [m]; it may be negative."""
    return rules.r - R - rules.h * math.cos(float(initial.get("theta", 0.0)))
