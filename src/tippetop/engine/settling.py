"""When a run has settled: nothing has slid for long, and the motion that is left is one that stays."""

from typing import Any

import numpy as np

from ..mechanics.contact.body import Body
from ..mechanics.theory.modes import will_leave


SETTLED_FOR = 200.0  # internal units: how long sliding must have been dead before `stop_when = "settled"` stops a run


def stays(body: Any, values: dict[str, np.ndarray], second: float) -> bool:
    """Whether a motion in which nothing slides stays what it is; a top near a pole that is unstable will leave it.

    Parameters
    ----------
    body
        The body, SI.
    values
        theta [rad] and omega3 [internal units] of one state by name, (1,) each.
    second
        Internal unit of time [s].

    Returns
    -------
    bool
        True also where the body is none that this knows of.

    Notes
    -----
    The body in SI units; values are those of one state, (1,) each, in internal units, of which a time is `second` [s].
    A motion in a plane has no spin, hence no pole that it could leave.
    """
    if not isinstance(body, Body) or "omega3" not in values:
        return True
    return not will_leave(float(values["theta"][0]), float(values["omega3"][0]) / second, body)
