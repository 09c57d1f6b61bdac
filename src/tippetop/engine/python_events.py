"""Events of a phase that Python evaluates, whose functions have no Taylor series."""

import copy
from collections.abc import Mapping
from functools import partial
from typing import Any

from ..mechanics.event import Event, zero_of
from ..mechanics.operand import leaves
from .driver import Driver


class Sampler:
    """Looks for sampled events in the next step of a phase, before it is made.

    Parameters
    ----------
    track
        The phase.
    integrator
        Of the phase.
    events
        Those that are sampled, by number.
    """

    def __init__(self, track: Any, integrator: Any, events: Mapping[int, Event]):
        self.track, self.events, self.integrator = track, events, copy.deepcopy(integrator)
        self.integrator.pars[:] = leaves(track.b)[: len(self.integrator.pars)]

    def next(self, run: Driver) -> list[tuple[Any, int]]:
        """Return the internal times of events that would end the phase in the next step, and their
        numbers.
        """
        ta, (high, low) = self.integrator, run.clock
        ta.state[:], ta.time = run.state, run.number(0)
        _, h = ta.step(write_tc=True)
        found = []
        for number, event in self.events.items():
            t = zero_of(partial(self._value, event), 0 * h, h / 2, h)
            if t is not None:
                found.append((run.number(high) + (low + t), number))
        return found

    def _value(self, event: Event, t: Any) -> float:
        """Return the value of an event function at a time in the step."""
        track, state = self.track, self.integrator.update_d_output(t)
        q, _ = track.variables.split(state[: track.width].tolist())
        return float(event.formula(track.phase.form.scalars(q, track.b), track.b))
