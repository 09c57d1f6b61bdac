"""When a run has settled, and what has become of it: near a pole that is unstable a motion is still
under way.
"""

from typing import Any

import numpy as np

from ..mechanics.contact.body import Touch
from ..mechanics.contact.state import BALLS, PHASES
from ..mechanics.friction import has_parts, takes_nothing
from ..mechanics.operand import leaves, refill
from ..mechanics.system import System
from ..mechanics.theory.modes import LINEAR, SLIDES, is_unstable, shows_sliding, will_leave
from ..problem import Problems


# internal units: how long sliding must have been dead before `stop_when = "settled"` stops a run
SETTLED_FOR = 200.0


def stays(body: Any, values: dict[str, np.ndarray], second: float) -> bool:
    """Return whether a motion without sliding lasts; a top near an unstable pole will leave it.

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
        True also for a body whose stability is unknown.

    Notes
    -----
    The body in SI units; values are those of one state, (1,) each, in internal units, of which a
    time is `second` [s]. A motion in a plane has no spin, hence no pole that it could leave.
    """
    if not isinstance(body, Touch) or "omega3" not in values:
        return True
    theta, omega3 = float(values["theta"][0]), float(values["omega3"][0]) / second
    return bool(shows_sliding(body, np.cos(theta))) and not will_leave(theta, omega3, body)


def slides(problems: Problems, states: np.ndarray, which: Any) -> np.ndarray:
    """Return whether contacts slide faster than a settled motion may, (k,): a law may take little
    in fast sliding.

    Parameters
    ----------
    problems
        The runs.
    states
        (variables, k), internal units.
    which
        Numbers of the runs, (k,).
    """
    body = problems.body_of_pars(problems.pars[:, which].astype(float))
    if not isinstance(body, Touch):
        return np.zeros(states.shape[1], bool)
    with np.errstate(all="ignore"):  # of tops beyond the doubles
        scalars = problems.base.form.scalars(problems.record(states.astype(float)), body)
        v2 = getattr(scalars, "v2", 0.0)  # a tip that is held has none
        fast = v2 > SLIDES**2 * body.g * (body.R + np.abs(body.c))
    return np.broadcast_to(fast, states.shape[1])


CLASSES = (
    "none",
    "upright",
    "tumbling",
    "inverted",
    "lifted-off",
    "under-way",
    "rolling",
    "on-stem",
    "bouncing",
    "nutating",
    "at-rest",
)
"""Fates of a top, by number in a store."""

RATES = ("omega3", "theta_dot", "phi_dot", "nu_x", "nu_y")
# Rates, in internal units, of a body that torques have brought to rest: they are smooth below 1e-6
STILL = 1e-5
NEAR = 0.1  # rad from a pole: upright or inverted


def fates(
    system: System, omega3: np.ndarray, settled: np.ndarray, body: Any, values: dict[str, Any]
) -> np.ndarray:
    """Return the fates of tops that have not lifted off, as numbers of CLASSES, (n,).

    Parameters
    ----------
    system, omega3, settled, body
        As `classes_of` takes them.
    values
        The quantities at the end by name, (n,) each, internal units.
    """
    theta = values["theta"].astype(float)
    kinds = with_phases(classes_of(system, theta, omega3, settled, body), theta, values)
    if isinstance(body, Touch) and has_parts(body.friction):
        rates = [np.nan_to_num(values[name].astype(float)) for name in RATES if name in values]
        still = np.abs(rates).max(axis=0) < STILL
        kinds = np.where(still, CLASSES.index("at-rest"), kinds)
    return kinds


def classes_of(system: System, theta: Any, omega3: Any, settled: Any, body: Any) -> np.ndarray:
    """Return the fates of tops that have not lifted off, as numbers of CLASSES, (n,).

    Upright and inverted is a top within 0.1 rad of a pole, if that spin is stable: else it is under
    way, for it will leave. Tumbling is one in which nothing slides any more. Without friction a
    motion ends nowhere: it nutates. Under rolling resistance or a drilling torque no spin lasts,
    and every top is under way.

    Parameters
    ----------
    system
        Its `classes` are the names that apply.
    theta, omega3
        At the end, (n,) [rad, rad/s].
    settled
        Whether sliding has died out for good, (n,).
    body
        The bodies in SI, with numbers (n,); a record other than that of a sphere or a heavy top has
        no modes.
    """
    known = isinstance(body, Touch)
    if known and has_parts(body.friction):
        return np.full(len(theta), CLASSES.index("under-way"))
    if known and system.frictional:
        settled = settled & shows_sliding(body, np.cos(theta))
    ends = {"tumbling": settled, "upright": theta < NEAR, "inverted": theta > np.pi - NEAR}
    kinds = np.full(len(theta), CLASSES.index("under-way"))
    for name in system.classes:
        kinds[ends[name]] = CLASSES.index(name)
    for name, inverted in (("upright", False), ("inverted", True)):
        if name not in system.classes or not known or not ends[name].any():
            continue
        here = np.flatnonzero(ends[name])
        some = refill(body, (np.broadcast_to(x, theta.shape)[here] for x in leaves(body)))
        leaves_it = here[
            is_unstable(omega3[here], some, inverted=inverted, gliding=system.frictional)
        ]
        away = np.minimum(theta[leaves_it], np.pi - theta[leaves_it]) >= LINEAR
        tumbles = settled[leaves_it] & away if "tumbling" in system.classes else np.zeros_like(away)
        kinds[leaves_it] = np.where(tumbles, CLASSES.index("tumbling"), CLASSES.index("under-way"))
    if known and system.frictional:
        kinds[np.broadcast_to(takes_nothing(body.friction), theta.shape)] = CLASSES.index(
            "nutating"
        )
    return kinds


def with_phases(kinds: np.ndarray, theta: Any, values: dict[str, np.ndarray]) -> np.ndarray:
    """Return the fates of tops whose contact may change its phase, as numbers of CLASSES, (n,).

    Parameters
    ----------
    kinds
        As `classes_of` gives them.
    theta
        At the end, (n,) [rad]: a body that rolls is in steady spin only at a pole, and
        never in the air.
    values
        The quantities `phase` and `ball` at the end by name, (n,) each, where the system has them.
    """
    if "phase" not in values:
        return kinds
    phase, on_stem = values["phase"], values["ball"] == BALLS.index("stem")
    flies = phase == PHASES.index("flight")
    away = np.minimum(theta, np.pi - theta) >= LINEAR
    at_rest = (phase == PHASES.index("roll")) | (phase == PHASES.index("rest"))
    rolls = at_rest & (away | (kinds == CLASSES.index("under-way")))
    kinds = np.where(rolls, CLASSES.index("rolling"), kinds)
    kinds = np.where(on_stem, CLASSES.index("on-stem"), kinds)
    return np.where(flies, CLASSES.index("bouncing"), kinds)
