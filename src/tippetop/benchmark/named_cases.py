"""The named cases: scenarios of the package with their texts, friction laws and certificates.

A name or a file goes in, a `Case` comes out, for `case_files` and `score`.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError, suggestion
from ..mechanics.contact.body import size
from ..mechanics.contact.surroundings import require_still
from ..problem import Problem
from ..runs import starting
from ..scenario import reading
from .truth import differences, sample_times, truth


LARGEST = 1e-10
"""Largest error of a reference: of the attitude [rad], and of the position by the radius."""


class Case(NamedTuple):
    """A named case.

    Attributes
    ----------
    name, title, text
        Description.
    law
        Its friction law: `words`, and by engine the settings that express it (`exact`).
    problem
        The scenario of the reference.
    certificate
        The error of the reference and its horizon; of a named case also its rounding.
    """

    name: str
    title: str
    text: str
    law: Mapping[str, Any]
    problem: Problem
    certificate: Mapping[str, Any]

    @property
    def settings(self) -> dict[str, str]:
        """Return by engine the settings that express the law and the restitution."""
        exact = self.law["exact"]
        rules = self.problem.contact
        if rules is None or not rules.e_n:
            return dict(exact)
        ways = data("laws.toml")["restitution"]
        return {
            engine: f"{words}; restitution e = {rules.e_n:g}: {ways[engine]}"
            for engine, words in exact.items()
        }

    @property
    def horizon(self) -> float:
        """Return the time up to which results are compared [s]."""
        return self.certificate["horizon"]


@cache
def data(file: str) -> dict[str, Any]:
    """Return the content of a data file of this package, TOML or JSON; not to be changed."""
    text = (files(__package__) / file).read_text(encoding="utf-8")
    return json.loads(text) if file.endswith(".json") else tomllib.loads(text)


def names() -> tuple[str, ...]:
    """Return the names of the cases, the simplest first."""
    return tuple(data("cases.toml"))


def case(name: str | Path) -> Case:
    """Return a case of the benchmark.

    Parameters
    ----------
    name : str or path
        One of `names()`, or a preset or the TOML file of a scenario, which is run to find its
        certificate.

    Returns
    -------
    Case
        Its scenario, law and certificate.

    Raises
    ------
    InputError
        If no case has this name, or the scenario has no contact that may open or ends early.
    """
    own = Path(name).suffix == ".toml" or str(name) in reading.presets().keys() - {*names()}
    return _own(Path(name)) if own else _named(str(name))


def _own(path: Path) -> Case:
    """Return a scenario, a TOML file or a preset, as a case; it is run. Raises InputError.

    Its certificate has the entries of `bench.certificates.certificate` that `Case` and `case_files`
    read, without the `rounding`, which is found for named cases only.
    """
    problem = replace(starting.load(path), orientation=True)
    require_still(problem.tables, f"`{path}`", tilted=True)
    if path.stem in names():
        raise InputError(f"`{path}` must not have the name of a case, but {path.stem} is one.")
    if problem.contact is None and problem.system.name != "heavy-top":
        raise InputError(
            f"`{path}` must have a table [contact], because a body can lift off in a simulator, "
            "but has none."
        )
    times = sample_times(problem)
    runs = [truth(problem, times, precision) for precision in ("double", "longdouble")]
    for motion, run in runs:
        if len(motion.t) < len(times):
            raise InputError(f"`{path}` must reach `run.until`, but ends before: {run.reason}.")
    apart = differences(runs[0][0], runs[1][0])
    error = np.maximum(apart["attitude [rad]"], apart["position [m]"] / size(problem.body()))
    certified = np.logical_and.accumulate(error <= LARGEST)
    certificate = {
        "error": float(f"{error[certified].max():.1e}"),
        "against": "the run in 80-bit numbers, which is exported",
        "horizon": float(times[certified][-1]),
        "horizon_by": f"the runs in double and in 80-bit numbers agree to {LARGEST:g}",
    }
    law = {"words": problem.law.long_name, "exact": {}}
    return Case(path.stem, problem.system.title, "", law, problem, certificate)


@cache
def _named(name: str) -> Case:
    """Return the case of a name. Raises InputError."""
    cases = data("cases.toml")
    if name not in cases:
        raise InputError(
            f"unknown case `{name}`.{suggestion(name, cases)} The cases are {', '.join(cases)}."
        )
    given = cases[name]
    tables = reading.read(given["preset"]) | {k: v for k, v in given.items() if isinstance(v, dict)}
    return Case(
        name,
        given["title"],
        given["text"].strip(),
        data("laws.toml")[given["law"]],
        starting.problem_from_tables(tables, name),
        data("certificates.json").get(name, {}),
    )
