"""Fits of one film under several friction laws, and which of them the film decides for.

A problem and the name of a law go in, the same problem under this law comes out (of [run] only
`until` is kept, and the form is chosen anew); fits of several go in, the best one and a sentence
come out.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..errors import InputError
from ..problem import Problem
from ..runs.run import solve, with_rows_at
from ..scenario import build
from .fit_result import Fit
from .influences import PATCH, USUAL_MU, changed
from .periods import RIVAL


# Plausible distance of the numbers under a further law from those under the first
NEAR = 0.1
# Rows of the motion by whose sliding the coefficients of laws are compared
ROWS = 200


def under(problem: Problem, law: str | Mapping[str, Any], until: float) -> Problem:
    """Return the scenario under another friction law.

    Parameters
    ----------
    problem
        The scenario.
    law
        A name, or a table `friction`. Under a law that is named, mu is such that friction takes the
        same energy up to `until` [s]; a disc has a radius of 0.1 mm; of exact Coulomb friction
        nothing else is needed.

    Raises
    ------
    InputError
        If a law is not one of the system, or needs other numbers.
    """
    if not problem.system.frictional:
        raise InputError(f"`laws` need a body that slides, but {problem.system.name} does not.")
    if law == problem.law.key:
        return problem
    friction = dict(law) if isinstance(law, Mapping) else _friction(problem, law, until)
    return changed(build.resolved(problem), {"friction": friction})


def _friction(problem: Problem, name: str, until: float) -> dict[str, Any]:
    """Return the table `friction` of the law `name`, under which a motion slides about as far.

    Its mu takes the same energy up to `until` [s] as the law of the problem; numbers of the law
    without a default are missing, and `build.problem` refuses the table. Raises InputError.
    """
    rows = solve(with_rows_at(problem, np.linspace(0, until, ROWS))).columns()
    power, force = (rows[column].values for column in ("friction_power", "normal_force"))
    slip = [rows[column].values for column in ("nu_x", "nu_y") if column in rows]
    speed = np.linalg.norm(slip, axis=0)
    # power = mu times force times this power of the speed
    order = 2 if name in ("viscous", "latitude") else 1
    pressed = np.nansum(force * speed**order)
    mu = abs(float(np.nansum(power))) / pressed if pressed > 0 else USUAL_MU
    # as the disc in `influences.changes`
    numbers = {"mu": mu, "patch": PATCH, "mu_r": 0.0} if name == "contensou" else {"mu": mu}
    return {"law": name, **(numbers if name != "none" else {})}


def verdict(fits: Mapping[str, Fit]) -> tuple[str, str]:
    """Return the law that explains a film best, and a sentence about the others.

    They are compared by the likelihood of independent noise as large as the residuals. Of laws that
    explain it equally well, one whose searches met is returned. `fits` are by the key of the law;
    the sentence is appended to the reasons of the best fit.
    """
    scores = {}
    for name, fit in fits.items():
        given = fit.observation.given
        off = [given[g].sum() * math.log(max(size, 1e-300)) for g, size in fit.noise.items()]
        # logarithm of the likelihood, less the number of free numbers (Akaike)
        scores[name] = -float(sum(off)) - len(fit.estimates)
    best = max(scores, key=lambda name: scores[name])
    # as of independent rows; RIVAL is a difference of squares, twice that of logarithms
    behind = {
        name: (scores[best] - score) / fits[best].rows_correlated for name, score in scores.items()
    }
    equal = [name for name, less in behind.items() if less < RIVAL / 2]
    # other numbers may fit better where too few searches met
    worse = ", ".join(
        f"{name} by {'' if fits[name].converged else 'at most '}{less:.3g}"
        for name, less in behind.items()
        if name != best
    )
    best = next((name for name in equal if fits[name].converged), best)
    if not any(fit.is_noise for fit in fits.values()):
        sentence = f"none of these laws explains the film; {best} comes nearest"
    elif len(equal) > 1:
        names = f"{', '.join(equal[:-1])} and {equal[-1]}"
        sentence = f"the film cannot decide between {names}, which explain it equally well"
    else:
        sentence = f"of these laws the film decides for {best}"
    sentence += f" (logarithms of the likelihood are less: {worse})."
    return best, sentence
