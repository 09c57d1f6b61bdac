"""What a sweep takes on the computer at hand: some of its tops are run, and timed."""

import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..engine.status import Status
from ..errors import InputError
from ..runs import cost
from . import chunk
from .plan import MICROSECONDS_PER_STEP, Plan


BUDGET = 2.0  # [s] of computing, compilation aside, after which no further top is begun
WORTH = 0.2  # [s] from which the rest is inferred
SOME = 16  # tops, spread over the plan
FIRST_STEPS = 100.0  # of a top in the first piece, roughly
WRITING = 0.03  # [s] a chunk


class _Cost(NamedTuple):
    """Seconds a chunk, whatever is in it, a top, and of compiling; how many tops they are inferred
    from.
    """

    chunk: float
    top: float
    compiling: float
    tops: int


def measured(plan: Plan, clock: Callable[[], float] = time.process_time) -> dict[str, float]:
    """What a sweep takes one core, from some of its tops.

    Parameters
    ----------
    plan
        The sweep.
    clock
        Seconds of a processor.

    Returns
    -------
    dict
        `core_seconds` of the whole sweep on one core; `compiling`, the seconds that compiling took
        now, beside them: what was compiled is kept on disk; `tops_measured`, from how many tops
        this is inferred: none if all were invalid.
    """
    chosen = np.unique(np.linspace(0, plan.n - 1, SOME).round().astype(int))
    of_top = (_alone if plan.base.system.is_hybrid else _in_lanes)(plan, chosen, clock)
    return {
        "core_seconds": round(plan.chunks * (WRITING + of_top.chunk) + plan.n * of_top.top, 3),
        "compiling": round(max(of_top.compiling, 0.0), 2),
        "tops_measured": of_top.tops,
    }


def _in_lanes(plan: Plan, chosen: np.ndarray, clock: Callable[[], float]) -> _Cost:
    """From growing parts of the runs of some tops."""
    numbers = plan.columns(chosen)
    until = np.broadcast_to(numbers.get("run.until", plan.base.until), (len(chosen),))

    def piece(share: float) -> tuple[float, Any]:
        began = clock()
        outcomes = chunk.measure(plan.base, numbers | {"run.until": share * until}, plan.keep)
        return clock() - began, outcomes

    share = min(1.0, FIRST_STEPS * 1e-6 * MICROSECONDS_PER_STEP / plan.seconds_per_top)
    first, _ = piece(share / FIRST_STEPS)  # which compiles
    fixed, _ = piece(share / FIRST_STEPS)
    while True:
        seconds, outcomes = piece(share)
        if share >= 1.0 or seconds - fixed >= WORTH:
            break
        share = min(1.0, share * min(8.0, max(2.0, WORTH / max(seconds - fixed, 1e-3))))
    steps, ran = outcomes.columns["steps"], outcomes.status != Status.INVALID.code
    underway = outcomes.status == Status.FINISHED.code
    whole = np.where(underway, steps / share, steps)[ran].sum() / max(steps[ran].sum(), 1)
    return _Cost(
        fixed, max(seconds - fixed, 0.0) * whole / len(chosen), first - fixed, int(ran.sum())
    )


def _alone(plan: Plan, chosen: np.ndarray, clock: Callable[[], float]) -> _Cost:
    """From tops whose contact may change its phase: lanes cannot follow them, so they are run one
    after the other.
    """
    seconds: list[float] = []
    compiling, begun, began = 0.0, 0, clock()
    for top in sorted(
        chosen.tolist(), key=lambda top: f"{top:032b}"[::-1]
    ):  # from all of the plan, wherever it stops
        if clock() - began - compiling > BUDGET:
            break
        begun += 1
        try:
            problem = plan.problem(top)
        except InputError:
            continue
        result = cost.measured(problem, clock)
        seconds.append(result["seconds"])
        compiling += result["compiling"]
    return _Cost(0.0, sum(seconds) / max(begun, 1), compiling, len(seconds))
