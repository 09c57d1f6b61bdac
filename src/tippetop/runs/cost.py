"""What a run costs: an estimate, a measurement of its first slices, and a warning while it runs."""

import math
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from ..engine.taylor import driver_of
from ..mechanics.contact.body import angular_velocity
from ..mechanics.contact.disc_at_rest import turning
from ..mechanics.contact.gliding.vector import axis, momentum
from ..mechanics.contact.response import mobility
from ..mechanics.contact.single_contact import RESTS_BELOW
from ..mechanics.contact.state import Row
from ..mechanics.disc_friction import drilling_torque, inside
from ..mechanics.friction import is_frictionless
from ..mechanics.units import SECOND
from ..problem import Problem
from ..progress import Bar
from .integration import Integration
from .reporting import RunProgress, report
from .sinks import Memory


# --- an estimate --------------------------------------------------------------------------------

STEPS_PER_RADIAN = {
    "double": 0.9,
    "longdouble": 0.9,
    "quad": 0.85,
}  # measured: canonical inversion, 1337 steps in 8 s
MICROSECONDS_PER_STEP = {
    "double": 2.0,
    "longdouble": 35.0,
    "quad": 900.0,
}  # two shared cores of an AMD EPYC
MORE_STEPS = 1.4  # where friction drills: its force bends at w = U, and a stem brings impacts
# a step of these equations, which are not optimised, than one of others; measured: 23 to 35 us,
# idle
DEARER = 15.0
SPAN = 9.0  # of a step in the time of friction's slowest decay; measured: 8 to 11
# of the time to rest that drilling alone would take: sliding takes of the spin too; measured: 0.4
# to 2
SHARE = 0.5


def drilling(problem: Problem) -> tuple[float, float]:
    """When a disc comes to rest [s], and how many steps its stiff friction takes until then, or
    until the end.

    While it hardly slides, friction is viscous with the rate 3 pi mu g/(8 patch |Omega_z|) times m
    K, and its torque takes of Omega_z what is proportional to time: 2 m K I/(m patch^2) of these
    rates pass while it falls to 1/e.
    """
    q, body = Row._make(problem.start()[: len(Row._fields)]), problem.internal_body
    law, second = body.friction, float(problem.scales.of(SECOND))
    u = axis(q)
    turn = max(abs(float(angular_velocity(u, momentum(q), body).z)), RESTS_BELOW)
    drag, weight = inside(0.0, float(law.patch * turn) ** 2), float(body.m * body.g)
    slowing = -float(drilling_torque(weight, turn, drag, law.mu, law.patch) * turning(u, body).own)
    if slowing == 0:  # mu = 0: the disc does not slow the spin
        return math.inf, 0.0
    rate = float(law.mu * weight * drag.k * mobility(math.sin(math.acos(u.z)), u.z, body).ee)
    rest = SHARE * turn / slowing
    left = max(turn * (1 - problem.until / second / rest), RESTS_BELOW)
    steps = rate * turn / (SPAN * slowing) * math.log(turn / left)
    return rest * second, steps


def estimate(problem: Problem) -> dict[str, float]:
    """Return orders of magnitude: a step spans about a radian of the fastest angle, or see
    `drilling`.
    """
    rates = (
        problem.initial.get("omega3", problem.initial.get("psi_dot", 0.0)),
        problem.initial.get("phi_dot", 0.0),
    )
    fastest = max(*(abs(float(r)) for r in rates), 1.0 / float(problem.scales.of(SECOND)))
    steps, dearer = problem.until * fastest * STEPS_PER_RADIAN[problem.precision], 1.0
    if problem.law.regions and not is_frictionless(problem.friction):
        until, stiff = drilling(problem)
        rests = (
            max(0.0, problem.until - until)
            / float(problem.scales.of(SECOND))
            * STEPS_PER_RADIAN[problem.precision]
        )
        steps, dearer = MORE_STEPS * steps * min(1.0, until / problem.until) + stiff + rests, DEARER
    return {
        "steps": round(steps),
        "seconds": round(steps * MICROSECONDS_PER_STEP[problem.precision] * dearer * 1e-6, 4),
        "megabytes": round(len(problem.times) * 8 * 24 / 1e6, 3),
    }


# --- a measurement ------------------------------------------------------------------------------

STEPS = 512  # of a slice
ROWS = 100_000  # of a slice, roughly
FEWEST = 10  # steps of a slice
WORTH = 0.2  # [s] of computing from which the rest is inferred


def measured(problem: Problem, clock: Callable[[], float] = time.perf_counter) -> dict[str, float]:
    """Return the steps and seconds of a run, from its first slices, and the seconds of compiling
    it.

    Parameters
    ----------
    problem
        The run.
    clock
        Seconds.

    Returns
    -------
    dict
        `steps` and `seconds` of the whole run, in memory; `compiling`, the seconds that compiling
        took now: the integrator is kept on disk. Where friction drills, the first slices show how
        long a step takes, but not how many there are: the estimate counts.
    """
    expected = max(float(estimate(problem)["steps"]), 1.0)
    size = max(FEWEST, min(STEPS, int(ROWS * expected / max(len(problem.times), 1))))
    began = clock()
    if problem.system.is_hybrid:  # later phases would be compiled on the way
        driver_of(problem).prepare()  # type: ignore[attr-defined]  # it is a ContactDriver
    _timed(problem, size, 0.0, clock)
    compiled = clock() - began
    seconds, progress = _timed(problem, size, WORTH, clock)
    steps, whole = progress.steps, 1.0
    if progress.status is None:
        rest = expected / steps if problem.law.regions else problem.until / progress.t_end
        whole = max(1.0, rest)
    return {
        "steps": round(steps * whole),
        "seconds": round(seconds * whole, 4),
        "compiling": round(max(compiled - seconds * min(1.0, size / max(steps, 1)), 0.0), 2),
    }


def _timed(
    problem: Problem, size: int, worth: float, clock: Callable[[], float]
) -> tuple[float, RunProgress]:
    """Return how long the first slices of a run take, with their rows as columns, and how far they
    come.
    """
    began = clock()
    integration, memory = Integration(problem), Memory()

    def more() -> bool:
        while memory.times:
            integration.view.columns(memory.times.pop(), memory.states.pop())
        return integration.fresh or clock() - began < worth

    integration.part(memory, size, more)
    more()
    return clock() - began, integration.progress()


# --- a warning ----------------------------------------------------------------------------------

LONG = 600.0  # [s] that are left: from there on there is a sentence
WAITED = 30.0  # [s] of computing without a word: from there on so much that is left is long
AGAIN_AFTER = 3.0  # [s] of computing from which the rest is inferred
AGREED = 3  # times in a row: what one of them compiled, or another program took, is not the run's
SHORT = 0.02  # of a radian of the fastest angle: steps that spin alone does not need
OFTEN = 0.2  # phases of the contact a step: they make the steps short


class Patience:
    """A progress callback, which says once that the rest of a run will take long.

    Parameters
    ----------
    say
        Takes the sentence.
    clock
        Seconds.
    """

    def __init__(self, say: Callable[[str], object], clock: Callable[[], float] = time.monotonic):
        self.say, self.clock = say, clock
        self.since: tuple[float, float, int, int] | None = (
            None  # clock, time of the run, steps, phases of the contact
        )
        self.began = clock()
        self.inferred: list[float] = []  # [s], long ones in a row

    def __call__(self, progress: RunProgress) -> None:
        """Infer the rest from the slices since the last look."""
        if len(self.inferred) == AGREED:
            return
        changes = 0 if progress.phases is None else sum(progress.phases["counts"].values())
        now = self.clock(), progress.t_end, progress.steps, changes
        if self.since is None:
            self.since, self.began = now, now[0]
        seconds, advance, steps, phases = (b - a for a, b in zip(self.since, now, strict=True))
        if seconds < AGAIN_AFTER:
            return
        self.since = now
        left = seconds * (progress.problem.until - now[1]) / max(advance, 1e-300)
        long = LONG if now[0] - self.began < WAITED else min(LONG, WAITED)
        self.inferred = [*self.inferred, left] if left > long else []
        if len(self.inferred) == AGREED:
            often = phases > OFTEN * steps
            self.say(sentence(progress.problem, min(self.inferred), advance / max(steps, 1), often))


def warn(words: str) -> None:
    """Issue a warning to callers from Python."""
    warnings.warn(words, stacklevel=2)


@contextmanager
def following(
    say: Callable[[str], object] = warn, *, bar: bool = True
) -> Iterator[Callable[[RunProgress], None]]:
    """Provide a run's progress callback: it warns of a long run, and draws a bar in a terminal."""
    patience = Patience(say)
    if not bar:
        yield patience
        return

    def note(progress: RunProgress) -> str:
        facts = report(progress)
        drift = max(facts["drift"].values(), default=0.0)
        turnings = facts["event_counts"].get("turning", 0)
        return f"theta {facts['theta_end']:.4f}, {turnings} turnings, drift {drift:.0e}"

    def follow(progress: RunProgress) -> None:
        progress_bar.update(progress.t_end, progress.problem.until, lambda: note(progress))
        patience(progress)

    with Bar("s", "t = {done:.4g} s") as progress_bar:
        yield follow


def sentence(problem: Problem, left: float, step: float, often: bool = False) -> str:
    """Return that the rest of a run takes `left` [s], in steps of `step` [s], and why."""
    rates = ("omega3", "psi_dot", "phi_dot", "theta_dot")
    fastest = max(1.0, *(abs(float(problem.initial.get(name, 0.0))) for name in rates))
    why = ""
    if often:
        why = ", because the contact changes its phase about as often (contact.e_n, stem)"
    elif step * fastest < SHORT:
        keys = [f"friction.{name}" for name in problem.friction._fields]
        why = f", because friction is stiff ({', '.join(keys)})"
        if problem.law.regions:
            why = (
                ", because friction on a disc that hardly turns is stiff (friction.patch, "
                "initial.omega3)"
            )
    return (
        f"the rest of this run will take about {left:.2g} s ({left / 3600:.2g} hours): its "
        f"steps are {step:.2g} s "
        f"long{why}. Ctrl-C stops it; a store can be resumed."
    )
