"""Impacts, which are integrated as motions.

The common state of a ball that strikes the plane goes into `ImpactMotions.struck`; out comes an
`Impact`, its impulses and works. In an impact the slip may turn, stop and reverse while the normal
impulse grows, so its end has no formula. It is the solution of an equation whose clock is the
normal velocity, and whose events are the end of slip and of compression (`impact_motion`). The
compiled loop integrates this motion like that of any phase: in the precision of the run, with
derivatives, and within the programs of jumps.

Symbols
    b         the body, a `Touch` or `Asymmetric`; but in `_followed` the parameters, a `Blow`
    q         the motion, a `Motion`: slip, normal velocity v_n, impulses and works
    region    the stage of an impact: a region of the law, "" without regions, or "rest"
    e_n       coefficient of restitution; v, omega: velocity of the contact, angular velocity
"""

import math
import threading
from collections.abc import Callable
from functools import lru_cache, partial
from itertools import repeat
from typing import Any, NamedTuple

import numpy as np

from ..mechanics.contact import impact_motion as motion
from ..mechanics.contact.body import Moving, Touch, alone, velocities
from ..mechanics.contact.frame import Asymmetric, Frame
from ..mechanics.contact.impact_motion import CLOCK_RATE
from ..mechanics.contact.response import work_of
from ..mechanics.lines import unit_of
from ..mechanics.operand import Vector, dot, leaves, log, refill, sqrt, times
from ..problem import PRECISIONS, ROUNDING
from .driver import Driver
from .expressions import Formulas
from .status import Status
from .taylor import compiled_when
from .wide import WideDriver


MOST_STEPS = 200_000
"""Steps of an impact, at most: some seconds."""

UNSOLVED = "friction jams the contact within an impact, or is not finite: it has no solution"
STIFF = "friction within an impact is too stiff to be followed"
ENDLESS = "the impact of a disc did not end: a disc that hardly turns takes too many steps"
ENDED = Status.ENDED.code
NON_FINITE = Status.NON_FINITE.code
STALLED = Status.STALLED.code


STOPS = {name: math.log(1e-3 * rounding) for name, rounding in ROUNDING.items()}
"""Logarithm of the slip at which a contact stops, by precision: a thousandth of rounding."""

LONGEST, REST_SPAN, SHORTEST = 64.0, 0.25, 2.0**-40
"""Lengths on the clock of an impact: the longest piece; the first one at rest; and the shortest one
in which a contact at rest gives way.
"""


@lru_cache(maxsize=64)
def formulas_of_impact(friction: Any, name: str, lies: Any, pattern: Any) -> Formulas:
    """Return the equations and events of one stage of an impact under a friction law.

    `name` is its region. `pattern` is a record like the body, a `Touch` or `Asymmetric`, and `lies`
    one like its axis or frame, a `Vector` or `Frame`; the numbers in them do not matter.
    `ImpactMotions` makes both. Cached, as compiled integrators are cached by the result.
    """
    stage = motion.stages(friction)[name]
    vector = Vector(1.0, 1.0, 1.0)
    # by; goal, speed, ratio, stops; u; L; touch: the leaves must be those of the Blow of `struck`
    template = motion.Blow(vector, *(1.0,) * 4, lies, vector, pattern)

    def functions(q: Any, carried: Any, b: Any) -> list:
        """Return the event functions of the stage; q is a `Motion`, b a `Blow`."""
        return [event.formula(q, b) for event in stage.events]

    return Formulas(stage.form, stage.events, functions, partial(refill, template))


class Impact(NamedTuple):
    """The impulses and works of an impact of a ball. `ImpactMotions.struck` makes it."""

    p: Vector  # impulses of force and torque, (3,) each
    twist: Vector
    mode: str  # "slip": it never stopped; "stick" or "reverse": what followed the stop
    work_n: Any  # of the normal impulse [J]
    gained: Any  # energy that the body gains [J]
    compression: Any  # work of the normal impulse until v_n = 0 [J]

    @property
    def makes_energy(self) -> Any:
        """Return whether the impact adds more energy than rounding does.

        Only restitution = newton can do so, and such an impact is not physical.
        """
        return self.gained > 1e-12 * abs(self.compression)


class ImpactMotions:
    """Integrate the impacts of a run under its friction law.

    `HybridDriver` makes it, jumps call `struck`.

    Parameters
    ----------
    law
        The friction law, as the type of its record.
    restitution
        One of `contact.restitution.RESTITUTIONS`.
    precision
        "double", "longdouble" or "quad".
    stop
        Set it to give up while a motion is being compiled.
    body
        A body of the run; by default a ball.
    """

    def __init__(
        self,
        law: Any,
        restitution: str,
        precision: str = "double",
        stop: threading.Event | None = None,
        body: Any = None,
    ):
        """Prepare the stages of an impact; each is compiled when it is first needed.

        `pattern` are the last two arguments of `formulas_of_impact`, lies and pattern; the order of
        `stages` numbers the loops of `JumpPrograms`.
        """
        self.law = law
        self.restitution = restitution
        self.precision = precision
        self.stop = stop
        self.stages = motion.stages(law)
        lies: Any = Frame if isinstance(body, Asymmetric) else Vector
        if lies is Vector:
            # not the body itself: R and c of an outline are (), those of the ball that `struck`
            # passes are numbers, and the leaves must be those of its `Blow`
            body = Touch(*(1.0,) * 6, law._make(law._fields))
        self.pattern = lies(*(1.0,) * len(lies._fields)), refill(alone(body), repeat(1.0))
        self.drivers: dict[str, Driver] = {}

    def driver(self, region: str) -> Driver:
        """Return the driver of the motion in a region of slip, compiled when it is first needed.

        Its start, parameters and end are dummies: `piece` sets them, and programs of jumps do so in
        its loop.
        """
        if region not in self.drivers:
            formulas = formulas_of_impact(self.law, region, *self.pattern)
            # the key of `code_for`, with the rounding unit as tolerance, for one run without
            # orientation
            code = compiled_when((formulas, self.precision, 0.0, 1, False), self.stop)
            start = np.zeros(len(formulas.form.units), PRECISIONS[self.precision])
            pars = [1.0] * len(code.integrator.pars)
            functions = np.ones(len(formulas.events))
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
        """Integrate one stage until its clock reaches `end` or an event happens; `struck` calls it.

        Programs of jumps and derivatives replace this method by one with the same arguments, and
        `follow_motion` in loop.c reads and writes the same numbers in this order: a change of one
        is a change of both.

        Parameters
        ----------
        region
            The stage.
        end, most
            The last time on its clock, and the most steps.
        signs, zeros
            Of the event functions: their signs at the start, and minus the multiplicity of a root
            there, 0 without one.
        state, pars
            The motion, padded to the width of the driver, and the numbers of a `Blow`.

        Returns
        -------
        list
            The code of the status, the steps made, the number of the event or -1, then the state.
        """
        driver = self.driver(region)
        known = driver.functions
        none = driver.number(0)
        known["sign"], known["on_zero"] = signs, zeros
        driver.set_parameters(driver.workspace, pars)
        driver.clear_counts()
        driver.set_state(state, (none, none))
        driver.set_end(end)
        driver.clear_findings()
        steps = driver.make_steps(int(most))
        code = driver.status[0]
        event = int(driver.log.rows["event"][driver.logged[0] - 1]) if code == ENDED else -1
        return [code, steps, event, *driver.reached()[1].tolist()]

    def struck(self, x: Moving, b: Touch, e_n: Any, piece: Callable | None = None) -> Impact:
        """Return the impact of a ball whose lowest point moves down: the `struck` of a `World`.

        `piece` replaces the method of this name, to record or differentiate the impact: numbers may
        then be those of a program or dual, whose comparisons are recorded. The stage, its mode and
        the steps that are left are attributes, so one thread makes one impact at a time.

        Raises
        ------
        ArithmeticError
            If friction jams the contact, or is too stiff.
        """
        self.follow = piece or self.piece
        self.left = MOST_STEPS
        self.mode = "slip"
        b = alone(b)  # which stays within an impact
        (v, omega), none = velocities(x, b), 0 * x.height
        # of the edge of a disc, in place of the normal velocity
        slip = v._replace(z=b.friction.patch * omega.z if self.law.regions else none)
        speed = unit_of(*v, slip.z)
        unit = unit_of(v.z)
        stops = STOPS[self.precision]
        slip = times(1 / speed, slip)
        grown = none
        if motion.can_rest(self.law):
            w = sqrt(dot(slip, slip)) + math.exp(stops - 1)  # of no slip, log(w) is below `stops`
            slip = times(1 / w, slip)
            grown = log(w)
        # compression ends where v_n = 0, whatever law ends restitution
        blow = motion.Blow(motion.ENDS["newton"], 0.0, speed, unit / speed, stops, x.u, x.L, b)
        q = motion.Motion(*slip, grown, v.z / unit, *(none,) * 7)  # no impulses and no work yet
        self.region = motion.region_at(q, blow)
        q = pressed = self._followed(q, blow)
        if e_n > 0:
            by = motion.ENDS[self.restitution]
            # v_n and work_n begin at 0 again, p_n continues: so its goal is that of both parts
            goals = Vector(-e_n * v.z / unit, -(e_n**2) * q.work_n, (1 + e_n) * q.p_n)
            restored = blow._replace(by=by, goal=dot(by, goals))
            q = self._followed(q._replace(v_n=none, work_n=none), restored)
            q = q._replace(work_n=q.work_n + pressed.work_n)
        p = times(unit, Vector(q.p_x, q.p_y, q.p_n))
        twist = times(unit, Vector(q.t_x, q.t_y, q.t_n))
        works = unit**2 * q.work_n, work_of(x, p, twist, b), unit**2 * pressed.work_n
        return Impact(p, twist, self.mode, *works)

    def _followed(self, q: Any, b: Any) -> Any:
        """Return the motion at the end of compression or restitution, through all stages.

        `b` is a Blow, whose goal ends it by the event "reached"; q is a Motion. `struck` sets
        `region`, `left` and `mode`, which the stages change. Raises ArithmeticError, by which the
        run ends as stalled.
        """
        span = REST_SPAN
        # under a law that cannot hold the contact at rest `grown` is 0, above `stops`
        passed = "" if q.grown > b.stops else "stops"
        while self.left > 0:
            if passed == "stops":
                q = q._replace(**dict.fromkeys(("v_x", "v_y", "turn", "grown"), 0 * q.v_n))
                self.region = motion.REST
                self.mode = "stick"
                passed = ""
            if self.region not in self.stages:  # the slip is not finite
                raise ArithmeticError(UNSOLVED)
            stage = self.stages[self.region]
            rests = self.region == motion.REST
            acts = stage.acts(q, b)
            if rests and not motion.holding_margin(acts, b) > 0:
                q = motion.slide(q, acts, b)
                span = REST_SPAN
                self.region = motion.region_at(q, b)
                self.mode = "reverse" if self.law.set_valued else "slip"
                continue
            if not 0 < motion.responses(b, acts)[0].z < np.inf:
                raise ArithmeticError(UNSOLVED)
            # as `PhaseSolver.begins` sets those of exits: the stage begins on the zero just passed
            signs = tuple(-event.direction for event in stage.events)
            zeros = tuple(-float(event.name == passed) for event in stage.events)
            pad = self.driver(self.region).width - len(q)
            state = (*q, *(0.0,) * pad)
            pars = tuple(leaves(b))
            end = CLOCK_RATE * (span if rests else LONGEST)
            given = end, self.left, signs, zeros, state, pars
            status, steps, k, *after = self.follow(self.region, *given)
            after = motion.Motion._make(after[: len(q)])
            self.left -= steps + 1  # so stages without a step come to an end, too
            # the contact gives way within the piece, which is made again, half as long
            if rests and span > SHORTEST and motion.holding_margin(stage.acts(after, b), b) < 0:
                span /= 2
                continue
            q = after
            passed = ""
            if status == ENDED:
                passed = next(event.name for e, event in enumerate(stage.events) if e == k)
                if passed == "reached":
                    return q
                if passed in stage.follows:
                    way = stage.follows[passed]
                    self.region = way.follows
                    passed = way.back
            elif status == NON_FINITE:
                raise ArithmeticError(UNSOLVED)
            elif status == STALLED:
                break
        raise ArithmeticError(ENDLESS if self.law.regions else STIFF)
