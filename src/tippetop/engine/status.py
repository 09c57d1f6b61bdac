"""How a run ended."""

from enum import Enum


class Status(Enum):
    """How a run ended. All are ordinary ends but NON_FINITE and STALLED."""

    FINISHED = "finished"
    LIFTOFF = "liftoff"
    FALLEN = "fallen"
    NON_FINITE = "non-finite"
    STALLED = "stalled"
    SETTLED = "settled"
    RUNNING = "running"  # a store that is being written, or waits for `tippetop resume`


SETTLED_FOR = 200.0  # internal units: how long sliding must have been dead before `stop_when = "settled"` stops a run
