"""Convert the zeros that lanes found to an event log of each top, as that of a single run.

Passages in arrays of `Outcomes` go in, `EventTable`s come out.
"""

import numpy as np

from ..columns import Column
from ..engine.driver import Passages
from ..engine.observables import Observables
from ..engine.tallies import event_rows, new_tallies
from ..problem import Problems
from ..runs.event_log import EventLog
from ..runs.events import EventTable
from .hybrid_tops import problem_of
from .outcomes import Outcomes


TOP = {"units": "1", "long_name": "number of the top"}


def log_of(tops: Problems, top: int) -> EventLog:
    """Return an empty log of one of the tops, by its number, which converts its zeros to rows.

    Its tallies keep no numbers of events: lanes have counted them.
    """
    problem = problem_of(tops, top)
    tallies = new_tallies(event_rows((), (), ()), np.ones((0, 1)))
    return EventLog(Observables(problem), problem.start()[None], tallies)


def log_events(measured: Outcomes) -> None:
    """Write `measured.events`, the event table of each top, from the zeros that lanes found.

    Only tops of one phase are logged in lanes: `measure` runs the others alone.
    """
    tops = measured.tops
    rows, states = map(np.concatenate, zip(*measured.passages, strict=True))
    # of one top times ascend; "phase" is its number here
    order = np.argsort(rows["phase"], kind="stable")
    some, first = np.unique(rows["phase"][order], return_index=True)
    for top, numbers in zip(some.tolist(), np.split(order, first)[1:], strict=True):
        log = log_of(tops, top)
        its = rows[numbers]  # as PASSAGE_RECORD of `tallies`
        log.tallies.lane["lasts_since"] = measured.lasts_since[top]
        # the fields of `Passages` in its order, the states last, without padding
        columns = [its[name] for name in ("time", "event", "sign", "at_pole")]
        zeros = Passages._make([*columns, states[numbers, : len(tops.start)]])
        table, marks, _ = log.add_zeros(zeros)
        table.significant[[*marks, *log.finish(measured.final[:, [top]].T)]] = True
        measured.events[top] = table


def event_table(measured: Outcomes) -> dict[str, Column]:
    """Return the events of all tops as columns along `event`, ascending by top and time.

    `top` comes first; the others are those of the event table of a run. `sweeps.chunk` stores them.
    """
    each = sorted(measured.events.items())
    joined = EventTable.joined([log_of(measured.tops, 0).empty, *(table for _, table in each)])
    numbers = np.repeat([top for top, _ in each], [len(table.time) for _, table in each])
    return {"top": Column(("event",), numbers.astype(np.int64), TOP), **joined}
