"""Measure what a sweep takes on this computer: some of its tops are run, and timed."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from ..engine.status import Status
from ..errors import InputError
from ..runs import cost
from . import chunk
from .plan import Plan


BUDGET = 2.0  # [s] of computing, compilation aside, after which no further top is begun
WORTH = 0.4  # [s] of computing, roughly, from which the rest is inferred
SOME = 16  # tops, spread over the plan
WRITING = 0.03  # [s] a chunk


def measured(plan: Plan, clock: Callable[[], float] = time.process_time) -> dict[str, float]:
    """Return what a sweep takes one core, from some of its tops.

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
        now, in addition: compiled code is kept on disk; `tops_measured`, from how many tops
        this is inferred: none if all were invalid.
    """
    chosen = np.unique(np.linspace(0, plan.n - 1, SOME).round().astype(int))
    measure = _one_by_one if plan.base.system.is_hybrid else _in_lanes
    of_chunk, of_top, compiling, tops = measure(plan, chosen, clock)
    return {
        "core_seconds": round(plan.chunks * (WRITING + of_chunk) + plan.n * of_top, 3),
        "compiling": round(max(compiling, 0.0), 2),
        "tops_measured": tops,
    }


def _in_lanes(
    plan: Plan, chosen: np.ndarray, clock: Callable[[], float]
) -> tuple[float, float, float, int]:
    """Return seconds of a chunk, of a top and of compiling, from parts of some runs."""
    numbers = plan.columns(chosen)
    until = np.broadcast_to(numbers.get("run.until", plan.base.until), chosen.shape)

    def piece(share: float) -> tuple[float, Any]:
        began = clock()
        outcomes = chunk.measure(plan.base, numbers | {"run.until": share * until}, plan.keep)
        return clock() - began, outcomes

    share = min(1.0, WORTH / (plan.seconds_per_top * len(chosen)))
    first, _ = piece(share / 100)  # which compiles
    fixed, _ = piece(share / 100)
    seconds, outcomes = piece(share)
    steps = outcomes.columns["steps"]
    ran = outcomes.status != Status.INVALID.code
    whole = np.where(outcomes.status == Status.FINISHED.code, steps / share, steps)
    longer = whole[ran].sum() / max(steps[ran].sum(), 1)
    of_top = max(seconds - fixed, 0.0) * longer / len(chosen)
    return fixed, of_top, first - fixed, int(ran.sum())


def _one_by_one(
    plan: Plan, chosen: np.ndarray, clock: Callable[[], float]
) -> tuple[float, float, float, int]:
    """Return the same of tops whose contact may change its phase, which lanes cannot follow."""
    found: list[dict[str, float]] = []
    begun, began = 0, clock()
    # in an order that is spread over the plan wherever it stops
    for top in sorted(chosen.tolist(), key=lambda top: f"{top:032b}"[::-1]):
        if clock() - began - sum(each["compiling"] for each in found) > BUDGET:
            break
        begun += 1
        try:
            problem = plan.problem(top)
        except InputError:
            continue
        found.append(cost.measured(problem, clock))
    seconds, compiling = (sum(each[key] for each in found) for key in ("seconds", "compiling"))
    return 0.0, seconds / max(begun, 1), compiling, len(found)
