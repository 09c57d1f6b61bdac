"""Events of a phase that Python evaluates, whose functions have no Taylor series."""

import copy
from collections.abc import Callable, Sequence
from typing import Any

from ..mechanics.event import Event
from .driver import Driver
from .integrator import Compiled


class Sampler:
    """Looks for sampled events in the next step of a phase, before it is made.

    Parameters
    ----------
    driver
        Of the run.
    code
        The integrator of the phase.
    body
        Its parameters, perhaps with others behind.
    events
        Those that are sampled.
    function
        function(state, event) -> value of an event in a state, (all variables,).
    """

    def __init__(
        self,
        driver: Driver,
        code: Compiled,
        body: Sequence[Any],
        events: Sequence[Event],
        function: Callable,
    ):
        self.driver, self.events, self.function = driver, events, function
        self.integrator = copy.deepcopy(code.integrator)
        pars = self.integrator.pars
        pars[:] = [driver.number(number) for number in body[: len(pars)]]

    def next(self) -> tuple[str, Any] | None:
        """Return the event that ends the phase in the next step, and its internal time; None if
        none does.
        """
        ta = self.integrator
        ta.state[:], ta.time = self.driver.state, self.driver.number(0)
        _, h = ta.step(write_tc=True)
        zeros = [
            (t, event.name) for event in self.events if (t := self._zero(event, h)) is not None
        ]
        if not zeros:
            return None
        t, name = min(zeros)
        high, low = self.driver.clock
        return name, self.driver.number(high) + (low + t)

    def _zero(self, event: Event, h: Any) -> Any:
        """Return the time in a step of length h at which an event function has become negative."""
        low = 0 * h
        for high in (h / 2, h):
            if not self._value(event, high) > 0:
                return zero_of(lambda t: self._value(event, t), low, high)
            low = high
        return None

    def _value(self, event: Event, t: Any) -> float:
        return float(self.function(self.integrator.update_d_output(t), event))


def zero_of(function: Callable, low: Any, high: Any) -> Any:
    """Return where a function that is positive at first has its zero, between two times."""
    while low < (middle := (low + high) / 2) < high:
        low, high = (middle, high) if function(middle) > 0 else (low, middle)
    return high
