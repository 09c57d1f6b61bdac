"""Events of a phase that Python evaluates, whose functions have no Taylor series."""

import copy
from collections.abc import Mapping
from functools import partial
from typing import Any

from ..mechanics.event import Event, zero_of
from ..mechanics.form import Form
from ..mechanics.operand import leaves
from .driver import Driver


class Sampler:
    """Looks for sampled events in the next step of a phase, before it is made.

    Parameters
    ----------
    form, b
        Of the phase, and its parameters.
    integrator
        Of the phase.
    events
        Those that are sampled, by number.
    """

    def __init__(self, form: Form, b: Any, integrator: Any, events: Mapping[int, Event]):
        self.form, self.b, self.events = form, b, events
        self.integrator = ta = copy.deepcopy(integrator)
        ta.pars[:] = leaves(b)[: len(ta.pars)]

    def next(self, run: Driver) -> list[tuple[Any, int]]:
        """Return the internal times of events that would end the phase in the next step, and their
        numbers.
        """
        ta, (high, low) = self.integrator, run.clock
        ta.state[:], ta.time = run.state, run.number(0)
        _, h = ta.step(write_tc=True)
        zeros = (
            (zero_of(partial(self._value, event), 0 * h, h / 2, h), number)
            for number, event in self.events.items()
        )
        return [(run.number(high) + (low + t), number) for t, number in zeros if t is not None]

    def _value(self, event: Event, t: Any) -> float:
        """Return the value of an event function at a time in the step."""
        q = self.form.units._make(
            self.integrator.update_d_output(t)[: len(self.form.units)].tolist()
        )
        return float(event.formula(self.form.scalars(q, self.b), self.b))
