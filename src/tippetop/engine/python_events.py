"""Find events of a phase whose functions have no Taylor series, and are sampled by Python.

A run goes in; times of events in its next step come out, for `HybridDriver.next_end`.
"""

from functools import partial
from typing import Any

from ..mechanics.event import Event, zero_of
from ..mechanics.operand import leaves


def sampled_in_next_step(run: Any) -> list[tuple[Any, int]]:
    """Return the internal times and numbers of the sampled events in the next step of a run.

    `run` is a `HybridDriver`. The step is made by a copy of the integrator of its phase,
    `solver.ahead`, from the state of the run. The functions are positive at its
    start; a zero is sought by their signs at its middle and end. The next step of the run must end
    at the first one: `end_next` sets it.
    """
    solver, (high, low) = run.solver, run.clock
    ta = solver.ahead
    ta.pars[:] = leaves(solver.b)[: len(ta.pars)]
    ta.state[:], ta.time = run.state[: len(ta.state)], run.number(0)
    _, h = ta.step(write_tc=True)

    def value(event: Event, t: Any) -> float:
        """Return the event function at the time t of the trial step."""
        q, _ = solver.variables.split(ta.update_d_output(t).tolist())
        return float(event.formula(solver.phase.form.scalars(q, solver.b), solver.b))

    found = []
    for number, event in solver.sampled.items():
        t = zero_of(partial(value, event), 0 * h, h / 2, h)
        if t is not None:
            found.append((run.number(high) + (low + t), number))
    return found
