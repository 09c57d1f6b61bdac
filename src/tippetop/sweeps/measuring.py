"""Estimate the cost of a sweep on this computer by timing some of its tops.

A `Plan` goes in; seconds come out.
"""

import time
from collections.abc import Callable

import numpy as np

from ..engine.status import Status
from ..sampling import spread
from . import chunk
from .plan import Plan


WORTH = 0.4  # [s] of computing, roughly, from which the rest is inferred
SOME = 16  # tops, spread over the plan
FEW = 8  # one in this many of these is run first, to compile
FULL = 0.9  # lanes that the tops of a chunk occupy, if their contact changes
WRITING = 0.03  # [s] a chunk


def measured(plan: Plan, clock: Callable[[], float] = time.process_time) -> dict[str, float]:
    """Return the cost of a sweep on one core, from parts of some of its runs.

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
    chosen = spread(plan.n, SOME)
    numbers = plan.columns(chosen)
    until = np.broadcast_to(numbers.get("run.until", plan.base.until), chosen.shape)

    # the part of each run that is computed, so that all of them take about WORTH
    share = min(1.0, WORTH / (plan.seconds_per_top * len(chosen)))
    seconds = []
    numbers = {**numbers, "run.until": share * until}
    for every in (FEW, 1):  # the first compiles
        began = clock()
        some = {key: values[::every] for key, values in numbers.items()}
        outcomes = chunk.measure(plan.base, some, plan.keep)
        seconds.append(clock() - began)
    of_top = seconds[1] / share / len(chosen)
    if plan.base.system.is_hybrid:  # so few do not fill the lanes of all phases
        of_top *= min(1.0, outcomes.occupancy / FULL)
    return {
        "core_seconds": round(plan.chunks * WRITING + plan.n * of_top, 3),
        "compiling": round(seconds[0], 2),
        "tops_measured": int((outcomes.status != Status.INVALID.code).sum()),
    }
