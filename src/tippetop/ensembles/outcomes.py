"""The outcomes of the tops of an ensemble: status, class, times, angles, forces, drift.

Lanes write rows in internal units; `dataset` and `table` return columns in SI units.
"""

from typing import TYPE_CHECKING, Any

import numpy as np

from ..columns import Column, column, flag_attributes, plain_attributes
from ..engine.observables import orientations_of, values_of
from ..engine.settling import CLASSES, classes_of
from ..engine.status import Status
from ..errors import owner
from ..mechanics.contact.gliding import EVENTS
from ..mechanics.system import Quantity, System
from ..mechanics.units import NEWTON, ONE, PER_SECOND, RADIAN, SECOND, Unit
from ..problem import PSI, Problems
from ..runs.drift import Drift
from ..runs.events import EventTable
from ..scenario import build


if TYPE_CHECKING:
    import xarray as xr


QUIET = np.errstate(all="ignore")
"""The numbers of invalid tops are computed with, and not used."""

STATUSES = tuple(status.value for status in Status if status is not Status.RUNNING)
"""Words of the column `status`, by number."""

SWINGS = ("turnings", "theta_min", "theta_max")  # columns that turnings give
LYAPUNOV = "lyapunov"  # a column that is left out unless it is asked for
ColumnForm = tuple[Any, Unit, str]  # of a column: its value before a top has one, unit, meaning
TURNS = "of the unit quaternion that turns body axes into space axes, at the end"
ORIENTATION: dict[str, ColumnForm] = {
    **{f"orientation_{part}_end": (np.nan, ONE, f"{part} {TURNS}") for part in "wxyz"},
    "psi_end": (np.nan, RADIAN, f"{PSI}; at the end"),
}
"""Columns of the orientation at the end, where it is wanted."""


def own_quantities(system: System) -> list[Quantity]:
    """Return the user-defined numbers of a system, whose values at the end are columns.

    Those with `meanings` (words) are not numbers.
    """
    return [q for q in system.quantities if owner(q.formula) and not q.meanings]


def columns_of(system: System) -> dict[str, ColumnForm]:
    """Return the columns of ensembles of a system.

    Those of a gliding body are always among them, whether it has these events or not: stores of
    sweeps, and the arrays that `lanes._write` and `hybrid_tops` fill, have these names.
    """
    count = (np.int32(0), ONE)
    time = (np.nan, SECOND)
    kept = [kept for event in (*EVENTS, *system.events) for kept in event.kept]
    watched = {event.extremes for event in system.events} - {"", "normal_force"}
    return {
        "t_end": (*time, "end of the run"),
        "theta_end": (np.nan, RADIAN, "inclination at the end"),
        **{k.name: (*(count if k.what == "count" else time), k.long_name) for k in kept},
        "turnings": (*count, "turning angles that are more than rounding"),
        "theta_min": (np.nan, RADIAN, "lowest turning angle"),
        "theta_max": (np.nan, RADIAN, "highest turning angle"),
        "normal_force_min": (np.nan, NEWTON, "least normal force"),
        "normal_force_max": (np.nan, NEWTON, "greatest normal force"),
        "steps": (*count, "steps of the integrator"),
        **{
            f"{q.name}_{end}": (np.nan, q.unit, f"{word} {q.long_name}")
            for q in system.quantities
            if q.name in watched
            for end, word in (("min", "least"), ("max", "greatest"))
        },
        **{
            f"{q.name}_end": (np.nan, q.unit, f"{q.long_name}; at the end")
            for q in own_quantities(system)
        },
    }


class Outcomes:
    """The results of an ensemble, as arrays (n,) with one element per top, and its cost.

    `ensemble.measure` makes it; threads write the elements of different tops. `columns`, described
    by `forms`, are internal until `_conclude`; `rows`, (n, k, variables), and `final`,
    (variables, n), remain internal. `kind` is the class, an index of CLASSES, and `status` a code
    of `Status`, an index of STATUSES.
    """

    def __init__(self, tops: Problems, lyapunov: bool = False, times: np.ndarray | None = None):
        """Allocate the results, NaN where a top has not ended; invalid tops have a status."""
        self.tops = tops
        n = tops.n
        # internal times of rows, ascending (n, k), and their states, NaN where a top has none
        self.times = np.zeros((n, 0)) if times is None else times
        self.rows = np.full((*self.times.shape, len(tops.start)), np.nan)
        self.forms = columns_of(tops.base.system) | (ORIENTATION if tops.orientation else {})
        if lyapunov:
            self.forms[LYAPUNOV] = np.nan, PER_SECOND, "finite-time Lyapunov exponent of the run"
        self.status = np.where(tops.valid, 0, Status.INVALID.code).astype(np.int8)
        self.kind = np.zeros(n, np.int8)
        self.columns = {name: np.full(n, empty) for name, (empty, *_) in self.forms.items()}
        self.final = np.full((len(tops.start), n), np.nan)
        self.settled = np.zeros(n, bool)
        self.lasts_since = np.full(n, np.nan)  # of tops in lanes, as in their tallies
        # `look` compares states with the start; `begin` sets the starts of tops with phases
        drift = Drift(tops, tops.start, tops.valid)
        self.look, self.begin = drift.look, drift.begin
        self.drift = drift.worst
        # of tops that turned out to be invalid when they were begun
        self.faults: list[tuple[int, str]] = []
        # zeros of event functions that lanes found, rows and states; and the events of tops
        self.passages: list[tuple[np.ndarray, np.ndarray]] = []
        self.events: dict[int, EventTable] = {}
        self.occupancy = 1.0  # of the lanes of tops whose contact may change
        self.seconds = self.processor = 0.0  # by the wall clock, and of the processor

    def refuse(self, top: int, sentence: str) -> None:
        """Mark the top of this number as invalid, and store the reason as a sentence.

        Tops that `Problems.checked` finds invalid are not among these `faults`; `dataset` joins
        both.
        """
        self.status[top] = Status.INVALID.code
        self.faults.append((top, sentence))


def _conclude(outcomes: Outcomes) -> None:
    """Compute theta at the end and the class of each top from its end, and convert to SI, in place.

    It must be called once, when all tops have ended: a second call would convert again.
    """
    tops = outcomes.tops
    columns = outcomes.columns
    for name, (empty, unit, _) in outcomes.forms.items():
        if np.isnan(empty):  # times, angles and forces; counts, which begin with 0, have no unit
            columns[name] *= tops.unit(unit)
            columns[name][~np.isfinite(columns[name])] = np.nan
    ended = np.flatnonzero(np.isfinite(outcomes.final).all(axis=0))
    final = outcomes.final[:, ended]
    kind = np.full(tops.n, CLASSES.index("under-way"))
    if tops.orientation:
        for name, value in orientations_of(tops, final, ended).items():
            columns[f"{name}_end"][ended] = value
    values = values_of(tops, final, ended)
    columns["theta_end"][ended] = values["theta"]
    for q in own_quantities(tops.base.system):
        columns[f"{q.name}_end"][ended] = values[q.name] * tops.unit(q.unit)[ended]
    body = tops.body(lambda given: np.broadcast_to(given, (tops.n,))[ended])
    kind[ended] = classes_of(
        tops.base.system, values, tops.unit(SECOND)[ended], outcomes.settled[ended], body
    )
    if tops.base.on_liftoff != "fly":
        kind[np.isfinite(columns["lifted_at"])] = CLASSES.index("lifted-off")
    # an ENDED contact could not be followed further: that is no fate
    no_fate = Status.ENDED if tops.base.contact is not None else None
    ordinary = [status.code for status in Status if status.ordinary and status is not no_fate]
    sound = np.isin(outcomes.status, ordinary)
    outcomes.kind[:] = np.where(sound, kind, CLASSES.index("none"))


def dataset(outcomes: Outcomes) -> "xr.Dataset":
    """Return the rows as a labelled Dataset, dimension `top`, with the scenario as attributes.

    `library.ensemble` returns it to users. The varied numbers are coordinates; the first 20 faults
    are an attribute.
    """
    import xarray as xr

    columns = table(outcomes)
    tops = outcomes.tops
    faults = [*tops.checked[1], *outcomes.faults]
    rules = tops.base.rules
    coords = {
        key: column(values, rules[key].unit, rules[key].long_name, ("top",))
        for key, values in tops.columns.items()
    }
    attrs = {
        "title": tops.base.system.title,
        **build.resolved(tops.base),
        "seconds": outcomes.seconds,
        "processor_seconds": outcomes.processor,
        "faults": [f"top {i}: {sentence}" for i, sentence in faults[:20]],
    }
    return xr.Dataset(columns, coords, plain_attributes(attrs))


def table(outcomes: Outcomes) -> dict[str, Column]:
    """Return the rows as columns along `top`, by name, SI; for outcomes of `ensemble.measure`."""
    given = {name: (outcomes.columns[name], *form[1:]) for name, form in outcomes.forms.items()}
    for name, worst in outcomes.drift.items():
        given[f"drift_{name}"] = worst, ONE, f"worst relative drift: {name}"
    status = flag_attributes(STATUSES, "how the run ended")
    kind = flag_attributes(CLASSES, "what became of the top")
    return {
        "status": Column(("top",), outcomes.status, status),
        "class": Column(("top",), outcomes.kind, kind),
        **{
            name: Column(("top",), values, {"units": unit.symbol, "long_name": text})
            for name, (values, unit, text) in given.items()
        },
    }
