"""The progress of a run, as an immutable record, and its report: measurements, outcome, reason.

`Integration.progress` makes a `RunProgress`; the functions return plain data and sentences from it,
for `attributes`.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arguments import PlainData
from ..engine.driver import Extremes
from ..engine.observables import Observables
from ..engine.settling import CLASSES, classes_of
from ..engine.status import Status
from ..errors import owner
from ..mechanics.caching import cached_property
from ..mechanics.event import Event, Kept
from ..mechanics.systems.tippe_top import is_peg
from ..mechanics.units import NEWTON, SECOND
from ..problem import Problem
from .event_log import settled_since


INVERSION = ("first_equator", "last_equator", "inverted_at")
"""Kept numbers that a report lists under `inversion`."""
UNREPORTED = (*INVERSION, "equators", "lifted_at", "settled_at")
"""Kept numbers that a report does not repeat: counts, reason or `inversion` contain them."""


@dataclass(frozen=True)
class RunProgress:
    """The progress and measurements of a run, for sinks, progress callbacks and reports.

    Attributes
    ----------
    problem
        The run.
    status
        How it ended; None while it has not.
    t_end
        How far it has come [s].
    steps
        Steps of the integrator.
    last
        The last good state, (1, variables), internal.
    drift
        The largest relative deviation of each invariant from its start.
    force
        Extremes of the normal force, internal.
    counts
        Rows of the event log, by kind.
    tally
        The record of the tallies of the driver, of its one lane.
    numbers
        Each `Kept` of the events with its number so far, an internal time or a count.
    phases
        What `PhaseHistory.report` returns; None of a system without tables of phases.
    sentence
        Why the contact ended the run; empty if it did not.
    """

    problem: Problem
    status: Status | None
    t_end: float
    steps: int
    last: np.ndarray
    drift: dict[str, float]
    force: Extremes
    counts: dict[str, int]
    tally: Any
    numbers: list[tuple[Kept, float]]
    phases: PlainData | None
    sentence: str

    @cached_property
    def view(self) -> Observables:
        """Return the object that converts its states to columns."""
        return Observables(self.problem)

    @property
    def settled_since(self) -> float | None:
        """Return when sliding ended [s], if it is still over."""
        return settled_since(self.view, self.tally, self.last)

    @property
    def kept(self) -> PlainData:
        """Return the kept numbers of events by name: counts, and times [s] or None."""
        second = self.problem.unit(SECOND)
        return {
            kept.name: int(value)
            if kept.what == "count"
            else None
            if math.isnan(value)
            else value * second
            for kept, value in self.numbers
        }

    @property
    def lifted_at(self) -> float | None:
        """Return when the body lifted off [s], if it did."""
        return self.kept.get("lifted_at")


Progress = Callable[[RunProgress], None]
"""A progress callback, which is called after every slice."""


def report(progress: RunProgress) -> PlainData:
    """Return the measured part of `info --json`, as far as the run has come.

    Stores contain it as the attribute `report`, whose keys figures, pages and summaries read.
    """
    events = _events(progress)
    if is_peg(progress.problem.parameters):  # it is lowest near theta = pi
        events["inversion"]["inverted_at"] = None
    return {
        "t_end": progress.t_end,
        "steps": progress.steps,
        "drift": progress.drift,
        **_normal_force(progress),
        **events,
        "theta_end": progress.view.theta(progress.last),
        **({} if progress.phases is None else {"contact_phases": progress.phases}),
        **outcome(progress),
    }


def _events(progress: RunProgress) -> PlainData:
    """Return the entries of a report on events: counts, inversion, band, and kept numbers.

    Times are in seconds, angles in radians; None if nothing of the kind happened.
    """
    tally = progress.tally
    kept = progress.kept
    counts = {name: n for name, n in progress.counts.items() if n}
    if any(event.sense and event.name in counts for event in progress.problem.system.events):
        counts["turning_significant"] = int(tally["turnings"])
    own = {name: value for name, value in kept.items() if name not in UNREPORTED}
    return {
        "event_counts": counts,
        "inversion": {name: kept.get(name) for name in INVERSION},
        "nutational_band": {
            name: float(tally[name]) if tally["turnings"] else None
            for name in ("theta_min", "theta_max")
        },
        **({"kept": own} if own else {}),
    }


def _normal_force(progress: RunProgress) -> PlainData:
    """Return the entry `normal_force` of a report, SI; empty without such a force."""
    force = progress.force
    problem = progress.problem
    if not math.isfinite(force.least):
        return {}
    newton, second = map(problem.unit, (NEWTON, SECOND))
    return {
        "normal_force": {
            "min": force.least * newton,
            "max": force.most * newton,
            "t_min": force.t_least * second,
            "t_max": force.t_most * second,
            "weight": problem.parameters["m"] * problem.parameters["g"],
        }
    }


def outcome(progress: RunProgress) -> dict[str, str]:
    """Return the outcome, a name of CLASSES; empty for a system that friction cannot turn over."""
    problem = progress.problem
    system = problem.system
    if progress.sentence or not (system.inverts and system.classes):
        return {}
    if progress.lifted_at is not None and problem.on_liftoff != "fly":
        return {"outcome": "lifted-off"}
    values = progress.view.evaluate(progress.last)
    settled = np.array([progress.settled_since is not None])
    second = problem.unit(SECOND)
    return {"outcome": CLASSES[classes_of(system, values, second, settled, problem.body())[0]]}


def reason(progress: RunProgress) -> str:
    """Return a sentence about how and why the run ended; stores and `summary.reason` have it."""
    t = progress.t_end
    status = progress.status
    if status is None:
        return f"interrupted or running: t = {t:.6g} s of {progress.problem.until:.6g} s"
    if progress.sentence:
        return f"{progress.sentence}: stopped at t = {t:.9g} s; the last good state is kept"
    at = f"at t = {t:.9g} s"
    if status in (Status.NON_FINITE, Status.STALLED):
        return _lost(progress)
    if status is Status.FINISHED:
        return f"finished at t = {t:.6g} s{_beyond(progress)}"
    if status is Status.SETTLED:
        since = progress.settled_since
        died = f"sliding died at t = {since:.6g} s" if since else "nothing slid from the start"
        return f"settled: {died}, stopped at t = {t:.6g} s{_beyond(progress)}"
    if status is Status.LIFTOFF and progress.problem.contact is not None:
        return f'the body lifted off {at}, where `run.on_liftoff = "stop"` ends the run'
    last = _last_event(progress)
    if status is Status.ENDED:
        return f"an event of the system ended the run {at}: {last.long_name}"
    if hasattr(last.formula, "of"):  # it was given with the run, not with its system
        return f"`{last.name}` ended the run as {status.value} {at}: {last.long_name}"
    if status is Status.FALLEN:
        return f"the top fell {at} (theta = pi/2): the plane is in its way"
    if t == 0:
        return "the body lifts off at the start (g_n < 0): the model is not valid there"
    return f"the body lifted off {at} (g_n = 0): the model ends there"


def _beyond(progress: RunProgress) -> str:
    """Return a clause if the run continued after a liftoff, where the model ends; or ""."""
    lifted = progress.lifted_at
    ends = {event.ends for event in progress.problem.system.events}
    if lifted is None or Status.LIFTOFF.value not in ends:
        return ""
    return f", but outside the model since the liftoff at t = {lifted:.9g} s"


def _last_event(progress: RunProgress) -> Event:
    """Return the event that ended the run.

    Of several with its status, that whose function is nearest 0.
    """
    events = [
        event
        for event in progress.problem.system.events
        if event.ends and Status.of_event(event.ends) is progress.status
    ]
    if len(events) == 1:
        return events[0]
    state = progress.view.moment(progress.last)
    body = progress.view.body
    return min(events, key=lambda event: abs(float(np.min(event.formula(state, body)))))


def _lost(progress: RunProgress) -> str:
    """Return a sentence about why the state, or the step, could not be continued."""
    t = progress.t_end
    is_infinite = progress.status is Status.NON_FINITE
    problem = progress.problem
    domains = progress.view.domains(progress.last)
    system = problem.system
    cause = min(domains, key=lambda name: domains[name]) if domains else ""
    if not cause or not domains[cause] < 1e-3:  # coordinates are regular where domains are > 0
        law = "the friction law is singular or too stiff (large mu, small eps)"
        if not system.frictional or problem.law.set_valued or problem.law.regions:
            law = "the equations of the system are singular or too stiff"
        cause = f"the coordinates are regular there, so {law}"
        if any(owner(event.formula) for event in system.events):
            cause += ", or the formula of an event of yours is singular"
        if t == 0 and is_infinite:
            cause += ", or a number of the scenario is too large"
    what = "the state is not finite after" if is_infinite else "the step size vanishes at"
    return f"{what} t = {t:.9g} s: {cause}. The last good state is kept."
