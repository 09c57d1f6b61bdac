"""Impacts of a run, as motions: executed like any other, in the precision of the run, and compiled
once for a law.
"""

import math
import threading
from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ..mechanics.contact import impact_motion as motion
from ..mechanics.contact.body import Moving, Touch, velocities
from ..mechanics.contact.impact_motion import CLOCK_RATE
from ..mechanics.contact.response import margin, work_of
from ..mechanics.friction import PARTS, has_parts
from ..mechanics.lines import unit_of
from ..mechanics.operand import Vector, dot, leaves, log, refill, sqrt, times
from ..problem import PRECISIONS, ROUNDING, Problem
from .driver import NO_ROWS, Driver
from .expressions import Formulas
from .status import Status
from .taylor import compiled_when
from .wide import WideDriver


MOST_STEPS = 200_000
"""Of an impact: some seconds."""

UNSOLVED = "friction jams the contact within an impact, or is not finite: it has no solution"
STIFF = "friction within an impact is too stiff to be followed"
ENDED, NON_FINITE, STALLED = Status.ENDED.code, Status.NON_FINITE.code, Status.STALLED.code


LONGEST, REST_SPAN, SHORTEST = 64.0, 0.25, 2.0**-40
"""Of the clock of an impact: a piece of it; one at rest; and one in which a contact at rest gives
way.
"""


@lru_cache(maxsize=64)
def formulas_of_impact(friction: Any, name: str, has_torques: bool) -> Formulas:
    """Return the formulas of a stage, with the type of the record of a friction law; torques of its
    parts are left out unless it has some.
    """
    stage = motion.stages(friction)[name]
    touch = Touch(*(1.0,) * 6, friction._make(friction._fields))
    axis = Vector(1.0, 1.0, 1.0)
    template = motion.Blow(axis, *(1.0,) * 4, axis, axis, touch)
    none = {} if has_torques else {name: 0.0 for name in PARTS if name in friction._fields}

    def functions(q: Any, carried: Any, b: Any) -> list:
        return [event.formula(q, b) for event in stage.events]

    def body(values: Iterator) -> Any:
        b = refill(template, values)
        return b._replace(touch=b.touch._replace(friction=b.touch.friction._replace(**none)))

    return Formulas(stage.form, stage.events, functions, body)


def kind_of(problem: Problem, friction: Any) -> tuple[Any, bool, str, str]:
    """Return the kind of the impacts of a run, with the record of its law: the first arguments of
    `ImpactMotions`.
    """
    contact: Any = problem.contact
    return type(friction), has_parts(friction), contact.restitution, problem.precision


class Impact(NamedTuple):
    """An impact of a ball."""

    p: Vector  # impulses of force and torque, (3,) each
    twist: Vector
    mode: str  # "slip": it never stopped; "stick" or "reverse": what followed the stop
    work_n: Any  # of the normal impulse [J]
    gained: Any  # energy that the body gains [J]
    compression: Any  # work of the normal impulse until v_n = 0 [J]

    @property
    def makes_energy(self) -> Any:
        """Return whether it adds more than rounding does; only restitution = newton can, and that
        is no model of an impact.
        """
        return self.gained > 1e-12 * abs(self.compression)


class ImpactMotions:
    """Impacts that are followed as motions.

    Parameters
    ----------
    law
        The type of its record.
    has_torques
        Whether the law has rolling resistance or a drilling torque, besides the torque of a disc.
    restitution
        One of `contact.restitution.RESTITUTIONS`.
    precision
        Of the numbers: "double", "longdouble" or "quad".
    stop
        Set it to give up while a motion is being compiled.
    """

    def __init__(
        self,
        law: Any,
        has_torques: bool,
        restitution: str,
        precision: str = "double",
        stop: threading.Event | None = None,
    ):
        self.law, self.has_torques, self.restitution = law, has_torques, restitution
        self.precision, self.stop, self.stages = precision, stop, motion.stages(law)
        self.drivers: dict[str, Driver] = {}

    def driver(self, region: str) -> Driver:
        """Return the executor of the motion in a region, compiled when it is first needed."""
        if region not in self.drivers:
            formulas = formulas_of_impact(self.law, region, self.has_torques)
            code = compiled_when((formulas, self.precision, 0.0, 0, False), self.stop)
            start = np.zeros(len(formulas.form.units), PRECISIONS[self.precision])
            pars, functions = [1.0] * len(code.integrator.pars), np.ones(len(formulas.events))
            kind = Driver if self.precision == "double" else WideDriver
            self.drivers[region] = kind(code, code.rows, pars, start, functions, 0.0)
        return self.drivers[region]

    def piece(
        self,
        region: str,
        end: Any,
        most: int,
        signs: tuple,
        zeros: tuple,
        state: tuple,
        pars: tuple,
    ) -> list:
        """Follow a motion until its clock reaches `end` or an event happens.

        Return the code of its status, the number of steps and of the event, -1 without one, and the
        state.
        """
        driver = self.driver(region)
        known, none = driver.tallies.functions, driver.number(0)
        known["sign"][:, 0], known["on_zero"][:, 0] = signs, zeros
        driver.take(driver.place, pars)
        driver.begin()
        driver.put(state, (none, none))
        driver.end_at(end)
        driver.forget()
        steps, code = driver.make(NO_ROWS, int(most)), driver.status[0]
        event = int(driver.log.rows["event"][driver.logged[0] - 1]) if code == ENDED else -1
        return [code, steps, event, *driver.reached()[1].tolist()]

    def struck(self, x: Moving, b: Touch, e_n: Any, piece: Callable | None = None) -> Impact:
        """Return the impact of a ball whose lowest point moves down.

        `piece` follows motions as the method does.

        Raises
        ------
        ArithmeticError
            If friction jams the contact, or is too stiff.
        """
        self.follow = piece or self.piece
        (v, omega), law, none = velocities(x, b), self.law, 0 * x.height
        slip = v._replace(z=b.friction.patch * omega.z if law.regions else none)
        speed, unit, grown = none + unit_of(*v, slip.z), none + unit_of(v.z), none
        slip, self.mode = times(1 / speed, slip), "slip"
        stops = none + math.log(motion.STOPS_AT * ROUNDING[self.precision])
        if motion.can_rest(law):
            w, self.begins = sqrt(dot(slip, slip)), stops + 1
            slip, grown = times(1 / w, slip) if w > 0 else slip, log(w) if w > 0 else stops
            if self.has_torques:
                begins = motion.DISC_BEGINS_AT if law.regions else motion.BEGINS_AT
                self.begins = log(begins / speed)
        ends = Vector(none, none, none)
        self.b = motion.Blow(ends, none, speed, unit / speed, stops, x.u, x.L, b)
        q = motion.Motion(*slip, grown, v.z / unit, *(none,) * 7)
        self.region, self.left = motion.region_at(q, self.b), MOST_STEPS
        q = pressed = self._followed(q, ends._replace(x=none + 1), none)
        if e_n > 0:
            by, goal = {
                "newton": (ends._replace(x=none + 1), -e_n * v.z / unit),
                "energetic": (ends._replace(y=none + 1), -(e_n**2) * q.work_n),
                "poisson": (ends._replace(z=none + 1), (1 + e_n) * q.p_n),
            }[self.restitution]
            q = self._followed(q._replace(v_n=none, work_n=none), by, goal)
            q = q._replace(work_n=q.work_n + pressed.work_n)
        p, twist = Vector(q.p_x, q.p_y, q.p_n), Vector(q.t_x, q.t_y, q.t_n)
        p, twist = times(unit, p), times(unit, twist)
        works = unit**2 * q.work_n, work_of(x, p, twist, b), unit**2 * pressed.work_n
        return Impact(p, twist, self.mode, *works)

    def _followed(self, q: Any, by: Vector, goal: Any) -> Any:
        """Return the motion from q on where by.(v_n, work_n, p_n) = goal."""
        b = self.b._replace(by=by, goal=goal)
        passed, span = "", REST_SPAN
        if self.mode == "slip" and motion.can_rest(self.law) and not q.grown > b.stops:
            passed = "stops"
        while self.left > 0:
            if passed == "stops":
                q, self.region, self.mode, passed = motion.rested(q), motion.REST, "stick", ""
            stage, rests = self.stages[self.region], self.region == motion.REST
            acts = stage.acts(q, b)
            if rests and not has_left(acts, b) > 0:
                q, span = motion.slide(q, acts, self.begins, b), REST_SPAN
                self.region = motion.region_at(q, b)
                self.mode = "reverse" if self.law.set_valued else "slip"
                continue
            if not 0 < motion.responses(b, acts)[0].z < np.inf:
                raise ArithmeticError(UNSOLVED)
            signs = tuple(-event.direction for event in stage.events)
            zeros = tuple(-float(event.name == passed) for event in stage.events)
            pad = self.driver(self.region).width - len(q)
            state, pars = (*q, *(0.0,) * pad), tuple(leaves(b))
            end = CLOCK_RATE * (span if rests else LONGEST)
            given = end, self.left, signs, zeros, state, pars
            status, steps, k, *after = self.follow(self.region, *given)
            after = motion.Motion._make(after[: len(q)])
            self.left -= steps + 1
            if rests and span > SHORTEST and has_left(stage.acts(after, b), b) < 0:
                span /= 2
                continue
            q, passed = after, ""
            if status == ENDED:
                passed = next(event.name for e, event in enumerate(stage.events) if e == k)
                if passed == "reached":
                    return q
                if passed in stage.follows:
                    way = stage.follows[passed]
                    self.region, passed = way.follows, way.back
            elif status == NON_FINITE:
                raise ArithmeticError(UNSOLVED)
            elif status == STALLED:
                break
        raise ArithmeticError(STIFF)


def has_left(acts: Any, b: Any) -> Any:
    """Return by how much friction can hold the contact at rest; negative where it cannot."""
    return margin(acts.force, acts.torque.z, b.touch.friction)
