"""Call the compiled loop, `loop.c` of `tippetop_kernels`, with arrays of Python.

A record (named tuple) of numbers and arrays becomes a structure of C with the same fields, in which
arrays are pointers: `structure` makes its type, `filled` its values. A field that is added to a
record here must be added to its struct in loop.c, at the same place. `driver` and `pools` make a
`Loop` for each integrator.

Symbols
    tops, lanes  runs in the arrays, and places in a SIMD integrator; 1 each for a single run
    size         order + 1, the number of Taylor coefficients; h: length of the present step
    variables    of an integrator, those added for event functions included
    width        numbers from one state to the next in logs, samples and rows: the most variables
"""

import ctypes
import hashlib
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import tippetop_kernels

from ..errors import BuildError
from ..mechanics.event import NOISE_FLOOR
from .stepper import Called, Loaded, Stepper
from .tallies import CONFIRMS, WAITS, EventRows, Log, Rules, Tallies


MOST_COEFFICIENTS = 64
"""Coefficients of a polynomial for which the loop has room; quadruple precision has 47."""


class Motion(NamedTuple):
    """The arrays of the lanes of an integrator: internal units, time in double length."""

    state: np.ndarray  # (variables, lanes)
    before: np.ndarray  # (variables, lanes) where the present step began
    pars: np.ndarray  # (parameters, lanes)
    tc: np.ndarray  # (variables, order + 1, lanes) Taylor coefficients of the present step
    high: np.ndarray  # (lanes,) time
    low: np.ndarray
    start_high: np.ndarray  # (lanes,) time where the present step began
    start_low: np.ndarray
    end: np.ndarray  # (lanes,) of the run
    limit: np.ndarray  # (lanes,) the longest step that is allowed
    h: np.ndarray  # (lanes,) the step that was made
    in_lane: np.ndarray  # (lanes,) which top is in a lane; of a run, the number of its phase
    slots: np.ndarray  # (lanes,) where the tally of this top is
    ended_by: np.ndarray  # (lanes,) the event that ended it; -1: none
    steps_before: np.ndarray  # (lanes,) steps of a top before those of its tally


class Rows(NamedTuple):
    """Output arrays for the states of a run at given times, or at the ends of its steps.

    For tops in lanes, a first dimension counts the tops.
    """

    times: np.ndarray  # (length,) internal, ascending; those of steps are written here
    states: np.ndarray  # (length, all variables) in the working precision
    phases: np.ndarray  # (length,) number of the phase of a run; of a top in lanes, its `in_lane`
    filled: np.ndarray  # (1,) number of rows that are written
    steps: bool  # at the ends of steps
    length: int = 0


NO_ROWS = Rows(np.zeros(0), np.zeros((0, 0)), np.zeros(0, np.int64), np.zeros(1, np.int64), False)


class _Sizes(NamedTuple):
    """Lengths of the arrays of a `_Loop`."""

    width: int  # 0: a stepper in Python keeps the states
    variables: int
    parameters: int
    size: int  # Taylor coefficients of a variable
    lanes: int
    tops: int  # tallies
    events: int
    axis: int  # rows of 3hat: 3, or 0 where it is not integrated
    log: int  # room for passages
    samples: int  # room for samples


class _Loop(NamedTuple):
    """The structure `Loop` of `loop.c`, field by field."""

    step: int  # address; None: no steps are made
    dense: int
    fused: bool  # as in `Loaded`
    sizes: _Sizes
    motion: Motion
    rows: EventRows
    tallies: Tallies
    log: Log
    samples: Log
    # (2, order + 1, lanes) which convert coefficients in time to those in time over h
    factors: np.ndarray
    out: np.ndarray  # (variables, lanes) a state
    tape: np.ndarray  # where a step in compact mode works
    rules: Rules
    output: Rows


@cache
def structure(record: type) -> type[ctypes.Structure]:
    """Return the type of the structure of C that has the fields of a named tuple.

    Annotations decide the types in C, so a field is an int, a bool (8 bytes too), a float, an array
    or another such tuple.
    """
    integer = ctypes.c_int64
    number = ctypes.c_double
    pointer = ctypes.c_void_p
    kinds: dict[type, Any] = {int: integer, bool: integer, float: number, np.ndarray: pointer}
    fields = [
        (name, kinds.get(kind) or structure(kind)) for name, kind in record.__annotations__.items()
    ]
    return type(record.__name__, (ctypes.Structure,), {"_fields_": fields})


def filled(record: Any) -> ctypes.Structure:
    """Return the structure of C with the values of a named tuple.

    The arrays must be contiguous and outlive it.
    """
    kind: Any = type(record)
    return structure(kind)(*map(_field, record))


def _field(value: Any) -> Any:
    """Return a field as C takes it: a number, a structure, or the address of an array.

    The address of an empty array is None (NULL).
    """
    if isinstance(value, tuple):
        return filled(value)
    if not isinstance(value, np.ndarray):
        return value
    # a third of the time of `value.ctypes.data`
    return ctypes.addressof(ctypes.c_char.from_buffer(value.data)) if value.size else None


@cache
def library() -> ctypes.CDLL:
    """Return the compiled loop.

    A function that Python calls needs an entry in `arguments` with the types of its declaration in
    loop.c. Raises BuildError if the loop is missing, or was compiled from another source.
    """
    folder = Path(tippetop_kernels.__file__).parent
    built = folder / "loop.so"
    source = folder / "loop.c"
    try:
        loaded = ctypes.CDLL(str(built))
        text = source.read_bytes()
    except OSError as error:
        raise BuildError(f"{error}: install tippetop again (pip install -e .).") from None
    loaded.loop_digest.restype = ctypes.c_char_p
    expected = hashlib.sha256(text).hexdigest()
    if loaded.loop_digest().decode() != expected:
        raise BuildError(
            f"`{built}` must be compiled from `{source.name}` as it is, but is older or newer: "
            "install tippetop again "
            "(pip install -e .)."
        )
    integer = ctypes.c_int64
    array = ctypes.c_void_p
    arguments: dict[str, list[Any]] = {
        "loop_drive": [array, integer],
        "loop_run": [array, array, integer, integer],
        "loop_pools": [array, integer],
        "loop_push": [array, integer],
        "loop_start": [array, array, integer],
        "loop_note": [array, array, *[integer] * 4, ctypes.c_double, array],
        "loop_columns": [*[integer] * 3, array, array],
        "loop_count_turnings": [array, ctypes.c_double, integer, array, array, array],
    }
    for name, kinds in arguments.items():
        function = getattr(loaded, name)
        function.argtypes, function.restype = kinds, integer
    return loaded


def new_motion(variables: int, parameters: int, size: int, lanes: int) -> Motion:
    """Return empty lanes of an integrator whose Taylor polynomials have `size` coefficients.

    `variables` are those of the integrator, with those added for event functions.
    """
    # by position, as the fields of `Motion`: state, before; pars, tc; high to h; in_lane to the end
    numbers = np.zeros((parameters, lanes)), np.zeros((variables, size, lanes))
    of_lanes = *np.zeros((7, lanes)), *np.zeros((4, lanes), np.int64)
    motion = Motion._make([*np.zeros((2, variables, lanes)), *numbers, *of_lanes])
    motion.slots[:] = np.arange(lanes)
    return motion


class Loop:
    """The loop of a run, or of the lanes of an ensemble, bound to their arrays.

    Parameters
    ----------
    motion
        The lanes.
    rows, tallies, log, samples
        The events to find, and the arrays that the loop fills.
    rules
        When a run ends or is sampled.
    stepper
        Makes the Taylor steps. One whose code is NULL makes none: `HybridPools` notes events by it.
    """

    def __init__(
        self,
        motion: Motion,
        rows: EventRows,
        tallies: Tallies,
        log: Log,
        samples: Log,
        rules: Rules,
        stepper: Stepper,
    ):
        """Describe all arrays in one structure of C, and keep a reference to each."""
        code: list[Any] = []
        variables, size, lanes = motion.tc.shape
        self.out = np.zeros((variables, lanes))  # a state in every lane
        self.failures: list[BaseException] = []  # of steps that C has called
        tape = np.empty(0)
        if isinstance(stepper, Loaded):
            *code, length = stepper[1:]  # step, dense, fused; tape
            tape = np.empty(length + 7)
            tape = tape[-tape.ctypes.data % 64 // 8 :][:length]  # LLVM's vectors lie on 64 bytes
        width = log.states.shape[1]  # numbers from one state to the next
        if isinstance(stepper, Called):
            self.callbacks = _callbacks(stepper, motion, self.failures)
            code = [ctypes.cast(one, ctypes.c_void_p).value for one in self.callbacks] + [False]
            width = 0  # the stepper keeps states: the loop writes all of them to one place
            log = log._replace(states=self.out)
            samples = samples._replace(states=self.out)
        lengths = map(len, (tallies.lane, rows.events, rows.axis, log.rows, samples.rows))
        sizes = _Sizes(width, variables, len(motion.pars), size, lanes, *lengths)
        arrays = np.empty((2, size, lanes)), self.out, tape
        parts = sizes, motion, rows, tallies, log, samples, *arrays, rules, NO_ROWS
        self.record = _Loop._make([*code, *parts])  # keeps the arrays
        self.structure: Any = filled(self.record)
        self.place = ctypes.byref(self.structure)
        self.output = NO_ROWS

    def fill(self, rows: Rows) -> None:
        """Set the arrays into which the next steps write their rows.

        Each phase has a loop, so it is called before every drive; the same object changes nothing.
        """
        if rows is not self.output:
            states = rows.states if self.record.sizes.width else self.out
            self.structure.output = filled(rows._replace(states=states))
            self.output = rows

    def drive(self, most: int) -> int:
        """Make at most `most` steps of all lanes. Return their number.

        The loop stops earlier if a run has ended, all rows are written, or the log may not have
        room for the events of a step.
        """
        steps = library().loop_drive(self.place, most)
        if self.failures:
            raise self.failures.pop()
        return steps


def _callbacks(stepper: Called, motion: Motion, failures: list[BaseException]) -> list[Any]:
    """Return step and dense output of a stepper as functions of C.

    An error, which cannot pass through C, ends the runs: their next step is NaN.
    """

    def called(work: Callable[[], None], count: int) -> Any:
        """Return a C function of `count` pointers, which are ignored, that does the work.

        After an error it ends the runs instead. Its result must be kept as long as C may call it.
        """

        def function(*_: int) -> None:
            """Do the work; keep an error for `Loop.drive`, and make the step NaN: it ends runs."""
            try:
                if not failures:
                    work()
            except BaseException as error:
                failures.append(error)
            if failures:
                motion.h[:] = np.nan

        return ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * count)(function)

    return [called(partial(stepper.step, motion), 5), called(stepper.keep, 3)]


def count_turnings(
    lane: np.ndarray, signs: np.ndarray, theta: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Count turnings of theta that are more than rounding in a tally.

    An extreme counts once theta has come back from it by `NOISE_FLOOR`: until then it waits.

    Parameters
    ----------
    lane
        The tallies of runs (LANE_RECORD), of which the first is counted: of a single run, whose
        loop leaves all turnings to `runs.event_log`; or of a top in lanes, whose end is the only
        one left.
    signs, theta
        (k,) +1 for a minimum, -1 for a maximum of theta; 0 for a passage of a pole and for the end
        of a run, which end a swing; [rad].

    Returns
    -------
    confirmed, waits
        (k,) whether the turning that waited counts; whether this one waits from now on.
    """
    signs = np.ascontiguousarray(signs, np.int64)
    theta = np.ascontiguousarray(theta, float)
    effects = np.empty(len(signs), np.int64)
    arrays = (array.ctypes.data for array in (signs, theta, effects))
    library().loop_count_turnings(lane.ctypes.data, float(NOISE_FLOOR), len(signs), *arrays)
    return effects & CONFIRMS > 0, effects & WAITS > 0
