"""A phase of a run as a problem of its own, which an ordinary driver integrates; and its states as rows."""

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

from ...mechanics.contact.ball import Ball, jellett
from ...mechanics.contact.phases.legs import Body, Kind, Reached
from ...mechanics.contact.phases.row import PHASES, Row
from ...mechanics.contact.phases.rules import stem_height
from ...mechanics.friction import Contensou, Frictionless, SetValued, is_frictionless
from ...mechanics.operand import leaves
from ...mechanics.systems.with_contact import leg
from ...mechanics.units import METRE, Scales
from ...problem import Problem


class Balls:
    """The balls of a body that can touch the plane, in internal units and the working precision.

    Parameters
    ----------
    problem
        A run whose contact changes its phase.
    """

    def __init__(self, problem: Problem):
        body, number = problem.internal_body, problem.number
        rules = problem.contact
        assert rules is not None
        friction = body.friction
        self.dry = isinstance(friction, SetValued) and not is_frictionless(friction)
        self.drills = isinstance(friction, Contensou) and not is_frictionless(friction)
        friction = (
            friction if self.dry or self.drills or not isinstance(friction, SetValued | Contensou) else Frictionless()
        )
        one = number(1)
        self.stem = rules.stem
        self.bodies = [Body(body.m, one * body.R, body.c, body.I1, body.I3, body.g, friction, one, 0 * one)]
        if rules.stem:
            metre = problem.exact(1) / problem.exact(problem.scales.of(METRE))
            r, h = (number(problem.exact(x) * metre) for x in (rules.r, rules.h))
            clear = body.R - r
            self.bodies = [self.bodies[0]._replace(clearance=clear, lever=h)]
            self.bodies.append(self.bodies[0]._replace(R=r, c=body.c + h, clearance=-clear, lever=-h))

    def __len__(self) -> int:
        return len(self.bodies)

    def __getitem__(self, ball: int) -> Body:
        return self.bodies[ball]


@dataclass(frozen=True, repr=False)
class Leg(Problem):
    """A phase of a run: what an ordinary driver integrates, in the units of the whole run."""

    whole: Any = None  # the run
    internal: Any = None  # the body of the ball in contact, internal units
    first: Any = None  # a state in which it may begin, (variables,)

    @property
    def scales(self) -> Scales:
        """Those of the whole run."""
        return self.whole.scales

    @property
    def internal_body(self) -> Any:
        """The ball in contact."""
        return self.internal

    def start(self) -> np.ndarray:
        """A state in which it may begin."""
        return self.first

    @property
    def alone(self) -> Any:
        """What event functions at the start are computed of."""
        start = np.array(self.first[:, None])
        return SimpleNamespace(
            n=1,
            start=start,
            pars=np.array([float(leaf) for leaf in leaves(self.internal)])[:, None],
            base=self,
            body_of_pars=lambda pars: self.internal,
            record=lambda states: self.variables.split(states)[0],
        )


def new_leg(whole: Problem, kind: str, internal: Body, first: np.ndarray) -> Leg:
    """The phase of a run, of the kind `legs.KINDS`, with this ball in contact."""
    system = leg(whole.system.name, kind)
    return Leg(
        system=system,
        form=next(iter(system.forms.values())),
        parameters={},
        friction=internal.friction,
        initial={},
        until=whole.until,
        times=whole.times,
        events=whole.events,
        precision=whole.precision,
        tolerance=whole.tolerance,
        orientation=whole.orientation,
        whole=whole,
        internal=internal,
        first=first,
    )


class Carried:
    """Which integrals a leg moves, and where they stand among the variables of a row."""

    def __init__(self, whole: Problem, part: Leg):
        mine, theirs = part.variables, whole.variables
        self.moving, self.of_row = mine.moving, theirs.moving
        names = theirs.names[theirs.moving :]
        self.pairs = [(mine.names.index(name), k) for k, name in enumerate(names) if name in mine.names[mine.moving :]]

    def into_state(self, carried: np.ndarray, state: np.ndarray) -> None:
        """Puts the integrals of a row (k,) where a leg has them."""
        for mine, theirs in self.pairs:
            state[mine] = carried[theirs]

    def into_rows(self, states: np.ndarray, carried: np.ndarray) -> np.ndarray:
        """The integrals of states (n, variables), as rows have them, (n, k); those that do not move are as given."""
        rows = np.repeat(carried[None, :], len(states), axis=0)
        for mine, theirs in self.pairs:
            rows[:, theirs] = states[:, mine]
        return rows


def reached(kind: Kind, states: np.ndarray, body: Body) -> Reached:
    """What states (n, variables) of a phase say, arrays (n,)."""
    q = type(kind.form.units)(*states.T[: len(kind.form.units)])
    return kind.says(q, body)


def rows_of(
    kind: Kind, ball: int, balls: Balls, states: np.ndarray, carried: np.ndarray, taken: Any, number: Any
) -> np.ndarray:
    """States (n, variables) of a phase as rows.

    Parameters
    ----------
    kind, ball
        The phase, and the number of the ball in contact.
    balls
        All balls.
    states
        Internal units.
    carried
        The integrals, (n, k), scaled.
    taken
        Jellett's integral when the ball was taken.
    number
        The type of numbers.

    Returns
    -------
    rows
        (n, variables of a row), internal units.
    """
    body, n = balls[ball], len(states)
    says = reached(kind, states, body)
    if not kind.keeps_jellett:
        taken = jellett(says.u, says.L, Ball(body.m, body.I1, body.I3, body.g, 0, body.c, body.R))
    gap = stem_height(says.height, says.u.z, balls[1].c, balls[1].R) if balls.stem else 0
    row = Row(
        *says.u, *says.L, *says.velocity, says.height, *says.force,
        body.R, body.c, gap, PHASES.index(kind.phase), ball, taken, says.drilled,
    )  # fmt: skip
    rows = np.empty((n, len(row) + carried.shape[1]), dtype=number)
    for k, value in enumerate(row):
        rows[:, k] = value
    rows[:, len(row) :] = carried
    return rows
