"""What can be said of a scenario before it is run: its invariants, its regime, its expected cost."""

from typing import Any

from ..engine.observables import Observables
from ..mechanics.systems.heavy_top import tip_inertia
from ..mechanics.theory.heavy_top_motion import heavy_top_motion
from ..mechanics.units import SECOND
from ..problem import Problem
from . import outlook


STEPS_PER_RADIAN = {"double": 0.9, "longdouble": 0.9, "quad": 0.85}  # measured: canonical inversion, 1337 steps in 8 s
LONG = 1e5  # seconds after which the vector form of a rolling top has changed E by 1e-12
AFFORDABLE = 1.0  # seconds: `check` runs a Coulomb top thrice only if that is quick
MICROSECONDS_PER_STEP = {"double": 2.0, "longdouble": 35.0, "quad": 900.0}  # two shared cores of an AMD EPYC


def assessment(problem: Problem) -> dict[str, Any]:
    """Quantities at the start (SI), and what the run will take: steps, seconds, bytes."""
    view = Observables(problem)
    start = problem.start()[None, :]
    values = view.evaluate(start)
    quantities = {
        f"{q.name} [{q.unit.symbol}]": float(values[q.name][0]) * float(problem.scales.of(q.unit))
        for q in problem.system.quantities
    }
    expected = cost(problem)
    said = _outlook(problem) | _regularisation(problem, expected) | _advice(problem)
    return {"at_start": quantities, **said, "expected": expected}


def remarks(problem: Problem) -> dict[str, Any]:
    """What a finished run deserves to have said of it: the name of a heavy top's motion, what eps decides."""
    said = _regularisation(problem, cost(problem))
    if problem.system.name == "heavy-top":
        start, view = problem.start()[None, :], Observables(problem)
        units = {q.name: q.unit for q in problem.system.quantities}
        E, Lz, L3 = (
            float(view.evaluate(start)[name][0]) * float(problem.scales.of(units[name]))
            for name in ("energy", "Lz", "L3")
        )
        b = problem.body()
        said["motion"] = heavy_top_motion(E, Lz, L3, tip_inertia(b), b.I3, b.m * b.g * -b.c)
    return said


def _outlook(problem: Problem) -> dict[str, Any]:
    """Thresholds, regime and predicted fate, as far as the theory goes."""
    found = outlook.assessment(problem.system, problem.body(float), problem.initial)
    limits = {f"{name} [{t.unit.symbol}]": t.value for name, t in found["thresholds"].items()}
    said = {key: found[key] for key in ("regime", "fate") if found[key]}
    return {**({"thresholds": limits} if limits else {}), **said}


def _advice(problem: Problem) -> dict[str, str]:
    """A better form for a run so long that rounding would break the contract."""
    better = "reduced" in problem.system.forms and problem.form.name != "reduced"
    if not better or problem.precision != "double" or problem.until < LONG:
        return {}
    return {"advice": 'rounding changes E by some 1.5e-17 a second: form = "reduced" with tolerance = 1e-18 keeps it'}


def _regularisation(problem: Problem, expected: dict[str, float]) -> dict[str, Any]:
    """What eps decides: the time of inversion for half, whole and twice eps, where three short runs can tell."""
    if problem.system.name != "tippe-top" or "eps" not in problem.friction._fields:
        return {}
    said: dict[str, Any] = {"regularisation": "eps decides when a top with Coulomb friction inverts"}
    if expected["seconds"] < AFFORDABLE:
        from .regularisation import inversion_sensitivity

        found = inversion_sensitivity(problem)
        times = {f"theta = pi/2 at [s], eps = {eps:g} m/s": t for eps, t in found["inversion_time"].items()}
        said["inversion_by_eps"] = {**times, "d log t / d log eps": found["exponent"]}
    return said


def cost(problem: Problem) -> dict[str, float]:
    """Orders of magnitude: a step spans about a radian of the fastest angle."""
    rates = problem.initial.get("omega3", problem.initial.get("psi_dot", 0.0)), problem.initial.get("phi_dot", 0.0)
    fastest = max(*(abs(float(r)) for r in rates), 1.0 / float(problem.scales.of(SECOND)))
    steps = problem.until * fastest * STEPS_PER_RADIAN[problem.precision]
    return {
        "steps": round(steps),
        "seconds": round(steps * MICROSECONDS_PER_STEP[problem.precision] * 1e-6, 4),
        "megabytes": round(len(problem.times) * 8 * 24 / 1e6, 3),
    }
