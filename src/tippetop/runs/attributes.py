"""The tables and attributes of a run's store, and the summary that `run` and `info` give."""

from typing import TYPE_CHECKING, Any

from ..columns import Column, with_coordinates
from ..engine.status import Status
from ..mechanics.systems import find
from ..problem import ROUNDING
from ..scenario.build import resolved, tables_of
from ..scenario.identity import DIGESTS, digests_of
from ..store.provenance import provenance
from . import phases
from .events import event_columns
from .reporting import RunProgress, reason, report


if TYPE_CHECKING:
    from .run import Solution


def groups(run: "Solution") -> dict[str, dict[str, Column]]:
    """The groups of a store, of a run in memory: trajectory and events; phases and impacts where
    the contact may change its phase.
    """
    others = phases.joined(run.problem.system, run.others)
    return {"trajectory": run.columns(), "events": event_columns(run.events), **others}


def datasets(run: "Solution") -> dict[str, Any]:
    """The groups of the store as labelled Datasets, in memory."""
    attrs = attributes(run.progress)
    return {name: dataset(columns, attrs) for name, columns in groups(run).items()}


def dataset(columns: dict[str, Column], attrs: dict[str, Any]) -> Any:
    """Columns as a labelled Dataset."""
    import xarray as xr

    return with_coordinates(
        xr.Dataset({k: (c.dims, c.values, c.attrs) for k, c in columns.items()}, attrs=attrs)
    )


def attributes(progress: RunProgress) -> dict[str, Any]:
    """Return the root attributes of a store: scenario, measurements, provenance.

    No times of the clock.
    """
    problem, names = progress.problem, progress.problem.variables.names
    values = [float(v) * float(w) for v, w in zip(progress.last[0], problem.weights(), strict=True)]
    parameters = {**problem.system.parameters, **problem.system.initial}
    return {
        "title": problem.system.title,
        "source": problem.system.source,
        "status": (progress.status or Status.RUNNING).value,
        "reason": reason(progress),
        **resolved(problem),
        **({"start": problem.origin} if problem.origin else {}),
        **({DIGESTS: digests} if (digests := digests_of(problem)) else {}),
        "tolerance": problem.tolerance or ROUNDING[problem.precision],
        "precision": problem.precision,
        "auto_form": problem.auto_form,
        "units": {name: parameter.unit.symbol for name, parameter in parameters.items()},
        "final_state": dict(zip(names, values, strict=True)),
        "report": report(progress),
        **provenance(),
    }


def info(attrs: dict[str, Any]) -> dict[str, Any]:
    """The object that `run --json` and `info --json` print, from a store's root attributes."""
    return {
        "status": attrs["status"],
        "reason": attrs["reason"],
        **attrs["report"],
        **tables_of(attrs),
        **{
            key: attrs[key]
            for key in ("auto_form", "certificate", "begun_with", "replay", "start")
            if key in attrs
        },
        **{key: attrs[key] for key in ("tolerance", "precision", "final_state", "versions", "cpu")},
    }


def headline_of(attrs: dict[str, Any]) -> str:
    """One line: what was integrated."""
    words = [attrs["title"], f"{attrs['form']} form", attrs["precision"]]
    if "friction" in attrs:
        law, *numbers = attrs["friction"].items()
        system = find(attrs["system"])
        known = (
            system.laws.get(law[1]) if system else None
        )  # None: of a package that is not installed here
        rules = known.given(dict(numbers)).parameters if known else {}
        units = {name: rules[name].unit.symbol if known else "" for name, _ in numbers}
        parts = [
            f"{name} = {value:g} {units[name]}".removesuffix(" 1").rstrip()
            for name, value in numbers
        ]
        words.append(", ".join([f"{law[1]} friction", *parts]) if numbers else "no friction")
    return " · ".join(words)
