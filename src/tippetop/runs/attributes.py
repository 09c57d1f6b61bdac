"""The tables and attributes of a run's store, and the summary that `run` and `info` print.

A `RunProgress` goes in; out come plain data that a store keeps, and labelled Datasets of a run in
memory. `recording` and `library` call it at the end of a run.
"""

from typing import TYPE_CHECKING, Any

from ..arguments import PlainData
from ..columns import Column, plain_attributes, with_coordinates
from ..engine.status import Status
from ..mechanics.friction import PARTS
from ..problem import ROUNDING
from ..scenario.build import resolved, tables_of
from ..scenario.identity import DIGESTS, digests_of
from ..store.provenance import provenance
from ..store.root import finite
from . import phases
from .reporting import RunProgress, reason, report


if TYPE_CHECKING:
    from .run import Solution


def groups(run: "Solution") -> dict[str, dict[str, Column]]:
    """Return the tables of a run in memory, by the names of their groups in a store."""
    others = phases.joined(run.problem.system, run.others)
    return {"trajectory": run.columns(), "events": run.events, **others}


def datasets(run: "Solution", attrs: dict[str, Any]) -> dict[str, Any]:
    """Return the groups of a run in memory as labelled Datasets."""
    return {name: dataset(columns, attrs) for name, columns in groups(run).items()}


def dataset(columns: dict[str, Column], attrs: PlainData) -> Any:
    """Return columns as a labelled Dataset with these attributes.

    Tables and lists among `attrs` become JSON texts, and None is dropped (`plain_attributes`). A
    column may also be a plain pair (dims, values), as the labels of `library.derivatives` are.
    """
    import xarray as xr

    return with_coordinates(xr.Dataset(dict(columns), attrs=plain_attributes(attrs)))


def attributes(progress: RunProgress) -> PlainData:
    """Return the root attributes of a store: scenario, measurements, provenance; no clock times.

    Their names are a stored format, in the order in which `info --json` shows them. Equal runs must
    have equal attributes, whenever they were made.
    """
    problem = progress.problem
    last = zip(problem.variables.names, progress.last[0], problem.weights(), strict=True)
    numbers = {**problem.law.parameters, **problem.system.parameters, **problem.system.initial}
    return finite(
        {
            "title": problem.system.title,
            "source": problem.system.source,
            "status": (progress.status or Status.RUNNING).value,
            "reason": reason(progress),
            **resolved(problem),
            **({"start": problem.origin} if problem.origin else {}),
            **({DIGESTS: digests} if (digests := digests_of(problem)) else {}),
            "tolerance": problem.tolerance or ROUNDING[problem.precision],
            "precision": problem.precision,
            "units": {name: number.unit.symbol for name, number in numbers.items()},
            "final_state": {name: float(value) * float(weight) for name, value, weight in last},
            "report": report(progress),
            **provenance(),
        }
    )


OF_SUMMARY = (
    "certificate",
    "begun_with",
    "replay",
    "start",
    "tolerance",
    "precision",
    "final_state",
    "versions",
    "cpu",
)
"""Root attributes that a summary repeats if they exist."""


def info(attrs: PlainData) -> PlainData:
    """Return the object that `run --json` and `info --json` print, from root attributes."""
    return {
        "status": attrs["status"],
        "reason": attrs["reason"],
        **attrs["report"],
        **tables_of(attrs),
        **{key: attrs[key] for key in OF_SUMMARY if key in attrs},
    }


def headline_of(attrs: PlainData) -> str:
    """Return the title, form, precision and law of a run in one line.

    `views.run_page` takes what follows the first separator. Numbers of rolling resistance and
    drilling (`PARTS`) are left out where they are 0.
    """
    words = [attrs["title"], f"{attrs['form']} form", attrs["precision"]]
    if "friction" in attrs:
        law, *numbers = attrs["friction"].items()  # `build.resolved` puts ("law", name) first
        shown = [  # " 1" is the unit of a pure number
            f"{name} = {value:g} {attrs['units'][name]}".removesuffix(" 1")
            for name, value in numbers
            if value or name not in PARTS
        ]
        words.append(", ".join([f"{law[1]} friction", *shown]) if numbers else "no friction")
    return " · ".join(words)
