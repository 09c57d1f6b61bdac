"""Extreme bodies, laws and spins: in double, in 80 bits and in another form the motion is the same.

A random body (a millimetre to a metre, flat to long, heavy to light), law and start, spins from
none to thousands of radians a second, is integrated in double, in longdouble and, where the system
has one, in another form, over some hundreds of steps at most. Compared are the end (the same
status, and its time), theta at a few moments, and the energy. What is allowed is measured, not
guessed: the run is repeated from a start that is changed by 1e-10 of itself, which tells how much
an error grows, and a rounding a step may have happened anywhere on the way; beside it stands what
the run itself reports as drift of its invariants.

What it cannot see: a fault in a formula that all forms and precisions share (the laws of mechanics
in `tests/helpers` guard those), motions near a pole in forms that are singular there, events that
graze, and runs of more than a second.
"""

import dataclasses
import warnings
from pathlib import Path
from typing import Any

import bodies
import numpy as np
from verdict import Verdict


COUNT = 500
ROUNDING = 2.0**-52
NUDGE = 1e-10
ROUNDINGS = 300.0  # a step has some hundred operations, and errors of steps add up
MOMENTS = 9
NEAR_POLE = 0.05  # [rad] where angles of another form lose digits that they cannot help losing
STEPS = 300.0
PAIRS = (
    *(
        ("tippe-top", "viscous"),
        ("tippe-top", "coulomb"),
        ("rolling-tippe-top", ""),
        ("heavy-top", ""),
    ),
    *(("gliding-heavy-top", "viscous"), ("gliding-cylinder", "viscous"), ("rolling-cylinder", "")),
)  # each is compiled in two precisions and one or two forms
CHEAP = (("rolling-cylinder", ""), ("gliding-cylinder", "viscous"))


def prepare(_: Path, count: int, first: int) -> dict[str, Any]:
    """What is drawn from; a few tries draw from what compiles in seconds.

    Loops are compiled here: no case waits.
    """
    from tippetop.runs.run import solve
    from tippetop.scenario import build

    for precision in ("double", "longdouble"):
        solve(build.load("rolling-cylinder", [f"run.precision={precision}"], 0.01), keep=False)
    return {"pairs": PAIRS if count > 20 or first else CHEAP}


def tables_of(rng: np.random.Generator, pair: tuple[str, str]) -> dict[str, Any]:
    """A scenario at the ends of what can be."""
    from tippetop.mechanics.systems import SYSTEMS

    system, fastest = SYSTEMS[pair[0]], bodies.spread(rng, 0.01, 5000.0)
    tables = bodies.scenario(rng, pair, scale=50.0, fastest=fastest) | {
        "form": next(iter(system.forms))
    }
    rates = [abs(v) for name, v in tables["initial"].items() if name.endswith(("dot", "omega3"))]
    size = tables["parameters"].get("R", tables["parameters"].get("l"))
    fastest = max([1.0, (tables["parameters"]["g"] / size) ** 0.5, *rates])
    until = min(1.0, STEPS / fastest) * float(rng.uniform(0.1, 1.0))
    tables["run"] = {
        "until": until,
        "output_times": np.linspace(0, until, MOMENTS).tolist(),
        "orientation": False,
    }
    return tables


def attack(number: int, rng: np.random.Generator, _: Path, prepared: dict[str, Any]) -> Verdict:
    """Integrates one motion in several ways."""
    from tippetop.errors import InputError
    from tippetop.scenario import build

    tables = tables_of(rng, prepared["pairs"][number % len(prepared["pairs"])])
    try:
        problem = build.problem(tables)
    except InputError as error:
        return Verdict("refused", "; ".join(error.sentences), repeat={"tables": tables})
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        verdict = _compared(problem, rng)
    verdict.repeat = {"tables": tables}
    return verdict


def _compared(problem: Any, rng: np.random.Generator) -> Verdict:
    from tippetop.runs.certificate import contract_violations
    from tippetop.runs.run import solve

    theta = problem.initial["theta"]
    nudged = [
        dataclasses.replace(problem, initial=_changed(problem.initial, name))
        for name in problem.initial
        if theta
    ]
    mine, wide = solve(problem), solve(dataclasses.replace(problem, precision="longdouble"))
    if not mine.status.ordinary or not wide.status.ordinary:
        kind = "refused" if mine.status is wide.status else "wrong"
        return Verdict(
            kind,
            f"{mine.status.value}: {mine.reason}; in longdouble {wide.status.value}: {wide.reason}",
        )
    near = [solve(other) for other in nudged]
    faults = _apart(mine, wide, near, "longdouble", problem.until)
    forms = [name for name in problem.system.forms if name != problem.form.name]
    if forms and all(_away_from_poles(run) for run in (mine, wide)):
        form = problem.system.forms[str(rng.choice(forms))]
        other = dataclasses.replace(problem, form=form, initial=dict(problem.initial))
        if not other.clashes():
            theirs = solve(other)
            near += [solve(dataclasses.replace(other, initial=_changed(other.initial, "theta")))]
            faults += _apart(
                theirs, wide, near, f"form {form.name} against longdouble", problem.until
            )
    if faults:
        return Verdict("wrong", "; ".join(faults))
    broken = contract_violations(mine.report, problem.tolerance)
    return Verdict("broken" if broken else "same", "; ".join(broken))


def _changed(initial: dict[str, Any], name: str) -> dict[str, Any]:
    value = initial[name]
    return (
        initial
        if isinstance(value, bool)
        else initial | {name: value * (1 + NUDGE) + (NUDGE if value == 0 else 0)}
    )


def _away_from_poles(run: Any) -> bool:
    theta = np.mod(np.asarray(run.columns()["theta"].values, float), np.pi)
    band = run.report.get("nutational_band") or {}
    ends = [v for v in band.values() if isinstance(v, float)]
    near = np.minimum(theta, np.pi - theta).min(initial=np.pi)
    return near > NEAR_POLE and all(min(v % np.pi, np.pi - v % np.pi) > NEAR_POLE for v in ends)


def _apart(mine: Any, wide: Any, near: list[Any], what: str, until: float) -> list[str]:
    """Sentences on what differs by more than errors can have grown to."""
    growth = ROUNDINGS * ROUNDING / NUDGE * max(1.0, mine.report["steps"]) ** 0.5
    drift = max([0.0, *(d for d in mine.report["drift"].values() if d is not None)])
    ends = [abs(run.report["t_end"] - mine.report["t_end"]) for run in near]
    if mine.status is not wide.status:
        others = {run.status for run in near}
        if len(others | {mine.status}) > 1:  # the start decides, within a rounding or so
            return []
        return [
            f"{what}: {mine.status.value} and {wide.status.value}: {mine.reason}; {wide.reason}"
        ]
    faults = []
    allowed = 1e-13 * until + growth * max(ends)
    if not abs(mine.report["t_end"] - wide.report["t_end"]) <= allowed:
        faults.append(f"{what}: ends at {mine.report['t_end']!r} and {wide.report['t_end']!r} s")
    for name in ("theta", "energy"):
        columns = [run.columns() for run in (mine, wide, *near)]
        rows = min(len(c[name].values) for c in columns)
        one, other, *rest = (np.asarray(c[name].values[:rows], float) for c in columns)
        spread = np.max([np.abs(r - one) for r in rest], axis=0) if rest else np.zeros(rows)
        size = 1.0 if name == "theta" else float(np.abs(one).max(initial=0.0)) or 1.0
        allowed = size * (1e-12 + 100 * drift) + growth * np.maximum.accumulate(spread)
        bad = np.flatnonzero(~(np.abs(one - other) <= allowed))
        if len(bad):
            k = bad[0]
            faults.append(
                f"{what}: {name} {one[k]!r} and {other[k]!r} at t = {mine.times[k]:.4g} s, "
                f"allowed {allowed[k]:.1e}"
            )
    return faults
