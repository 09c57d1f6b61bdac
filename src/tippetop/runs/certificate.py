"""The accuracy contract: what every run promises of its invariants, and a second run in wider numbers as a witness."""

import dataclasses
import math
from typing import Any

import numpy as np

from ..errors import InputError
from ..problem import Problem
from ..sampling import ListedTimes
from .patience import warning
from .run import Solution, solve


PROMISED = {"jellett": 1e-13, "axis_norm": 1e-13, "energy_balance": 1e-12}
PROMISED_OTHERWISE = 1e-12  # any other integral: Routh's function, L_z, L_3
GROWS_AFTER = 1e4  # [s]: rounding adds up like a random walk, so from here on the promise grows with sqrt(t)
PROMISED_THETA = 1e-10  # [rad]: of theta against the wider run, over the certified window
WIDER = {"double": "longdouble", "longdouble": "quad"}
SAMPLES = 2001


def broken_promises(report: dict[str, Any], tolerance: float, precision: str) -> list[str]:
    """Sentences on the drifts that exceed the contract. A run at a tolerance of its own promises nothing."""
    if tolerance > 2.3e-16:
        return []
    growth = math.sqrt(max(1.0, report["t_end"] / GROWS_AFTER))
    return [
        f"the drift of {name.replace('_', ' ')} must be at most {bound:.1e}, but is {number:.1e}."
        for name, drift in report["drift"].items()
        if not (number := math.nan if drift is None else drift)  # as JSON has what is not finite
        <= (bound := PROMISED.get(name, PROMISED_OTHERWISE) * growth)
    ]


NEAR_POLE = 0.5  # [rad] where a form that is singular at the poles has lost digits that show


def remedy(attrs: dict[str, Any]) -> str:
    """What keeps the promises that a run has broken, a sentence: a form that is regular at the poles, where it came
    near one in another; empty where that is not why. `attrs` are its root attributes."""
    report, form, better = attrs["report"], attrs["form"], attrs["auto_form"]["form"]
    if form == better or "axis_norm" in report["drift"]:  # forms that integrate the axis are regular
        return ""
    band = report.get("nutational_band", {}).values()
    angles = [a for a in (attrs["initial"].get("theta"), report["theta_end"], *band) if a is not None]
    nearest = min((min(a, math.pi - a) for a in angles), default=math.pi)
    if not nearest < NEAR_POLE:
        return ""
    return f'theta comes to {nearest:.2g} rad of a pole, where form = "{form}" is singular: take form = "{better}".'


def refuse_window(window: float | None, name: str = "`window`") -> None:
    """Raises InputError for what is no part of a run [s] from its start on."""
    if window is not None and not 0 < window < math.inf:
        raise InputError([f"{name} must be greater than 0 and finite, but is {window:g}."])


def certificate(problem: Problem, window: float | None = None) -> dict[str, Any]:
    """Repeats the run from its start over `window` seconds (all of it if None) in this precision and in the next wider
    one, and compares them: largest error of theta and of the state, and of the times of the turnings they share. The
    window ends where the run does, if that is before."""
    if problem.precision not in WIDER:
        return {"against": None, "reason": "no wider precision than quad"}
    refuse_window(window)
    until = min(problem.until, window or problem.until)
    times = np.linspace(0.0, until, SAMPLES)
    plain = dataclasses.replace(problem, until=until, times=ListedTimes(times), output="times", stop_when="until")
    plain = dataclasses.replace(plain, columns=None, orientation=False)  # not compared, and no effect on what is
    wide = dataclasses.replace(plain, precision=WIDER[problem.precision], tolerance=0.0)
    mine, witness = solve(plain, warning()), solve(wide, warning())
    rows = min(len(mine.times), len(witness.times))
    theta = _difference(mine, witness, "theta", rows)
    result: dict[str, Any] = {
        "against": wide.precision,
        "window": [0.0, min(until, mine.report["t_end"])],
        "theta": float(theta.max(initial=0.0)),
        "theta_end": float(theta[-1]) if rows else 0.0,
        "same_end": mine.status is witness.status,
    }
    if "axis" in problem.system.vectors:
        result["axis"] = float(_difference(mine, witness, "axis", rows).max(initial=0.0))
    turnings = [run.events.of("turning", significant=True).time for run in (mine, witness)]
    shared = min(map(len, turnings))
    if shared:
        result["turnings"] = {"compared": shared, "counts": [len(t) for t in turnings]}
        result["turnings"]["time"] = float(np.abs(turnings[0][:shared] - turnings[1][:shared]).max())
    return result


def broken_certificate(result: dict[str, Any]) -> list[str]:
    """Sentences on what the wider run contradicts."""
    if result["against"] is None:
        return []
    faults = []
    if not result["theta"] <= PROMISED_THETA:
        faults.append(
            f"theta must be within {PROMISED_THETA:.0e} of the wider run, but differs by {result['theta']:.1e}."
        )
    if not result["same_end"]:
        faults.append("the run must end as the wider run does, but ends otherwise.")
    return faults


def _difference(mine: Solution, witness: Solution, name: str, rows: int) -> np.ndarray:
    return np.abs(mine.columns()[name].values[:rows] - witness.columns()[name].values[:rows])
