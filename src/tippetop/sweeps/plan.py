"""The plan of a sweep: a TOML file becomes the checked numbers of many tops.

`Plan.from_toml` and `from_tables` are the entrances; they raise InputError with every fault.
"""

import contextlib
import math
import operator
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field, ValidationError

from ..arguments import PlainData, path_of
from ..ensembles import ensemble
from ..errors import InputError, true_sentences
from ..mechanics.caching import cached_property
from ..mechanics.quantity import number_of
from ..mechanics.units import ONE, Unit
from ..problem import Problem, key_faults
from ..sampling import spread
from ..scenario import build, reading
from ..scenario.contact import touches
from ..scenario.doubts import doubts
from ..scenario.identity import Records, user_records
from ..scenario.schema import Table
from ..scenario.sentences import error_sentence
from . import derived_axes
from .chunk import base_of, keep_choices
from .design import MOST_TOPS, Axis, Design, Sample


CHUNK_SECONDS = 1.0, 5.0  # of one core: writing a chunk of any size takes 0.03 s
LEAST_CHUNKS = 64  # so that the last chunks leave few cores idle
MICROSECONDS_PER_STEP = 0.8  # of one lane; measured on two cores of an AMD EPYC
FEWEST_STEPS = 30.0  # that loading a lane and checking a top are worth
CHUNKS = 128, 65_536  # tops: four to a lane, so that few idle at the end; what a failure may cost
WAYS = ("values", "linspace", "geomspace", "between")  # in which an axis gives its numbers
# of a top whose contact may change its phase; one that drills and hops takes three times as long
SECONDS_OF_CHANGES = 0.02
POOLED = 8, 256  # fewest such tops of a chunk: they must fill the lanes of many phases
Maker = Callable[[PlainData], Problem]
NOT_FINITE = ("nan", "inf", "-inf")  # as JSON must contain them


Count = Annotated[int, Field(ge=1)]


class PlanTable(Table, use_attribute_docstrings=True):
    """A plan as TOML gives it."""

    scenario: str | PlainData
    """the top that varies: a preset, a TOML file next to the plan, or tables"""
    set: dict[str, PlainData | str] = Field(default_factory=dict)
    """changes to it: tables as in a scenario"""
    axis: Annotated[list[Axis], Field(min_length=1)]
    """a number that differs from top to top"""
    sample: Sample | None = None
    """how axes with between are drawn"""
    keep: list[str] | None = None
    """columns to keep; by default all but orientation and lyapunov. final_state, drift, \
orientation are groups of columns; events is a table of the events of every top"""
    runs: list[Annotated[int, Field(ge=0)]] = Field(default_factory=list)
    """numbers of tops to run alone as well, with rows, into runs/N"""
    chunk: Count | None = None
    """tops that are computed and stored together; by default some seconds of one core"""


@dataclass(frozen=True)
class Plan:
    """A checked sweep.

    `document` is the plan in plain data: `from_tables(document)` is the same plan. Stores contain
    it, and are continued only by an equal one.
    """

    base: Problem
    design: Design
    document: PlainData

    @classmethod
    def from_toml(cls, path: str | Path, made: Maker = build.problem) -> "Plan":
        """Return the plan of a TOML file. Raises InputError with every fault."""
        place = path_of("plan", path)
        return cls.from_tables(reading.read(str(place)), place.parent, made)

    @classmethod
    def from_tables(
        cls, document: PlainData, folder: Path = Path(), made: Maker = build.problem
    ) -> "Plan":
        """Return the plan of plain data.

        Files are relative to `folder`; `made` makes the base of its tables. Raises InputError.
        """
        if "system" in document and not is_plan(document):
            raise InputError(
                "this is a scenario, not a plan: a plan names its scenario and has tables [[axis]]."
            )
        try:
            shape = PlanTable.model_validate(document)
        except ValidationError as error:
            raise InputError(error.errors(include_url=False), plan_sentence) from None
        base = made(_base(shape, folder))
        sentences = []
        keys = [axis.of for axis in shape.axis]
        plain = [key for key in keys if key not in derived_axes.DERIVED]
        if unknown := key_faults(base, plain, [*derived_axes.DERIVED, *base.rules]):
            raise InputError(unknown)  # a text of an unknown number has no unit
        for i, axis in enumerate(shape.axis, 1):
            rule = base.rules.get(axis.of)
            _read_texts(axis, f"axis.{i}", rule.unit if rule else ONE)
            sentences += _axis_faults(axis, f"axis.{i}", rule is not None and rule.nonzero)
        sentences += _design_faults(shape, keys)
        sentences += derived_axes.faults(base, keys) + ensemble.lanes_faults(base)
        if sentences:
            raise InputError(sentences)
        plain_data = shape.model_dump(exclude_none=True, exclude={"set"})
        for axis in plain_data["axis"]:
            if "values" in axis:
                axis["values"] = [v if math.isfinite(v) else str(v) for v in axis["values"]]
        tables = build.resolved(base)
        own = user_records(base.system)
        # the document cannot contain the user's records: workers get them as `Task.own`
        for key in tables["run"].keys() & {"events", "columns"}:
            names = {record.name for records in own for record in records}
            tables["run"][key] = [name for name in tables["run"][key] if name not in names]
        design = Design(tuple(shape.axis), shape.sample)
        plan = cls(base, design, {"keep": None, "chunk": None, **plain_data, "scenario": tables})
        if sentences := _run_faults(plan) + _keep_faults(plan):
            raise InputError(sentences)
        return plan

    @property
    def n(self) -> int:
        """Number of tops."""
        return self.design.n

    @cached_property
    def own(self) -> Records:
        """User-defined events and columns, which the document does not contain."""
        return user_records(self.base.system)

    @property
    def keep(self) -> list[str] | None:
        """Names of the columns that are kept; None: all."""
        return self.document["keep"]

    @property
    def runs(self) -> list[int]:
        """Tops that are also run alone, with rows and events."""
        return list(dict.fromkeys(self.document["runs"]))

    @cached_property
    def chunk(self) -> int:
        """Tops that are computed and stored together: the rows of each file of a column.

        It is estimated, not measured, so that it is the same for any workers on any computer.
        """
        given = self.document["chunk"]
        if given is not None:
            return min(given, self.n)
        seconds = np.clip(self.n * self.seconds_per_top / LEAST_CHUNKS, *CHUNK_SECONDS)
        best = 2 ** round(math.log2(max(1.0, seconds / self.seconds_per_top)))
        least = CHUNKS[0]
        if self.base.system.is_hybrid:
            # a quarter, so that a small sweep has four chunks too
            least = int(np.clip(self.n // 4, *POOLED))
        return min(max(best, least), CHUNKS[1], self.n)

    @property
    def chunks(self) -> int:
        """Number of chunks."""
        return -(-self.n // self.chunk)

    def tops(self, chunk: int) -> np.ndarray:
        """Return the numbers of the tops of a chunk."""
        return np.arange(chunk * self.chunk, min((chunk + 1) * self.chunk, self.n))

    def columns(self, tops: np.ndarray) -> dict[str, np.ndarray]:
        """Return the numbers of some tops, under keys of the scenario."""
        return derived_axes.resolved(self.base, self.design.numbers(tops))

    def problem(self, top: int) -> Problem:
        """Return the problem of one top, to run alone. Raises InputError."""
        tables = build.resolved(self.base)
        if touches(self.base):  # no gap was given: each top touches the plane as it would alone
            tables["initial"].pop("gap", None)
        for key, values in self.columns(np.array([top])).items():
            table, _, name = key.partition(".")
            # initial data may exclude each other; numbers of other tables are only replaced
            replaced = self.base.system.replaced if table == "initial" else operator.or_
            tables[table] = replaced(tables[table], {name: float(values[0])})
        run = tables["run"]
        if "output_times" in run:
            run["output_times"] = [t for t in run["output_times"] if t <= run["until"]]
        return base_of(tables, self.own)

    @property
    def doubts(self) -> list[str]:
        """Doubts about the first top; none if it is invalid."""
        with contextlib.suppress(InputError):
            return doubts(self.problem(0))
        return []

    @cached_property
    def seconds_per_top(self) -> float:
        """Estimated seconds of one core for a top: the same on every computer.

        From at most 48 tops, as each is checked, which takes a millisecond or so.
        """
        from ..runs import cost

        steps = []
        for top in spread(self.n, 48).tolist():
            try:
                steps.append(cost.estimate(self.problem(top))["steps"])
            except InputError:
                steps.append(0)
        least = SECONDS_OF_CHANGES if self.base.system.is_hybrid else 0.0
        return max(max(float(np.mean(steps)), FEWEST_STEPS) * MICROSECONDS_PER_STEP * 1e-6, least)


def is_plan(tables: PlainData) -> bool:
    """Return whether a TOML file is a plan rather than a scenario."""
    return "axis" in tables or "sample" in tables


def _base(shape: PlanTable, folder: Path) -> PlainData:
    """Return the tables of the scenario of a plan, with the changes of `set`.

    Its file is sought from `folder`. Raises InputError.
    """
    if isinstance(shape.scenario, dict):
        tables = dict(shape.scenario)
    else:
        local = folder / shape.scenario
        tables = reading.read(str(local) if os.path.isfile(local) else shape.scenario)
    for name, value in PlainData(shape.set).items():
        old: Any = tables.get(name)
        both = isinstance(old, dict) and isinstance(value, dict)
        tables[name] = reading.merged(name, old, value) if both else value
    if "from" in tables.get("initial", {}):
        raise InputError(
            "`initial.from` must not be given in a plan: it is the start of a single run."
        )
    return tables


def _read_texts(axis: Axis, name: str, unit: Unit) -> None:
    """Replace texts such as "60 rpm" in an axis by numbers in SI units, in place.

    `name` is that of the axis in messages, `unit` that of its number. Raises InputError.
    """
    for way in WAYS:
        values: Any = getattr(axis, way) or []
        for j, value in enumerate(values):
            if value in NOT_FINITE:
                values[j] = float(value)
            elif isinstance(value, str):
                values[j] = number_of(value, f"{name}.{way}.{j}", unit)


def _axis_faults(axis: Any, name: str, nonzero: bool) -> list[str]:
    """Return the faults of one axis, whose number must keep its sign where it is `nonzero`."""
    given = [way for way in WAYS if getattr(axis, way) is not None]
    spaced = bool({"linspace", "geomspace"} & {*given})
    # a way that is not given is replaced by numbers without a fault
    first, last = axis.between or (1.0, 2.0)
    low, high = axis.geomspace or (1.0, 1.0)
    numbers = axis.values or axis.linspace or axis.between or axis.geomspace or [1.0]
    least = min(numbers)
    most = max(numbers)
    found = " and ".join(given) or "none"
    ascend = "ascend from above 0" if axis.log else "ascend"
    return true_sentences(
        {
            f"`{name}` must have one of {', '.join(WAYS)}, but has {found}.": len(given) != 1,
            f"`{name}.n` must be given with linspace or geomspace, and with nothing else.": (
                spaced == (axis.n is None)
            ),
            f"`{name}.log` requires between, but there is none.": (
                axis.log is not None and "between" not in given
            ),
            f"`{name}.geomspace` must have two ends of one sign, but has {axis.geomspace}.": (
                not low * high > 0
            ),
            f"`{name}.between` must {ascend}, but is {axis.between}.": (
                not first < last or (axis.log and first <= 0)
            ),
            f"`{axis.of}` must keep its sign along an axis, but goes from {least:g} to {most:g}: "
            "make a sweep of each.": nonzero and least < 0 < most,
        }
    )


def _design_faults(shape: PlanTable, keys: list[str]) -> list[str]:
    """Return the faults of the axes together, before any number or top is made."""
    sample = shape.sample
    drawn = any(axis.between for axis in shape.axis)
    n = sample.n if sample else 1
    # an axis that is drawn counts as 1: all of these together have the `n` of the sample
    tops = math.prod(axis.n or len(axis.values or [0]) for axis in shape.axis) * n
    sobol = sample is not None and sample.method == "sobol"
    wrong: dict[str, Any] = {
        f"`{key}` must be one axis only, but is several.": keys.count(key) > 1 for key in keys
    }
    return true_sentences(
        wrong
        | {
            "`sample` must give method, n and seed where an axis has `between`, but is missing.": (
                drawn and sample is None
            ),
            "`sample` must have an axis with `between` to draw, but there is none.": (
                sample and not drawn
            ),
            f"`sample.n` must be a power of two for sobol, but is {n}.": sobol and n & (n - 1),
            f"`axis` must make at most {MOST_TOPS:.0e} tops, but makes {tops:.3g}.": (
                tops > MOST_TOPS
            ),
        }
    )


def _run_faults(plan: Plan) -> list[str]:
    """Return the faults of `runs`."""
    sentences = []
    for top in plan.runs:
        if top >= plan.n:
            sentences.append(f"`runs` must be numbers of tops, 0 to {plan.n - 1}, but has {top}.")
            continue
        try:
            plan.problem(top)
        except InputError as error:
            sentences += [
                f"`runs` must name tops that can be, but top {top}: {s}" for s in error.sentences
            ]
    return sentences


def _keep_faults(plan: Plan) -> list[str]:
    """Return the faults of `keep`: `chunk.columns` would ignore an unknown name."""
    if plan.keep is None:
        return []
    known = keep_choices(plan.base)
    unknown = [name for name in plan.keep if name not in known]
    return [f"`keep` must be of {', '.join(known)}, but has {name!r}." for name in unknown]


def plan_sentence(error: Any) -> str:
    """Return one pydantic error of a plan as a sentence; axes are counted from 1."""
    place = list(error["loc"])
    if place[0] == "axis" and len(place) > 1:
        place[1] += 1
    models: dict[Any, type[Table]] = {"axis": Axis, "sample": Sample}
    inner = models.get(place[0]) if len(place) > 1 else None
    key = ".".join(str(p) for p in place if p not in ("float", "str", "dict[str,any]"))
    return error_sentence(error, key, list((inner or PlanTable).model_fields))
