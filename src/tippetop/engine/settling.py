"""Decide whether sliding has ended for good, and classify the final motions of tops.

States and values at the end of runs go in; out come flags and the CLASSES of tops, for `runs` (one)
and `ensembles` (many).
"""

from typing import Any

import numpy as np

from ..columns import Arrays
from ..mechanics.contact.body import BALLS, Touch, touching
from ..mechanics.contact.contact_phases import PHASES
from ..mechanics.friction import has_parts, takes_nothing
from ..mechanics.system import System
from ..mechanics.theory.modes import LINEAR, SLIDES, is_unstable, shows_sliding, will_leave
from ..mechanics.units import SECOND
from ..problem import Problem, Problems


# internal units: how long sliding must have been dead before `stop_when = "settled"` stops a run
SETTLED_FOR = 200.0


def stays(problem: Problem, values: Arrays) -> bool:
    """Return whether a motion without sliding lasts; a top near an unstable pole will leave it.

    Parameters
    ----------
    problem
        The run.
    values
        Those of `Observables.evaluate` for one state: theta [rad] and omega3 [internal units] by
        name, (1,) each, are read.

    Returns
    -------
    bool
        True also for a body whose stability is unknown. A motion in a plane has no spin, hence no
        pole that it could leave.
    """
    body = problem.body()
    if getattr(body, "around", ()):
        return False
    if not isinstance(body, Touch) or "omega3" not in values:
        return True
    theta = float(values["theta"][0])
    omega3 = float(values["omega3"][0]) / problem.unit(SECOND)
    return bool(shows_sliding(body, np.cos(theta))) and not will_leave(theta, omega3, body)


def slides(problems: Problems, states: np.ndarray, which: Any) -> np.ndarray:
    """Return whether contacts slide too fast for a settled motion, (k,).

    A small loss does not decide this alone: a law may take little energy in fast sliding.

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
        scalars = problems.base.form.scalars(
            problems.variables.split(states.astype(float))[0], body
        )
        v2 = getattr(scalars, "v2", 0.0)  # |v_A|^2; a tip that is held has none
        body = touching(scalars, body)
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
"""Fates of a top, by number in a store: a new one goes to the end."""

RATES = ("omega3", "theta_dot", "phi_dot", "nu_x", "nu_y")
# Rates, in internal units, of a body that torques have brought to rest: they are smooth below 1e-6
STILL = 1e-5
NEAR = 0.1  # rad from a pole: upright or inverted
LOST = 1e-9  # energy, internal units, that is not rounding


def classes_of(system: System, values: Arrays, second: Any, settled: Any, body: Any) -> np.ndarray:
    """Return the fates of tops that have not lifted off, as numbers of CLASSES, (n,).

    Upright and inverted is a top within 0.1 rad of a pole, if that spin is stable: else it is under
    way, for it will leave. Tumbling is one in which nothing slides any more. Without friction a
    motion ends nowhere: it nutates, unless it is that of a pole, or impacts have taken energy.
    Under rolling resistance or friction that drills no spin lasts, and every top is under way until
    it is at rest or rolls. So it is in air and on a tilted plane, where none is known to rest.

    Parameters
    ----------
    system
        Its `classes` are the names that apply.
    values
        The values at the end by name, (n,) each, internal units, as `observables.values_of` returns
        them; `phase` and `ball` are numbers of PHASES and BALLS.
    second
        Internal units of time [s].
    settled
        Whether sliding has died out for good, (n,).
    body
        The bodies in SI, with numbers (n,); a record other than that of a sphere or a heavy top has
        no modes.
    """
    theta = values["theta"].astype(float)
    rates = {name: np.nan_to_num(values[name].astype(float)) for name in RATES if name in values}
    still = np.abs([*rates.values()]).max(axis=0, initial=0.0) < STILL
    away = np.minimum(theta, np.pi - theta) >= LINEAR
    known = isinstance(body, Touch)
    gliding = system.frictional
    law: Any = body.friction if known else None
    free = False
    around = bool(getattr(body, "around", ()))
    parts = around or (known and (has_parts(law) or (bool(law.regions) and np.any(law.mu))))
    ends = {"tumbling": settled, "upright": theta < NEAR, "inverted": theta > np.pi - NEAR}
    if known:
        omega3 = values.get("omega3", 0 * theta).astype(float) / second  # a planar motion has none
        for name in {"upright", "inverted"}.intersection(system.classes):
            ends[name] &= ~is_unstable(omega3, body, inverted=name == "inverted", gliding=gliding)
        ends["tumbling"] = settled & away
        if gliding and not parts:
            ends["tumbling"] &= shows_sliding(body, np.cos(theta))
            free = takes_nothing(law)
    swings = (np.sin(theta) >= STILL) | (np.abs(rates.get("theta_dot", 0.0)) >= STILL)
    phase = values.get("phase", -1)
    ball = values.get("ball", -1)
    rolls = (phase == PHASES.index("roll")) | (phase == PHASES.index("rest"))
    rules = [
        ("bouncing", phase == PHASES.index("flight")),
        ("at-rest", still & (parts and not around)),
        ("on-stem", ball == BALLS.index("stem")),
        ("rolling", rolls & away),
        ("nutating", free & swings & (values.get("work", 0.0) <= LOST)),
        ("at-rest", free & still & ~swings),
        *((name, ends[name] & ~(free & swings | parts)) for name in reversed(system.classes)),
        ("rolling", rolls),
    ]
    # the first rule that applies counts, but the last of `classes`: so these are reversed
    names, conditions = zip(*rules, strict=True)
    numbers = [CLASSES.index(name) for name in names]
    return np.select(conditions, numbers, CLASSES.index("under-way"))
