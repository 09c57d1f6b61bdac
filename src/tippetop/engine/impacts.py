"""Impacts of a run: under a law that is smooth in the sliding velocity as motions, others in closed form and by series.

A motion is executed like any other, in the precision of the run, and compiled once for a law.
"""

import threading
from collections.abc import Iterator
from functools import lru_cache
from typing import Any

import numpy as np

from ..mechanics.contact import loaded_impact as loaded
from ..mechanics.contact.body import Touch, angular_velocity
from ..mechanics.contact.impact import Struck, after_impact, arrival
from ..mechanics.contact.impact_motion import (
    CLOCK_RATE,
    RESTORED,
    RESTS_AT,
    Blow,
    Motion,
    Sliding,
    held,
    sliding,
    speeds,
    unit_of,
)
from ..mechanics.contact.response import Mobility, Spin, spin_mobility
from ..mechanics.contact.state import Moving
from ..mechanics.contact.struck import Impact, struck
from ..mechanics.disc_friction import Region
from ..mechanics.friction import Frictionless, has_parts
from ..mechanics.operand import Vector, leaves, refill
from ..problem import PRECISIONS, Problem
from .driver import RUNNING, Driver
from .expressions import Formulas
from .status import Status
from .tallies import ON_ZERO, SIGN
from .taylor import compiled_when
from .wide import WideDriver


MOST_STEPS = 200_000
"""Of an impact: some seconds."""

UNSOLVED = "friction jams the contact within an impact, or is not finite: it has no solution"
STIFF = "friction within an impact is too stiff to be followed"
ENDLESS = "the impact of a patch did not end: one that hardly turns takes too many steps"
ROUNDING = {"double": 2.0**-52, "longdouble": 2.0**-63, "quad": 2.0**-112}


LONGEST, LOADED_SPAN, SHORTEST = 64.0, 0.25, 2.0**-40
"""Of the clock of an impact under a law with torques: a piece of it; one at rest; and one in which a contact at rest
gives way."""


class NoRows:
    """Asks for no rows."""

    steps = False

    def wanted(self) -> np.ndarray:
        """Return no times."""
        return np.zeros(0)

    def take(self, times: np.ndarray, states: np.ndarray) -> None:
        """Take nothing."""


NO_ROWS = NoRows()


@lru_cache(maxsize=64)
def formulas_of_impact(friction: Any, region: Region | None, restitution: str) -> Formulas:
    """Return the formulas of a motion, with the type of the record of a friction law."""
    slides = sliding(region, restitution)
    template = Blow(*(1.0,) * 10, friction._make(friction._fields))

    def functions(q: Any, carried: Any, b: Any) -> list:
        push = slides.push(q, b)
        return [event.formula(q, push, b) for event in slides.events]

    def body(values: Iterator) -> Any:
        return refill(template, values)

    return Formulas(slides.form, slides.events, functions, body)


@lru_cache(maxsize=64)
def loaded_formulas(stage: loaded.Stage, friction: Any) -> Formulas:
    """Return the formulas of an impact under a law with torques, with the type of the record of the law."""
    touch = Touch(*(1.0,) * 6, friction._make(friction._fields))
    template = loaded.Blow(Vector(1.0, 1.0, 1.0), touch, *(1.0,) * 5)

    def functions(q: Any, carried: Any, b: Any) -> list:
        by = stage.acts(q, b)
        return [event.formula(q, by, b) for event in stage.events]

    def body(values: Iterator) -> Any:
        return refill(template, values)

    return Formulas(stage.form, stage.events, functions, body)


def driver_of(formulas: Formulas, precision: str, stop: threading.Event | None) -> Driver:
    """Return what executes a motion."""
    wide, number = precision != "double", PRECISIONS[precision]
    code = compiled_when((formulas, precision, 0.0, 0, wide, False), stop)
    start, functions = np.zeros(len(formulas.form.units), number), np.ones(len(formulas.events))
    pars = [number(1)] * len(code.integrator.pars)
    return (WideDriver if wide else Driver)(code, code.rows, pars, start, functions, 0.0)


def piece_of(driver: Driver, q: Any, signs: list, zeros: list, end: Any, most: int) -> Any:
    """Return the steps of a motion from q on, until its clock reaches `end` or an event happens."""
    known, none = driver.tallies.functions, driver.number(0)
    known[SIGN, :, 0], known[ON_ZERO, :, 0] = signs, zeros
    driver.status[0], driver.upto[0], driver.tiny[0], driver.steps[0] = RUNNING, 1.0, 0, 0
    driver.put([*q, *[none] * (driver.width - len(q))], (none, none))
    driver.end_at(end)
    return driver.advance(NO_ROWS, most)


class SlidingImpacts:
    """Impacts under a law with a coefficient or with regions.

    Parameters
    ----------
    law
        The law.
    restitution
        As of `contact.struck.struck`.
    precision
        Of the numbers: "double", "longdouble" or "quad".
    stop
        Set it to give up while a motion is being compiled.
    """

    def __init__(self, law: Any, restitution: str, precision: str = "double", stop: threading.Event | None = None):
        self.law, self.restitution, self.precision, self.stop = law, restitution, precision, stop
        self.number: Any = float if precision == "double" else PRECISIONS[precision]  # floats are faster than NumPy's
        self.eps = ROUNDING[precision]
        self.known: dict[str, tuple[Sliding, Driver]] = {}

    def motion(self, name: str) -> tuple[Sliding, Driver]:
        """Return the motion in a region, or with the only name "", and what follows it."""
        if name not in self.known:
            region = self.law.regions.get(name)
            formulas = formulas_of_impact(self.law, region, self.restitution)
            self.known[name] = sliding(region, self.restitution), driver_of(formulas, self.precision, self.stop)
        return self.known[name]

    def struck(
        self, v: tuple, K: Mobility, z: Any, friction: Any, e_n: Any, spin: Spin | None = None, Omega_z: Any = 0
    ) -> Impact:
        """Return the impact of a contact that arrives with v = (v_e, v_2, v_n), v_n < 0.

        Parameters
        ----------
        v
            Velocity of the contact before it.
        K, z
            Mobility; cos(theta).
        friction
            The record of the law.
        e_n
            Coefficient of restitution.
        spin, Omega_z
            Of a contact disc: what a torque about the vertical does, and the vertical angular velocity before.

        Raises
        ------
        ArithmeticError
            If friction jams the contact, or is too stiff.
        """
        number, patch = self.number, getattr(friction, "patch", 1) if spin else 1
        mass, rising = (number(unit_of(value)) for value in (K.zz, v[2]))
        speed = number(unit_of(*v, patch * Omega_z))
        across, about = (spin.across * patch, spin.about * patch**2) if spin else (0, 0)
        moves = (value / mass for value in (*K, across, about))
        slip = v[0] / speed, v[1] / speed, patch * Omega_z / speed
        rest = 0 * rising
        if self.law.regions:
            slides = speeds(Motion(*slip, *(0,) * 7)).v2 ** 0.5
            rest = RESTS_AT * self.eps * (abs(v[2]) / speed + slides + abs(slip[2]))
        self.b = Blow._make((*moves, z, rising / speed, speed, rest, friction))
        none = 0 * rising
        q = Motion(*slip, v[2] / rising, *(none,) * 6)
        self.mode, self.left, self.reach = "", MOST_STEPS, -(2 * e_n * v[2] / rising)
        self.region = self._region(q)
        q = pressed = self._followed(q, none)
        if e_n > 0 and self.restitution == "newton":
            q = self._followed(q._replace(v_n=none), -(e_n * v[2] / rising))
        elif e_n > 0:
            field = RESTORED[self.restitution]
            share = e_n**2 if field == "work_n" else -e_n
            goal = getattr(q, field) * (1 - share)
            q = self._followed(q._replace(v_n=none, **{field: getattr(q, field) - goal}), None)
            q = q._replace(**{field: goal})
        p, slid, work = rising / mass, speed, rising**2 / mass
        return Impact(
            q.p_e * p, q.p_2 * p, q.p_n * p, q.v_e * slid, q.v_2 * slid, q.v_n * rising, q.work_n * work,
            q.work_t * p * slid, pressed.work_n * work, self.mode or "slip", q.twist * p * patch, q.turn * slid / patch,
        )  # fmt: skip

    def _region(self, q: Any) -> str:
        """Return the region of a motion: the first, by rising x, whose end is not reached."""
        s = speeds(q)
        for name, region in self.law.regions.items():
            if all(way.direction < 0 or way.beyond(s, self.b) < 0 for way in region.borders):
                return name
        return ""

    def _followed(self, q: Any, until: Any) -> Any:
        """Return the motion where v_n is `until`, or, where that is None, its restitution ends."""
        b, passed = self.b, ""
        while True:
            if self.mode or passed == "stops" or (self.region and sum(speeds(q)) <= b.rest**2):
                return self._held(q, until)
            slides, driver = self.motion(self.region)
            lift, growth = slides.slope(q, b)
            if not 0 < lift < np.inf:
                raise ArithmeticError(UNSOLVED)
            end = until - q.v_n if until is not None else self.reach
            piece, before = self._piece(slides, driver, q, growth, end, passed), q
            q = Motion(*(piece.last[0].tolist() if self.precision == "double" else piece.last[0]))
            self.left -= piece.steps
            passed = ""
            if piece.status is Status.ENDED:
                passed = slides.events[int(piece.passages.events[-1])].name
                if passed == "restored":
                    return q
                if passed in slides.follows:
                    left, self.region = self.region, slides.follows[passed]
                    back = self.law.regions[self.region].borders
                    passed = next(way.event for way in back if way.follows == left)
            elif piece.status is Status.FINISHED and until is not None:
                return q._replace(v_n=until)
            elif piece.status is Status.FINISHED:
                self.reach = 2 * self.reach
            elif piece.status is Status.NON_FINITE:
                raise ArithmeticError(UNSOLVED)
            elif piece.status is Status.STALLED and self.region and sum(speeds(q)) < sum(speeds(before)) / 4:
                continue  # a disc comes to rest by ever shorter steps
            elif self.left <= 0 or piece.status is Status.STALLED:
                raise ArithmeticError(ENDLESS if self.region else STIFF)

    def _held(self, q: Any, until: Any) -> Any:
        """Return the motion of a disc at rest there."""
        if not self.mode:
            none = 0 * q.v_e
            q = q._replace(v_e=none, v_2=none, turn=none)
        q, self.mode = held(q, self.b, until, self.restitution)
        if not self.mode:
            raise ArithmeticError(UNSOLVED)
        return q

    def _piece(self, slides: Sliding, driver: Driver, q: Any, growth: Any, end: Any, passed: str) -> Any:
        """Return the steps of a motion from q on, until v_n has risen by `end` or an event happens."""
        signs, zeros = list(slides.signs), [-float(event.name == passed) for event in slides.events]
        signs[0] = 1 if passed == "slowest" or growth >= 0 else -1
        if self.restitution in RESTORED:
            value = getattr(q, RESTORED[self.restitution])
            signs[1] = 1 if value > 0 or (value == 0 and self.restitution == "poisson") else -1
            zeros[1] = -float(value == 0)
        driver.take([*self.b[:-1], *self.b.friction][: len(driver.motion.pars)])
        return piece_of(driver, q, signs, zeros, CLOCK_RATE * end, self.left)


class LoadedImpacts:
    """Impacts under a law with torques.

    Parameters
    ----------
    law, restitution, precision, stop
        As of `SlidingImpacts`.
    """

    def __init__(self, law: Any, restitution: str, precision: str = "double", stop: threading.Event | None = None):
        self.law, self.restitution, self.precision, self.stop = law, restitution, precision, stop
        self.number: Any = float if precision == "double" else PRECISIONS[precision]
        self.drivers: dict[str, Driver] = {}

    def struck(self, u: Vector, L: Vector, v: Vector, b: Touch, e_n: Any) -> tuple[Any, Any]:
        """Return the motion at the end of compression and after the impact of a contact that arrives with v."""
        none = 0 * v.z
        q = loaded.Motion(*v, *L, *(none,) * 8)
        self.b = loaded.Blow(u, b, self.number(unit_of(v.z)), none + 1, none, none, none)
        self.mode, self.region, self.left = "slip", loaded.region_at(self.law, q, b=self.b), MOST_STEPS
        q = pressed = self._followed(q)
        if e_n > 0:
            ends = {
                "newton": (1, 0, 0, -e_n * v.z),
                "energetic": (0, 1, 0, (1 - e_n**2) * q.work_n),
                "poisson": (0, 0, 1, (1 + e_n) * q.p_z),
            }
            self.b = self.b._replace(**dict(zip(self.b._fields[3:], ends[self.restitution], strict=True)))
            q = self._followed(q)
        return pressed, q

    def _followed(self, q: Any) -> Any:
        """Return the motion at the end of its stage."""
        law, b, passed, span = self.law, self.b, "", LOADED_SPAN
        motions = loaded.stages(law)
        while self.left > 0:
            rests = self.region == loaded.REST
            if not rests and loaded.is_slow(law, q, b, passed == "stops"):
                q, passed, span = loaded.stopped(law, q, b), "", LOADED_SPAN
                self.region, self.mode, rests = loaded.REST, "stick", True
                by = motions[loaded.REST].acts(q, b)
                if not loaded.left(law, by, b) > 0:
                    q, rests = self._slid(q, by), False
            stage = motions[self.region]
            by = stage.acts(q, b)
            if not 0 < loaded.gains(by, b).z < np.inf:
                raise ArithmeticError(UNSOLVED)
            piece = self._piece(stage, q, by, passed, span if rests else LONGEST)
            after, passed = loaded.Motion(*piece.last[0].tolist()), ""
            self.left -= piece.steps + 1
            if rests and loaded.left(law, stage.acts(after, b), b) < 0:  # it gives way on the way
                span /= 2
                q = q if span > SHORTEST else self._slid(after, stage.acts(after, b))
                continue
            if piece.status is Status.ENDED:
                passed = stage.events[int(piece.passages.events[-1])].name
                if passed == "reached":
                    return after
                if follows := dict(stage.follows).get(passed):
                    before, self.region = self.region, follows
                    passed = next(way.event for way in law.regions[self.region].borders if way.follows == before)
            elif piece.status is Status.NON_FINITE:
                raise ArithmeticError(UNSOLVED)
            elif piece.status is Status.STALLED and not 0 < loaded.speed2(after, b) < loaded.speed2(q, b) / 4:
                break
            q = after
        raise ArithmeticError(ENDLESS if law.regions else STIFF)

    def _slid(self, q: Any, by: Any) -> Any:
        """Return the motion where friction can no longer hold the contact."""
        q = loaded.slide(self.law, loaded.stages(self.law).get(""), q, by, self.b)
        self.region, self.mode = loaded.region_at(self.law, q, self.b), "slip"
        return q

    def _piece(self, stage: Any, q: Any, by: Any, passed: str, end: Any) -> Any:
        """Return the steps of a motion from q on, until the clock has run so far or an event happens."""
        if self.region not in self.drivers:
            formulas = loaded_formulas(stage, self.law)
            self.drivers[self.region] = driver_of(formulas, self.precision, self.stop)
        driver = self.drivers[self.region]
        signs, zeros = [], []
        for event in stage.events:
            beyond = event.name == passed if event.name in ("stops", "slowest") else False
            grows = event.name == "slowest" and event.formula(q, by, self.b) >= 0
            signs.append(event.direction if beyond or grows else -event.direction)
            zeros.append(-float(event.name == passed))
        driver.take(leaves(self.b)[: len(driver.motion.pars)])
        return piece_of(driver, q, signs, zeros, CLOCK_RATE * end, self.left)


class Impacts:
    """What `world` has of impacts.

    Parameters
    ----------
    problem
        The run.
    friction
        The record of the law.
    stop
        Set it to give up while a motion is being compiled.
    """

    def __init__(self, problem: Problem, friction: Any, stop: threading.Event | None = None):
        rules: Any = problem.contact
        law: Any = type(friction)
        self.restitution, self.law = rules.restitution, law
        self.is_dry = law.set_valued or type(friction) is Frictionless
        self.motions = SlidingImpacts(law, rules.restitution, problem.precision, stop)
        self.loaded = LoadedImpacts(law, rules.restitution, problem.precision, stop) if has_parts(friction) else None

    def struck(self, x: Moving, b: Touch, e_n: Any) -> tuple[Vector, Impact, Struck]:
        """Return the velocity of the lowest point of a ball before its impact, the impact, and the body after it."""
        a = arrival(x.u, x.L, x.velocity, b)
        v = a.along, a.sideways, a.v.z
        twist = Vector(*(0 * a.v.z,) * 3)
        if self.loaded:
            b = b._replace(clearance=(), lever=())
            pressed, q = self.loaded.struck(x.u, x.L, a.v, b, e_n)
            p, after = (
                (a.e.x * x + a.e.y * y, a.e.x * y - a.e.y * x, z)
                for x, y, z in ((q.px, q.py, q.p_z), (q.vx, q.vy, q.v_n))
            )
            works = q.work_n, q.work_t, pressed.work_n
            impact, twist = Impact._make((*p, *after, *works, self.loaded.mode, 0, 0)), Vector(q.tx, q.ty, q.tz)
        elif self.is_dry:
            impact = struck(*v, a.K, getattr(b.friction, "mu", 0 * b.m), e_n, self.restitution)
        elif self.law.regions:
            spin, Omega_z = spin_mobility(a.s, x.u.z, b), angular_velocity(x.u, x.L, b).z
            impact = self.motions.struck(v, a.K, x.u.z, b.friction, e_n, spin, Omega_z)
            twist = twist._replace(z=impact.twist)
        else:
            impact = self.motions.struck(v, a.K, x.u.z, b.friction, e_n)
        return a.v, impact, after_impact(x.u, x.L, x.velocity, a, *impact[:3], twist, b)
