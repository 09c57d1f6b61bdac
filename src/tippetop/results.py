"""What a run leaves: the tables of its store, and the summary that `run` and `info` give."""

from typing import TYPE_CHECKING, Any

from .archive import provenance, versions
from .scenario import law_name, resolved
from .system import Unit
from .trajectory import Column, event_columns


if TYPE_CHECKING:
    from .solve import Run


def groups(run: "Run") -> dict[str, dict[str, Column]]:
    """The groups of the store: trajectory and events."""
    return {"trajectory": run.columns(), "events": event_columns(run.events)}


def attributes(run: "Run") -> dict[str, Any]:
    """The root attributes of the store: scenario, what was measured, provenance. No times of the clock."""
    problem = run.problem
    view = problem.form.units._fields
    weights = [float(w) for w in problem.weights(problem.form)]
    return {
        "title": problem.system.title,
        "source": problem.system.source,
        "status": run.status.value,
        "reason": run.reason,
        **resolved(problem),
        "tolerance": resolved(problem)["run"]["tolerance"],
        "precision": problem.precision,
        "units": {n: p.unit.symbol for n, p in problem.system.parameters.items()},
        "final_state": dict(zip(view, (float(v) * w for v, w in zip(run.final, weights, strict=True)), strict=True)),
        "report": run.report,
        **provenance(),
    }


def info(attrs: dict[str, Any]) -> dict[str, Any]:
    """The object that `run --json` and `info --json` print, from a store's root attributes."""
    return {
        "status": attrs["status"],
        "reason": attrs["reason"],
        **attrs["report"],
        **{key: attrs[key] for key in ("system", "form", "parameters", "friction", "initial", "run")},
        **{key: attrs[key] for key in ("tolerance", "precision", "final_state", "versions", "cpu")},
    }


def friction_words(friction: dict[str, Any], units: Any) -> str:
    """The friction law as a person says it."""
    numbers = [
        f"{name} = {value:g} {_symbol(unit)}".strip() for (name, value), unit in zip(friction, units, strict=True)
    ]
    return ", ".join(numbers)


def _symbol(unit: Unit) -> str:
    return "" if unit.symbol == "1" else unit.symbol


def headline(run: "Run") -> str:
    """One line: what was integrated."""
    problem = run.problem
    words = [problem.system.title, f"{problem.form.name} form", problem.precision]
    if problem.system.frictional:
        law = law_name(problem)
        numbers = friction_words(problem.friction._asdict().items(), problem.friction_units)
        words.append(f"{law} friction, {numbers}" if numbers else "no friction")
    return " · ".join(words)


__all__ = ["attributes", "friction_words", "groups", "headline", "info", "versions"]
