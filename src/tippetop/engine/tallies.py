"""Arrays that the loop fills (tallies, log of events, samples), and its table of events.

`event_rows` converts events to records for C, `new_tallies` and `new_log` allocate the arrays.
Their layout is that of the structs in loop.c: change both together.

Symbols
    event function  formula of an `Event` along a run; coefficients: those of its Taylor polynomial
    passage         a zero of an event function, a row of the log
    lane            place of a run in a SIMD integrator; a single run is in lane 0
    kept numbers    first or last time, or count, of the passages of an event
"""

import math
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..mechanics.event import AT_POLE, NEAR_POLE, NOISE_FLOOR, ON_ZERO, ON_ZERO_FOR, Event
from .status import Status


FIRST, LAST, COUNT = range(3)
WHAT = {"first": FIRST, "last": LAST, "count": COUNT}


class EventRows(NamedTuple):
    """The events of a system, in its order, as arrays of records that the loop reads.

    An event function is variable `row` plus `offset` (`shift` 0); or, times `scale`, a power of
    two, the rate of this variable (`shift` 1). `direction`, `sense`, `lasting` and `extremes` are
    those of `Event`; `ends` is the code of the status of a run that it ends, or 0; it keeps the
    `numbers` from `first` to before `last`. Only `watched` events are searched for zeros, and only
    `ranged` ones for extremes.
    """

    events: np.ndarray  # (events,)
    # (numbers,) `what`: FIRST, LAST or COUNT; `direction` of the passages that are meant
    numbers: np.ndarray
    axis: np.ndarray  # (3,) rows of 3hat; (0,) where it is not integrated


class Rules(NamedTuple):
    """The limits at which a run ends other than by an event, sampling, and thresholds of events."""

    settled_for: float  # internal time that the lasting event must have lasted
    most_steps: int
    every: int  # steps between two samples, a power of two
    first: int  # number of steps at the start that are all sampled
    noise_floor: float = float(NOISE_FLOOR)
    at_pole: float = AT_POLE
    near_pole: float = NEAR_POLE
    on_zero_for: float = ON_ZERO_FOR
    settled_every: int = 1  # steps between two looks whether a run has settled


_LANE: dict[str, Any] = {
    "status": Status.RUNNING.code,
    "t": 0.0,  # internal time reached
    "steps": 0,
    "upto": 1.0,  # how far of the last step
    "tiny": 0,  # steps in a row that led nowhere
    "waiting": 0,  # sign of the turning that waits to be confirmed; 0: none
    "waits_at": 0.0,  # its theta
    "turnings": 0,  # that are more than rounding
    "theta_min": math.nan,  # their band
    "theta_max": math.nan,
    # when the lasting event last happened, while it may last; 0: it lasts from the start
    "lasts_since": math.nan,
}
"""Initial values of a lane; times are internal, NaN if the event did not happen. The order is that
of `Tally` in loop.c, and of snapshots in stores.
"""


def record_type(**kinds: str) -> np.dtype:
    """Return the type of a record of C: the names of its fields by kind, in the order of both."""
    fields = [(name, kind) for kind, names in kinds.items() for name in names.split()]
    return np.dtype(fields, align=True)


_FUNCTION = [(name, float) for name in ("sign", "on_zero", "low", "high")]
FUNCTION_RECORD = np.dtype([*_FUNCTION, ("extremes", float, 2), ("times", float, 2)])
"""The state of an event function: its sign, +1 or -1; 1 if the run starts on a zero of it, -k if
its first k Taylor coefficients vanish there; of the present step its bounds; its least and greatest
values, in the scale of the coefficients, and their times. Snapshots in stores have this order.
"""


class Tallies(NamedTuple):
    """Counters, event functions and kept numbers of the tops in lanes; times are internal."""

    lane: np.ndarray  # (lanes,) records: how far each has come, and its turnings
    functions: np.ndarray  # (events, lanes) records of event functions
    kept: np.ndarray  # (numbers, lanes) times, NaN: did not happen; or counts


EVENT_RECORD = record_type(
    int="row shift direction ends sense first last",
    float="scale offset",
    bool="lasting extremes watched ranged",
)
LANE_RECORD = np.dtype([(name, np.array(value).dtype) for name, value in _LANE.items()])
NUMBER_RECORD = record_type(int="what direction")


def event_rows(
    events: Sequence[Event], sources: Sequence[tuple[int, int, float, float]], axis: Sequence[int]
) -> EventRows:
    """Return events as arrays of records, all watched; `looked_for` selects those of a run.

    `sources` contains variable, shift, scale and offset of each function, which `compiled_from`
    finds; `axis` the variables of 3hat, empty in a form without it. The numbers that events keep
    are in the order of the events: `runs.event_log` and `ensembles.lanes` read them so.
    """
    records: list[tuple] = []
    numbers: list[tuple[int, int]] = []
    for event, (variable, shift, scale, offset) in zip(events, sources, strict=True):
        first = len(numbers)
        ranged = bool(event.extremes)
        numbers += [(WHAT[kept.what], kept.direction) for kept in event.kept]
        ends = Status.of_event(event.ends).code if event.ends else 0
        place = variable, shift, event.direction, ends, event.sense, first, len(numbers)
        records.append((*place, scale, offset, event.lasting, ranged, True, ranged))
    return EventRows(
        np.array(records, EVENT_RECORD), np.array(numbers, NUMBER_RECORD), np.array(axis, int)
    )


def looked_for(
    rows: EventRows, watched: Iterable[bool], ranged: Iterable[bool] | None = None, *, stops: bool
) -> EventRows:
    """Return the events as one run looks for them.

    Parameters
    ----------
    rows
        All events.
    watched
        Whether the zeros of each are found, in the order of the events.
    ranged
        Whether its extremes are found; None: of all events that report them.
    stops
        Whether events may end the run: the option `on_liftoff`, for all of them.
    """
    records = rows.events.copy()
    records["watched"] = list(watched)
    if ranged is not None:
        records["ranged"] &= list(ranged)
    if not stops:
        records["ends"] = 0
    return rows._replace(events=records)


def new_tallies(rows: EventRows, functions: np.ndarray) -> Tallies:
    """Return the tallies of runs that start with these event functions, (events, lanes).

    The sign of a function that is NaN is not known: 0. A function nearer to zero than ON_ZERO
    starts on a zero, which then is no event. `PhaseSolver.begins` has the same rule.
    """
    lanes = functions.shape[1]
    lane = np.empty(lanes, LANE_RECORD)
    known = np.zeros(functions.shape, FUNCTION_RECORD)
    lane[:] = tuple(_LANE.values())
    known["sign"] = 1.0 * (functions > 0) - (functions <= 0)
    known["on_zero"] = np.abs(functions) < ON_ZERO
    known["extremes"], known["times"] = (np.inf, -np.inf), np.nan
    kept = np.where(rows.numbers["what"] == COUNT, 0.0, np.nan)
    lane["lasts_since"] = lasts_from_start(known, rows)
    return Tallies(lane, known, np.repeat(kept[:, None], lanes, axis=1))


def lasts_from_start(functions: np.ndarray, rows: EventRows) -> np.ndarray:
    """Return 0 for runs in which an event lasts from the start, (lanes,); NaN for others.

    It lasts if the sign of its function at the start is its direction. `functions` are
    FUNCTION_RECORDs, (events, lanes).
    """
    lasting, direction = (rows.events[name][:, None] for name in ("lasting", "direction"))
    lasts = lasting & (functions["sign"] == direction)
    return np.where(lasts.any(axis=0), 0.0, math.nan)


CONFIRMS, WAITS = 1, 2
"""Effects of a passage on the turning that waits to be counted: that turning counts; this one waits
from now on.
"""


# internal; number of the event; of the crossing, +1 rising; the phase of a run, or the top that is
# in the lane; whether the axis passes a pole there
PASSAGE_RECORD = record_type(float="time", int="event sign phase lane", bool="at_pole")


class Log(NamedTuple):
    """Rows with states that the loop appends.

    They are zeros of event functions, those of a lane in order; or samples, ends of steps at which
    the invariants are compared with the start.
    """

    filled: np.ndarray  # (1,) how many there are
    rows: np.ndarray  # (n,) passages; of samples, whose state it is: their phase or top
    states: np.ndarray  # (n, width) in the working precision


def new_log(length: int, variables: int, number: Any = float, row: Any = PASSAGE_RECORD) -> Log:
    """Return an empty log with room for `length` rows, with states of type `number`.

    `row` is PASSAGE_RECORD for passages, an integer for samples. Length 0: the loop keeps none.
    """
    states = np.empty((length, variables), number)
    return Log(np.zeros(1, np.int64), np.empty(length, row), states)
