"""The result of a fit, as numbers, plain data, text, and as a scenario.

`fitting` makes it of an `Observation`.
"""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from ..arguments import PlainData
from ..columns import Arrays
from ..problem import Problem
from ..scenario import build
from .headers import UNITS
from .observation import TIMES, Observation


# Ratio of the ends of an interval beyond which it means nothing
WIDEST = 1e6


class Estimate(NamedTuple):
    """A number that was fitted: its value, standard error and 95 % interval, SI.

    The interval is NaN where the residuals are not noise. `systematic` is how far the number would
    move under all of `Fit.influences` together, as the root of the sum of their squares.
    `likelihood.drawn` reads the first two by place, and `tippetop fit --json` prints all by name.
    """

    value: float
    sigma: float
    low: float
    high: float
    systematic: float


@dataclass(frozen=True, eq=False)
class Fit:
    """The result of a fit.

    `fitting.judged` makes it, by the order of the fields; `library.exchanging.Fitted`, which adds
    one, shows it to the user.

    Parameters
    ----------
    observation
        Measurements and the scenario.
    estimates
        By dotted name.
    correlations
        (free, free).
    converged
        Whether enough independent searches ended in the same best minimum.
    trustworthy
        Whether also the residuals are noise, and the data decide every number.
    reasons
        Sentences; the first one is the outcome.
    residuals
        Name of each kind of measurement -> (rows, parts), measured less predicted, SI; of an axis
        two parts, across it.
    noise
        Name -> its standard deviation.
    influences
        By how much each number would move, SI, under what the scenario lacks, by its name.
    rows_correlated
        Over how many rows the residuals are correlated; 1: noise.
    """

    observation: Observation
    estimates: dict[str, Estimate]
    correlations: np.ndarray
    converged: bool
    trustworthy: bool
    reasons: list[str]
    residuals: Arrays
    noise: dict[str, float]
    influences: dict[str, dict[str, float]]
    rows_correlated: float

    @property
    def values(self) -> dict[str, float]:
        """The fitted numbers, SI, by name."""
        return {name: estimate.value for name, estimate in self.estimates.items()}

    @property
    def is_noise(self) -> bool:
        """Whether the residuals are noise, of the stated size.

        `fitting.judged` makes intervals NaN otherwise.
        """
        return not np.isnan([estimate.low for estimate in self.estimates.values()]).any()

    @property
    def reason(self) -> str:
        """Return the warnings of the report, in sentences."""
        return " ".join(self.reasons)

    @property
    def problem(self) -> Problem:
        """Return the scenario with the fitted numbers. Raises InputError if they conflict."""
        return build.problem(self.observation.tables(self.values))

    def to_dict(self) -> PlainData:
        """Return everything as plain data, as `tippetop fit --json` prints it."""
        from pandas import DataFrame

        names = list(self.estimates)
        return {
            "estimates": {name: estimate._asdict() for name, estimate in self.estimates.items()},
            "correlations": DataFrame(self.correlations, names, names).to_dict("index"),
            "converged": self.converged,
            "trustworthy": self.trustworthy,
            "reason": self.reason,
            "noise": self.noise,
            "influences": self.influences,
            "rows_correlated": self.rows_correlated,
            "rows": len(self.observation.t),
            "rows_used": self.observation.used,
        }

    def to_toml(self) -> str:
        """Return a scenario that runs: with the fitted numbers, standard errors as comments.

        Numbers of the table's clock, which a scenario does not have, are comments at the end.
        """
        # e: an `Estimate`
        notes = {name: f"  # +- {e.sigma:.2g}" for name, e in self.estimates.items()}
        clock = [
            f"# {name} = {e.value:.9g} +- {e.sigma:.2g}"
            for name, e in self.estimates.items()
            if name in TIMES
        ]
        heading = f"# Fitted by tippetop: {self.reason}"
        text = toml_of(self.observation.tables(self.values), notes)
        return "\n".join([heading, text, *clock, ""])

    def __str__(self) -> str:
        """Return numbers with errors and intervals, and reasons, in lines; doubts first."""
        width = max(len(name) for name in self.estimates)
        rows = []
        # e: an `Estimate`
        for name, e in self.estimates.items():
            unit = self.observation.rule(name).unit.symbol
            digits = _digits(e)
            suffix = "" if unit == "1" else f" {unit}"
            shift = f" +- {e.systematic:.2g} (systematic)" if e.systematic else ""
            errors = f" +- {e.sigma:.2g}{shift}"
            interval = f"95 %: {e.low:.{digits}g} to {e.high:.{digits}g}"
            if math.isnan(e.low):
                errors = ""
                interval = "no interval: the residuals are not noise"
            elif 0 < WIDEST * e.low < e.high:
                interval = "95 %: undecided"
            rows.append(f"{name:{width}}  {e.value:.{digits}g}{errors}{suffix}   ({interval})")
        noise = ", ".join(
            f"{name} {size:.3g} {UNITS.get(name, 'rad')}" for name, size in self.noise.items()
        )
        rows.append(f"residuals: {noise} (root mean square)")
        used = ", ".join(f"{name} {count}" for name, count in self.observation.used.items())
        rows.append(f"rows used: {used} of {len(self.observation.t)}")
        return "\n".join([*rows, *self.reasons] if self.trustworthy else [*self.reasons, *rows])


def _digits(estimate: Estimate) -> int:
    """Return the number of significant digits of a value, two more than its error leaves."""
    if not (estimate.value and math.isfinite(estimate.sigma) and estimate.sigma > 0):
        return 8
    return min(max(round(math.log10(abs(estimate.value) / estimate.sigma)) + 3, 2), 12)


def toml_of(tables: PlainData, notes: Mapping[str, str] = MappingProxyType({})) -> str:
    """Return the tables of a scenario as TOML; `notes`: comments by dotted name.

    Plain keys come before tables, to which they would belong otherwise. `benchmark.case_files`
    writes scenarios so, whose checksums are published.
    """
    text: list[str] = []
    for name, table in sorted(tables.items(), key=lambda item: isinstance(item[1], dict)):
        if not isinstance(table, dict):
            text.append(f"{name} = {_value(table)}")
            continue
        text += ["", f"[{name}]"]
        text += [
            f"{key} = {_value(value)}{notes.get(f'{name}.{key}', '')}"
            for key, value in table.items()
        ]
    return "\n".join(text)


def _value(value: Any) -> str:
    """Return a value in TOML."""
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    return repr(float(value)) if isinstance(value, float) else json.dumps(value, ensure_ascii=False)
