"""Rows and events of the first moments of a slide, which a series gives and no step."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ...mechanics.contact.body import Touch
from ...mechanics.contact.first_slip import FirstSlip
from ...mechanics.contact.phases.legs import Kind
from ...mechanics.variables import INTEGRAL_SCALE
from ..tallies import SIGN
from .beginning import states
from .gathered import Gathered
from .rows import rows_of
from .transitions import Change


if TYPE_CHECKING:
    from .driver import ContactDriver


def fill_between(driver: "ContactDriver", change: Change, start: Any, output: Gathered) -> None:
    """Gives the rows that are wanted of the beginning of a slide, and logs what passes in it.

    Parameters
    ----------
    driver
        The run, whose slide has begun.
    change
        The slide.
    start
        When it began, internal time.
    output
        Takes the events and the rows.
    """
    between, lag = change.between, change.lag
    assert between is not None
    kind, body, number = driver.phase.kind, driver.phase.body, driver.problem.number
    moving = len(kind.form.units)

    def rows(t: np.ndarray) -> np.ndarray:
        values = states(kind, body, between, t).T
        carried = values[:, moving:] * INTEGRAL_SCALE
        return rows_of(kind, driver.ball, driver.balls, values[:, :moving], carried, driver.taken, number)

    inner, wanted = driver.inner, driver.wanted
    while not output.steps:
        wanted.ask(output)
        left = wanted.left
        count = int(np.searchsorted(left, float(start + lag)))
        if count:
            t = left[:count].astype(number) - start
            output.take_rows(left[:count], rows(np.clip(t, 0 * lag, lag)))
        wanted.made += count
        if count < len(left) or not count:
            break
    for k, event in enumerate(driver.phase.events):
        if event.name not in change.signs:
            continue
        function = _along(event, kind, body, between)
        sign, before = 1.0 if function(lag) > 0 else -1.0, change.signs[event.name]
        if sign != before:
            t = zero_of(function, before, lag)
            inner.tallies.functions[SIGN, k, 0] = sign
            output.note_row(event.name, start + t, rows(np.array([t])), sign)


def zero_of(function: Callable[[Any], float], sign: float, end: Any) -> Any:
    """Where a function that begins with a sign has its zero, in [0, end]."""
    low, high = 0 * end, end
    while low < (middle := (low + high) / 2) < high:
        low, high = (middle, high) if function(middle) * sign > 0 else (low, middle)
    return high


def _along(event: Any, kind: Kind, body: Touch, between: FirstSlip) -> Callable[[Any], float]:
    """An event function of the time since the beginning of a slide."""

    def function(t: Any) -> float:
        values = states(kind, body, between, np.array([t]))[:, 0]
        q = type(kind.form.units)(*values[: len(kind.form.units)])
        return float(event.formula(kind.form.scalars(q, body), body))

    return function
