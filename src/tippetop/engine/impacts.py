"""Impacts of a run, as motions: executed like any other, in the precision of the run, and compiled
once for a law.
"""

import threading
from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ..mechanics.contact import impact_motion as motion
from ..mechanics.contact.body import Moving, Touch, velocities
from ..mechanics.contact.impact_motion import CLOCK_RATE
from ..mechanics.friction import PARTS, has_parts
from ..mechanics.lines import unit_of
from ..mechanics.operand import Vector, leaves, refill, times
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
ENDLESS = "the impact of a disc did not end: a disc that hardly turns takes too many steps"
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
    template = motion.Blow(*(1.0,) * 8, axis, axis, touch)
    none = {} if has_torques else {name: 0.0 for name in PARTS if name in friction._fields}

    def functions(q: Any, carried: Any, b: Any) -> list:
        by = stage.acts(q, b)
        return [event.formula(q, by, b) for event in stage.events]

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
    work_t: Any  # of friction and torques [J]
    compression: Any  # work of the normal impulse until v_n = 0 [J]

    @property
    def gained(self) -> Any:
        """Return the energy that the body gains [J]."""
        return self.work_n + self.work_t

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
        (v, omega), law = velocities(x, b), self.law
        none, turn = 0 * v.z, 0 * v.z
        if law.regions:
            turn = b.friction.patch * omega.z
        speed, unit = none + unit_of(*v, turn), none + unit_of(v.z)
        slip = v.x / speed, v.y / speed, turn / speed
        rests_at = motion.STOPS_AT if law.set_valued else motion.RESTS_AT
        rest = rests_at * ROUNDING[self.precision] * (abs(v.z) / speed + sum(map(abs, slip)))
        begins = 2 * rest
        if self.has_torques:
            begins = max(
                begins, (motion.DISC_BEGINS_AT if law.regions else motion.BEGINS_AT) / speed
            )
        units = speed, unit / speed
        self.b = motion.Blow(none + 1, none, none, none, *units, rest, begins, x.u, x.L, b)
        q = motion.Motion(*slip, v.z / unit, *(none,) * 8)
        self.mode, self.region, self.left = "slip", motion.region_at(law, q, self.b), MOST_STEPS
        q = pressed = self._followed(q)._replace(v_n=none)
        if e_n > 0:
            q = self._restored(q, e_n, v.z / unit)
        p, twist = Vector(q.p_x, q.p_y, q.p_n), Vector(q.t_x, q.t_y, q.t_n)
        works = unit**2 * q.work_n, unit * speed * q.work_t, unit**2 * pressed.work_n
        return Impact(times(unit, p), times(unit, twist), self.mode, *works)

    def _restored(self, q: Any, e_n: Any, v_n: Any) -> Any:
        """Return the motion at the end of restitution, from the end of compression."""
        field, end, goal = {
            "newton": ("v_n", -e_n * v_n, -e_n * v_n),
            "energetic": ("work_n", (1 - e_n**2) * q.work_n, 0 * v_n),
            "poisson": ("p_n", (1 + e_n) * q.p_n, (1 + e_n) * q.p_n),
        }[self.restitution]
        if field == "work_n":  # it rises to zero: so a small one keeps its digits
            q = q._replace(work_n=e_n**2 * q.work_n)
        self.b = self.b._replace(**{"by_v_n": 0 * v_n, f"by_{field}": 0 * v_n + 1, "goal": goal})
        return self._followed(q)._replace(**{field: end})

    def _followed(self, q: Any) -> Any:
        """Return the motion at the end of its stage."""
        law, b, passed, span = self.law, self.b, "", REST_SPAN
        can_rest, rest = motion.can_rest(law, b), self.stages[motion.REST]
        while self.left > 0:
            stops = passed == "stops" or sum(motion.speeds(q)) <= b.rest**2
            if can_rest and self.region != motion.REST and stops:
                q, passed, span = motion.stopped(law, q, b), "", REST_SPAN
                self.region, self.mode = motion.REST, "stick"
            rests = self.region == motion.REST
            if rests and not motion.left(law, by := rest.acts(q, b), b) > 0:
                q, rests = motion.slide(law, q, by, b), False
                self.region = motion.region_at(law, q, b)
                self.mode = "reverse" if law.set_valued else "slip"
            stage, driver = self.stages[self.region], self.driver(self.region)
            by = stage.acts(q, b)
            if not 0 < motion.gains(by, b).z < np.inf:
                raise ArithmeticError(UNSOLVED)
            grows = motion.SLOWEST in stage.events and (
                passed == "slowest" or motion.growth(q, by, b) >= 0
            )
            signs = tuple(
                event.direction if grows and event is motion.SLOWEST else -event.direction
                for event in stage.events
            )
            zeros = tuple(-float(event.name == passed) for event in stage.events)
            end, pad = CLOCK_RATE * (span if rests else LONGEST), driver.width - len(q)
            begins = motion.directed(q) if stage.is_directed else q
            state, pars = (*begins, *(0.0,) * pad), tuple(leaves(b))
            status, steps, k, *after = self.follow(
                self.region, end, self.left, signs, zeros, state, pars
            )
            after = motion.Motion._make(after[: len(q)])
            after = motion.undirected(after) if stage.is_directed else after
            passed = ""
            self.left -= steps + 1
            gives_way = rests and motion.left(law, rest.acts(after, b), b) < 0
            if gives_way and span > SHORTEST:
                span /= 2
                continue
            if status == ENDED:
                passed = next(event.name for e, event in enumerate(stage.events) if e == k)
                if passed == "reached":
                    return after
                if passed in stage.follows:
                    way = stage.follows[passed]
                    self.region, passed = way.follows, way.back
            elif status == NON_FINITE:
                raise ArithmeticError(UNSOLVED)
            elif status == STALLED and not (  # or comes to rest by ever shorter steps
                can_rest and 0 < sum(motion.speeds(after)) < sum(motion.speeds(q)) / 4
            ):
                break
            q = after
        raise ArithmeticError(ENDLESS if law.regions else STIFF)
