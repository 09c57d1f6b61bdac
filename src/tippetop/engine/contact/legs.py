"""A phase of a run as a problem of its own, which an ordinary driver integrates."""

from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

from ...mechanics.contact.body import Touch
from ...mechanics.moment import moment
from ...mechanics.operand import leaves
from ...mechanics.systems.with_contact import kinds_of, leg
from ...mechanics.units import Scales
from ...problem import Problem
from ..slices import Driver
from .balls import Balls


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
            moment=lambda states, body: moment(self.system, self.form, *self.variables.split(states), body),
        )


def new_leg(whole: Problem, kind: str, internal: Touch, first: np.ndarray) -> Leg:
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
        pairs = [(mine.names.index(name), k) for k, name in enumerate(names) if name in mine.names[mine.moving :]]
        self.mine, self.theirs = np.array(pairs, int).reshape(-1, 2).T

    def into_state(self, carried: np.ndarray, state: np.ndarray) -> None:
        """Puts the integrals of a row (k,) where a leg has them."""
        state[self.mine] = carried[self.theirs]

    def into_rows(self, states: np.ndarray, carried: np.ndarray) -> np.ndarray:
        """The integrals of states (n, variables), as rows have them; those that do not move are as given, (n, k)."""
        rows = carried.copy()
        rows[:, self.theirs] = states[:, self.mine]
        return rows


AXIS = ("turning", "equator", "inverted")
"""Events of how the axis moves, which every phase has where theta moves."""


class Followed:
    """A phase that a run may have, and the ordinary driver that follows it.

    Parameters
    ----------
    whole
        The run.
    name, ball
        The kind of the phase, of `legs.KINDS`, and the number of the ball in contact.
    balls
        All balls.
    q
        A state that it may have.
    make
        make(leg) -> the ordinary driver of a phase.
    """

    def __init__(self, whole: Problem, name: str, ball: int, balls: Balls, q: Any, make: Callable):
        self.name, self.ball, self.body, self.kind = name, ball, balls[ball], kinds_of(whole.system.name)[name]
        integrals = len(whole.variables.names) - whole.variables.moving
        first = np.zeros(len(q) + integrals, dtype=whole.number)
        first[: len(q)] = q
        part = new_leg(whole, name, self.body, first)
        part = new_leg(whole, name, self.body, first[: len(part.variables.names)])
        self.driver: Driver = make(part)
        self.fresh = [array.copy() for array in self.driver.tallies]
        self.carried, self.events = Carried(whole, part), part.system.events
        self.names = [event.name for event in self.events]
        of_run = [event.name for event in whole.system.events]
        self.numbers = np.array([of_run.index(n) if n in of_run else -1 for n in self.names], int)
        self.axis = [(k, n) for k, n in enumerate(self.names) if n in AXIS]
        self.record = type(self.kind.form.units)
