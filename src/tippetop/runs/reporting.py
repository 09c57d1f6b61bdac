"""How far a run has come, as an immutable record, and what is reported of it: measurements,
outcome, reason.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from ..engine.driver import Extremes
from ..engine.observables import Observables
from ..engine.settling import CLASSES, classes_of, with_phases
from ..engine.status import Status
from ..mechanics.caching import cached_property
from ..mechanics.event import Event
from ..mechanics.friction import has_parts
from ..mechanics.units import NEWTON, SECOND
from ..problem import Problem
from ..scenario.identity import is_user_defined
from .event_log import LogReport


STILL = 1e-5
"""Internal velocity of a body that torques have brought to rest: they are smooth below 1e-6."""


@dataclass(frozen=True)
class RunProgress:
    """How far a run has come: the record that sinks, progress callbacks and reports take.

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
        Of each invariant, the largest relative deviation from its start.
    force
        Extremes of the normal force, internal.
    events
        Counts and kept numbers.
    phases
        The phases of a contact that may change them.
    sentence
        Why the contact ended the run, if it did.
    compiled
        Whether the compiled loop makes the steps.
    """

    problem: Problem
    status: Status | None
    t_end: float
    steps: int
    last: np.ndarray
    drift: dict[str, float]
    force: Extremes
    events: LogReport
    phases: dict[str, Any] | None
    sentence: str
    compiled: bool

    def __getstate__(self) -> dict[str, Any]:
        return {each.name: getattr(self, each.name) for each in fields(self)}

    @cached_property
    def view(self) -> Observables:
        """What evaluates its states."""
        return Observables(self.problem)

    @property
    def settled_since(self) -> float | None:
        """When sliding ended [s], if it is still over."""
        return self.events.settled_since(self.view, self.last)

    @property
    def lifted_at(self) -> float | None:
        """When the body lifted off [s], if it did."""
        return self.events.kept().get("lifted_at")


def report(progress: RunProgress) -> dict[str, Any]:
    """Return the measured part of `info --json`, as far as the run has come."""
    by_heyoka = not progress.compiled and progress.problem.precision == "double"
    return {
        "t_end": progress.t_end,
        "steps": progress.steps,
        "drift": progress.drift,
        **_normal_force(progress),
        **progress.events.report(),
        "theta_end": progress.view.theta(progress.last),
        **({} if progress.phases is None else {"contact_phases": progress.phases}),
        **({"steps_by": "heyoka"} if by_heyoka else {}),
        **outcome(progress),
    }


def _normal_force(progress: RunProgress) -> dict[str, Any]:
    """Return the extremes of the normal force; empty without such a force."""
    force, problem = progress.force, progress.problem
    if not math.isfinite(force.least):
        return {}
    newton, second = (float(problem.scales.of(unit)) for unit in (NEWTON, SECOND))
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
    system, view = progress.problem.system, progress.view
    if progress.sentence or not (system.inverts and system.classes):
        return {}
    if progress.lifted_at is not None and progress.problem.on_liftoff != "fly":
        return {"outcome": "lifted-off"}
    values = view.evaluate(progress.last)
    theta, omega3 = (values[name].astype(float) for name in ("theta", "omega3"))
    settled = np.array([progress.settled_since is not None])
    second = float(progress.problem.scales.of(SECOND))
    kinds = classes_of(system, theta, omega3 / second, settled, progress.problem.body())
    name = CLASSES[with_phases(kinds, theta, values)[0]]
    speeds = [
        values[one] for one in ("omega3", "theta_dot", "phi_dot", "nu_x", "nu_y") if one in values
    ]
    at_rest = np.nanmax(np.abs(np.array(speeds, float))) < STILL
    return {} if at_rest and has_parts(progress.problem.friction) else {"outcome": name}


def reason(progress: RunProgress) -> str:
    """Return the sentence that the user reads about the end."""
    t = progress.t_end
    if progress.status is None:
        return f"interrupted or running: t = {t:.6g} s of {progress.problem.until:.6g} s"
    if progress.sentence:
        return f"{progress.sentence}: stopped at t = {t:.9g} s; the last good state is kept"
    return REASONS[progress.status](progress)


def _finished(progress: RunProgress) -> str:
    return f"finished at t = {progress.t_end:.6g} s{_beyond(progress)}"


def _settled(progress: RunProgress) -> str:
    t, since = progress.t_end, progress.settled_since
    return (
        f"settled: sliding died at t = {since:.6g} s, stopped at t = {t:.6g} s{_beyond(progress)}"
    )


def _beyond(progress: RunProgress) -> str:
    """Return that the run continued after a liftoff, where the model ends (a fixed tip
    holds on).
    """
    events, lifted = progress.problem.system.events, progress.lifted_at
    if lifted is None or not any(event.ends == Status.LIFTOFF.value for event in events):
        return ""
    return f", but outside the model since the liftoff at t = {lifted:.9g} s"


def _lifted(progress: RunProgress) -> str:
    if own := _own_ending(progress):
        return own
    if progress.t_end == 0:
        return "the body lifts off at the start (g_n < 0): the model does not hold there"
    return f"the body lifted off at t = {progress.t_end:.9g} s (g_n = 0): the model ends there"


def _fallen(progress: RunProgress) -> str:
    fallen = f"the top fell at t = {progress.t_end:.9g} s (theta = pi/2): the plane is in its way"
    return _own_ending(progress) or fallen


def _ended(progress: RunProgress) -> str:
    name = _endings(progress)[0].long_name
    return f"an event of the system ended the run at t = {progress.t_end:.9g} s: {name}"


def _endings(progress: RunProgress) -> list[Event]:
    """Return the events that end a run with this status."""
    events = progress.problem.system.events
    return [e for e in events if e.ends and Status.of_event(e.ends) is progress.status]


def _own_ending(progress: RunProgress) -> str:
    """Return a sentence on the user-defined event that ended the run: the nearest to its zero.

    Empty if none did.
    """
    events = _endings(progress)
    if not any(_is_given(event) for event in events):
        return ""
    state, body = progress.view.moment(progress.last), progress.view.body
    last = min(events, key=lambda event: abs(float(np.min(event.formula(state, body)))))
    if not _is_given(last):
        return ""
    status = Status.of_event(last.ends or "").value
    return (
        f"`{last.name}` ended the run as {status} at t = {progress.t_end:.9g} s: {last.long_name}"
    )


def _is_given(event: Event) -> bool:
    """Return whether an event was given with the run, not with its system."""
    return hasattr(event.formula, "of")


def _lost(progress: RunProgress) -> str:
    """Return why the state, or the step, could not be continued."""
    t, is_infinite = progress.t_end, progress.status is Status.NON_FINITE
    domains = progress.view.domains(progress.last)
    meaning, least = (
        min(domains.items(), key=lambda item: item[1]) if domains else ("no known cause", math.inf)
    )
    law = "the friction law is singular or too stiff (large mu, small eps)"
    if not progress.problem.system.frictional:
        law = "the equations of the system are singular or too stiff"
    stiff = f"the coordinates are regular there, so {law}"
    if any(is_user_defined(event.formula) for event in progress.problem.system.events):
        stiff += ", or the formula of an event of yours is singular"
    if t == 0 and is_infinite:
        stiff += ", or a number of the start, the body or the law is too large"
    what = "the state is not finite after" if is_infinite else "the step size vanishes at"
    return (
        f"{what} t = {t:.9g} s: {meaning if least < 1e-3 else stiff}. The last good state is kept."
    )


REASONS: dict[Status, Callable[[RunProgress], str]] = {
    Status.FINISHED: _finished,
    Status.SETTLED: _settled,
    Status.LIFTOFF: _lifted,
    Status.FALLEN: _fallen,
    Status.ENDED: _ended,
    Status.NON_FINITE: _lost,
    Status.STALLED: _lost,
}
"""The sentence on each end of a run."""
