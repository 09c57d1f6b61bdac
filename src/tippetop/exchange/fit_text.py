"""The result of a fit as plain data, as text, and as a scenario.

A `fitting.Fit` goes in; plain data, lines, tables and TOML come out.
"""

import json
import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from ..arguments import PlainData
from .fitting import Estimate, Fit
from .headers import UNITS
from .observation import TIMES


# Ratio of the ends of an interval beyond which it means nothing
WIDEST = 1e6


def plain(fit: Fit) -> PlainData:
    """Return the object that `tippetop fit --json` prints."""
    from pandas import DataFrame

    names = list(fit.estimates)
    return {
        "estimates": {name: estimate._asdict() for name, estimate in fit.estimates.items()},
        "correlations": DataFrame(fit.correlations, names, names).to_dict("index"),
        "converged": fit.converged,
        "trustworthy": fit.trustworthy,
        "reason": " ".join(fit.reasons),
        "noise": fit.noise,
        "influences": fit.influences,
        "rows_correlated": fit.rows_correlated,
        "rows": len(fit.observation.t),
        "rows_used": fit.observation.used,
    }


def lines(fit: Fit) -> list[str]:
    """Return the result in lines: numbers with errors and intervals, and reasons; doubts first."""
    width = max(len(name) for name in fit.estimates)
    rows = []
    for name, e in fit.estimates.items():
        unit = fit.observation.rule(name).unit.symbol
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
        f"{name} {size:.3g} {UNITS.get(name, 'rad')}" for name, size in fit.noise.items()
    )
    rows.append(f"residuals: {noise} (root mean square)")
    used = ", ".join(f"{name} {count}" for name, count in fit.observation.used.items())
    rows.append(f"rows used: {used} of {len(fit.observation.t)}")
    return [*rows, *fit.reasons] if fit.trustworthy else [*fit.reasons, *rows]


def _digits(estimate: Estimate) -> int:
    """Return the number of significant digits of a value, two more than its error leaves."""
    if not (estimate.value and math.isfinite(estimate.sigma) and estimate.sigma > 0):
        return 8
    return min(max(round(math.log10(abs(estimate.value) / estimate.sigma)) + 3, 2), 12)


def toml(fit: Fit) -> str:
    """Return the scenario with the fitted numbers as TOML, standard errors as comments."""
    notes = {name: f"  # +- {e.sigma:.2g}" for name, e in fit.estimates.items()}
    clock = [
        f"# {name} = {e.value:.9g} +- {e.sigma:.2g}"
        for name, e in fit.estimates.items()
        if name in TIMES
    ]
    heading = "# Fitted by tippetop: " + " ".join(fit.reasons)
    return "\n".join([heading, toml_of(fit.observation.tables(fit.values), notes), *clock]) + "\n"


def toml_of(tables: PlainData, notes: Mapping[str, str] = MappingProxyType({})) -> str:
    """Return the tables of a scenario as TOML; `notes`: comments by dotted name."""
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
