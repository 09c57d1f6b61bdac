"""A phase of a run, which an ordinary driver integrates."""

import threading
from typing import Any

import numpy as np

from ...mechanics.systems.with_contact import kinds_of, leg
from ...mechanics.variables import Variables
from ...problem import Problem
from ..driver import Driver
from ..taylor import new_driver
from .balls import Balls


class Carried:
    """Which integrals a leg moves, and where they stand among the variables of a row."""

    def __init__(self, whole: Problem, mine: Variables):
        theirs = whole.variables
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
    stop
        Set it to give up while its equations are being compiled.
    """

    def __init__(self, whole: Problem, name: str, ball: int, balls: Balls, q: Any, stop: threading.Event | None):
        self.name, self.ball, self.body, self.kind = name, ball, balls[ball], kinds_of(whole.system.name)[name]
        system = leg(whole.system.name, name)
        form = next(iter(system.forms.values()))
        variables, functions = Variables(form, whole.orientation), np.ones(len(system.events))
        first = np.zeros(len(variables.names), dtype=whole.number)
        first[: len(q)] = q
        self.driver: Driver = new_driver(whole, system, form, self.body, first, functions, stop)
        self.fresh = [array.copy() for array in self.driver.tallies]
        self.carried, self.events = Carried(whole, variables), system.events
        self.names = [event.name for event in self.events]
        of_run = [event.name for event in whole.system.events]
        self.numbers = np.array([of_run.index(n) if n in of_run else -1 for n in self.names], int)
        self.axis = [(k, n) for k, n in enumerate(self.names) if n in AXIS]
        self.record = type(self.kind.form.units)
