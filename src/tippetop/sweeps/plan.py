"""The plan of a sweep: a TOML file becomes the checked numbers of many tops, or sentences that say
what is wrong.
"""

import math
import operator
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, ValidationError, WrapValidator

from ..arguments import path_of
from ..ensembles import ensemble
from ..ensembles.outcomes import LYAPUNOV
from ..errors import InputError, first_sentences
from ..mechanics.caching import cached_property
from ..mechanics.quantity import number_of
from ..mechanics.units import ONE
from ..problem import Problem, derivative_faults, key_faults
from ..scenario import build, reading
from ..scenario.contact import touches
from ..scenario.law_change import change_law
from ..scenario.schema import Table
from ..scenario.sentences import error_sentence
from . import derived
from .design import Axis, Design, Sample


MOST_TOPS = 10**9
MOST_VALUES = 10**7  # of an axis: they are kept as they are
CHUNK_SECONDS = 1.0, 5.0  # of one core: writing a chunk takes 0.03 s, whatever its size
LEAST_CHUNKS = 64  # of a sweep that is worth cutting, so that the last chunks leave few cores idle
MICROSECONDS_PER_STEP = 0.8  # of one lane; measured on two cores of an AMD EPYC
FEWEST_STEPS = 30.0  # that loading a lane and checking a top are worth
CHUNKS = (
    128,
    65_536,
)  # tops: four to a lane, so that few idle at the end; and what a failure may cost
WAYS = ("values", "linspace", "geomspace", "between")  # in which an axis gives its numbers
SECONDS_ALONE = (
    0.1  # of a top whose contact may change its phase: a hop takes as long as a thousand steps
)

NOT_FINITE = ("nan", "inf", "-inf")  # as JSON must hold them


def _or_text(value: Any, number: Callable) -> Any:
    """Return a number, or a text that is read once the unit of its axis is known."""
    if isinstance(value, str):
        return float(value) if value in NOT_FINITE else value
    return number(value)


Number = Annotated[float, WrapValidator(_or_text)]
Pair = Annotated[list[Number], Field(min_length=2, max_length=2)]
AnyNumber = Annotated[  # an invalid top is marked, and its neighbours run
    float, Field(allow_inf_nan=True), WrapValidator(_or_text)
]
Count = Annotated[int, Field(ge=1)]


def _described(text: str) -> Any:
    """What a key is, for the key reference."""
    return Field(description=text)


class _Axis(Table):
    of: Annotated[
        str,
        _described(
            "a dotted key of parameters, friction or initial, or run.until, or a derived "
            "number: sigma, gamma, lambda"
        ),
    ]
    values: Annotated[
        Annotated[list[AnyNumber], Field(min_length=1)] | None,
        _described("the numbers of an axis of a grid; grids form a product"),
    ] = None
    linspace: Annotated[
        Pair | None, _described("first and last of n numbers at equal distances, instead")
    ] = None
    geomspace: Annotated[
        Pair | None, _described("first and last of n numbers at equal ratios, instead")
    ] = None
    between: Annotated[
        Pair | None, _described("bounds of a number that is drawn, as [sample] says, instead")
    ] = None
    n: Annotated[Count | None, _described("how many, with linspace or geomspace")] = None
    log: Annotated[bool | None, _described("draw the logarithm evenly, with between")] = None


class _Sample(Table):
    method: Annotated[
        Literal["random", "sobol", "latin-hypercube"],
        _described("how the axes with between are drawn together"),
    ]
    n: Annotated[Count, _described("how many tops are drawn")]
    seed: Annotated[
        int, Field(ge=0), _described("what the draw begins with: the same seed, the same tops")
    ]


class _Plan(Table):
    scenario: Annotated[
        str | dict[str, Any],
        _described("the top that varies: a preset, a TOML file beside the plan, or tables"),
    ]
    set: Annotated[
        dict[str, Any], _described("what is different in it: tables as in a scenario")
    ] = Field(default_factory=dict)
    axis: Annotated[
        list[_Axis], Field(min_length=1), _described("a number that differs from top to top")
    ]
    sample: Annotated[_Sample | None, _described("how axes with between are drawn")] = None
    keep: Annotated[
        list[str] | None,
        _described(
            "columns to keep; all but orientation and lyapunov. final_state, drift, orientation "
            "stand for all of theirs"
        ),
    ] = None
    runs: Annotated[
        list[Annotated[int, Field(ge=0)]],
        _described("numbers of tops to run alone as well, with rows, into runs/N"),
    ] = Field(default_factory=list)
    chunk: Annotated[
        Count | None,
        _described("tops that are computed and stored together; some seconds of one core"),
    ] = None


@dataclass(frozen=True)
class Plan:
    """A checked sweep.

    `document` says all of it in plain data: `from_tables(document)` is the same plan.
    """

    base: Problem
    design: Design
    document: dict[str, Any]

    @classmethod
    def from_toml(cls, path: str | Path) -> "Plan":
        """The plan of a TOML file. Raises InputError with every fault that was found."""
        place = path_of("plan", path)
        return cls.from_tables(reading.read(str(place)), place.parent)

    @classmethod
    def from_tables(cls, document: dict[str, Any], folder: Path = Path()) -> "Plan":
        """The plan of plain data; files are named relative to `folder`. Raises InputError."""
        if "system" in document and not is_plan(document):
            raise InputError(
                [
                    "this is a scenario, not a plan: a plan names its scenario and has tables "
                    "[[axis]]."
                ]
            )
        try:
            shape = _Plan.model_validate(document)
        except ValidationError as error:
            raise InputError(
                first_sentences(error.errors(include_url=False), scenario_sentence)
            ) from None
        base, sentences = None, []
        try:
            base = build.problem(_base(shape, folder))
        except InputError as error:
            sentences += error.sentences
        try:
            shape = shape.model_copy(update={"axis": _in_si(shape.axis, base)})
        except InputError as error:
            raise InputError([*sentences, *error.sentences]) from None
        of_axes = [
            s for i, axis in enumerate(shape.axis, 1) for s in _axis_faults(f"axis.{i}", axis)
        ]
        sentences = [*of_axes, *_design_faults(shape), *sentences]
        if base is not None:
            sentences += _key_faults(base, [axis.of for axis in shape.axis])
            sentences += [s for axis in shape.axis for s in _sign_faults(base, axis)]
        if sentences or base is None:
            raise InputError(sentences)
        sample = Sample(**shape.sample.model_dump()) if shape.sample else None
        design = Design(tuple(_axis(axis) for axis in shape.axis), sample)
        plain = shape.model_dump(exclude_none=True, exclude={"set"}) | {
            "scenario": build.resolved(base)
        }
        for axis in plain["axis"]:
            if "values" in axis:
                axis["values"] = [v if math.isfinite(v) else str(v) for v in axis["values"]]
        plan = cls(base, design, {"keep": None, "chunk": None, **plain})
        sentences = _whole_faults(plan)
        if sentences:
            raise InputError(sentences)
        return plan

    @property
    def n(self) -> int:
        """Number of tops."""
        return self.design.n

    @property
    def keep(self) -> list[str] | None:
        """Names of the columns that are kept; None: all."""
        return self.document["keep"]

    @property
    def runs(self) -> list[int]:
        """Tops that are also run alone, with rows and events."""
        return self.document["runs"]

    @cached_property
    def chunk(self) -> int:
        """Tops that are computed and stored together; the same whoever computes them."""
        given = self.document["chunk"]
        if given is not None:
            return min(given, self.n)
        seconds = np.clip(self.n * self.seconds_per_top / LEAST_CHUNKS, *CHUNK_SECONDS)
        best = 2 ** round(math.log2(max(1.0, seconds / self.seconds_per_top)))
        least = CHUNKS[0] if not self.base.system.is_hybrid else 1
        return min(max(best, least), CHUNKS[1], self.n)

    @property
    def chunks(self) -> int:
        """Number of chunks."""
        return -(-self.n // self.chunk)

    def tops(self, chunk: int) -> np.ndarray:
        """Numbers of the tops of a chunk."""
        return np.arange(chunk * self.chunk, min((chunk + 1) * self.chunk, self.n))

    def columns(self, tops: np.ndarray) -> dict[str, np.ndarray]:
        """The numbers of some tops, under keys of the scenario."""
        return derived.resolved(self.base, self.design.numbers(tops))

    def problem(self, top: int) -> Problem:
        """The problem of one top, to run alone. Raises InputError."""
        tables = build.resolved(self.base)
        if touches(self.base):  # no gap was given: each top stands as it would alone
            tables["initial"].pop("gap", None)
        for key, values in self.columns(np.array([top])).items():
            table, _, name = key.partition(".")
            changed = {name: float(values[0])}
            replaced = self.base.system.replaced if table == "initial" else operator.or_
            tables[table] = replaced(tables[table], changed)
        return build.problem(build.ending(tables, tables["run"]["until"]))

    @cached_property
    def seconds_per_top(self) -> float:
        """What a top takes one core, an order of magnitude from some of them: the same on every
        computer, as chunks are made of it.
        """
        from ..runs import cost

        steps = []
        for top in np.unique(np.linspace(0, self.n - 1, 48).astype(int)).tolist():
            try:
                steps.append(cost.estimate(self.problem(top))["steps"])
            except InputError:
                steps.append(0)
        least = 0.0 if not self.base.system.is_hybrid else SECONDS_ALONE
        return max(max(float(np.mean(steps)), FEWEST_STEPS) * MICROSECONDS_PER_STEP * 1e-6, least)


def is_plan(tables: dict[str, Any]) -> bool:
    """Whether a TOML file is meant as a plan rather than as a scenario."""
    return "axis" in tables or "sample" in tables


def _base(shape: _Plan, folder: Path) -> dict[str, Any]:
    """The tables of the scenario, with what `set` changes in them."""
    if isinstance(shape.scenario, dict):
        tables = dict(shape.scenario)
    else:
        beside = folder / shape.scenario
        tables = reading.read(str(beside) if beside.is_file() else shape.scenario)
    before = dict(tables)
    for name, value in shape.set.items():
        old = tables.get(name)
        if isinstance(old, dict) and isinstance(value, dict):
            tables[name] = {
                **(reading.without_output(old, value) if name == "run" else old),
                **value,
            }
        else:
            tables[name] = value
    numbers = [axis.of.removeprefix("friction.") for axis in shape.axis]
    law = shape.set.get("friction")
    change_law(before, tables, [*numbers, *(law if isinstance(law, dict) else ())])
    initial = tables.get("initial")
    if isinstance(initial, dict) and "from" in initial:
        raise InputError(
            ["`initial.from` must be the start of a single run, but many are asked for."]
        )
    until = shape.set["run"].get("until") if isinstance(shape.set.get("run"), dict) else None
    return build.ending(tables, until) if isinstance(until, int | float) else tables


def _in_si(axes: list[_Axis], base: Problem | None) -> list[_Axis]:
    """Return the axes with numbers in place of texts such as "60 rpm". Raises InputError."""
    read, faults = [], []
    for i, axis in enumerate(axes, 1):
        rule = base.rules.get(axis.of) if base is not None else None
        numbers: dict[str, Any] = {way: list(getattr(axis, way) or ()) for way in WAYS}
        for way, values in numbers.items():
            for j, value in enumerate(values):
                if isinstance(value, str):
                    try:
                        values[j] = number_of(
                            value, f"axis.{i}.{way}.{j}", rule.unit if rule else ONE
                        )
                    except InputError as error:
                        faults += error.sentences
        read.append(
            axis.model_copy(update={way: values or None for way, values in numbers.items()})
        )
    if faults:
        raise InputError(faults)
    return read


def _axis(axis: _Axis) -> Axis:
    if axis.between is not None:
        return Axis(axis.of, (), (axis.between[0], axis.between[1]), bool(axis.log))
    if axis.values is not None:
        return Axis(axis.of, tuple(axis.values))
    spread, (first, last) = (
        (np.linspace, axis.linspace) if axis.linspace else (np.geomspace, axis.geomspace or (1, 1))
    )
    return Axis(
        axis.of, tuple(spread(first, last, axis.n or 1).tolist()), log=axis.geomspace is not None
    )


def _axis_faults(name: str, axis: _Axis) -> list[str]:
    given = [way for way in WAYS if getattr(axis, way) is not None]
    sentences = []
    if len(given) != 1:
        sentences.append(
            f"`{name}` must have one of {', '.join(WAYS)}, but has {' and '.join(given) or 'none'}."
        )
    spaced = {"linspace", "geomspace"} & set(given)
    if spaced and axis.n is None:
        sentences.append(f"`{name}.n` must be given beside `{name}.{min(spaced)}`, but is missing.")
    if axis.n is not None and not spaced:
        sentences.append(f"`{name}.n` must stand beside linspace or geomspace, but there is none.")
    if axis.log is not None and "between" not in given:
        sentences.append(f"`{name}.log` must stand beside between, but there is none.")
    if axis.geomspace and not axis.geomspace[0] * axis.geomspace[1] > 0:
        sentences.append(
            f"`{name}.geomspace` must have two ends of one sign, but has {axis.geomspace}."
        )
    if axis.between and not (
        axis.between[0] < axis.between[1] and (not axis.log or axis.between[0] > 0)
    ):
        must = "ascend from above 0" if axis.log else "ascend"
        sentences.append(f"`{name}.between` must {must}, but is {axis.between}.")
    return sentences


def _sign_faults(base: Problem, axis: _Axis) -> list[str]:
    """Return a sentence if an axis passes through 0 though its number must not be 0."""
    rule = base.rules.get(axis.of)
    numbers = axis.values or axis.linspace or axis.between or axis.geomspace or [1.0]
    low, high = min(numbers), max(numbers)
    if rule is None or not (rule.nonzero and low < 0 < high):
        return []
    return [
        f"`{axis.of}` must keep its sign along an axis, but goes from {low:g} to {high:g}: make "
        "a sweep of each."
    ]


def _design_faults(shape: _Plan) -> list[str]:
    keys = [axis.of for axis in shape.axis]
    sentences = [
        f"`{key}` must be one axis only, but is several."
        for key in dict.fromkeys(keys)
        if keys.count(key) > 1
    ]
    sampled = any(axis.between is not None for axis in shape.axis)
    if sampled and shape.sample is None:
        sentences.append(
            "`sample` must say method, n and seed where an axis has `between`, but is missing."
        )
    if shape.sample and not sampled:
        sentences.append("`sample` must have an axis with `between` to draw, but there is none.")
    if shape.sample and shape.sample.method == "sobol" and shape.sample.n & (shape.sample.n - 1):
        sentences.append(f"`sample.n` must be a power of two for sobol, but is {shape.sample.n}.")
    return sentences + _size_faults(shape)


def _size_faults(shape: _Plan) -> list[str]:
    """That there are more numbers or tops than can be; asked before any is made."""
    counts = [
        min(axis.n or len(axis.values or [0]), 10**99) for axis in shape.axis
    ]  # larger ones have no %g
    sentences = [
        f"`axis` {i} must have at most {MOST_VALUES:.0e} numbers, but has {count:.3g}."
        for i, count in enumerate(counts, 1)
        if count > MOST_VALUES
    ]
    tops = math.prod(counts) * (min(shape.sample.n, 10**99) if shape.sample else 1)
    if not sentences and tops > MOST_TOPS:
        sentences.append(f"`axis` must make at most {MOST_TOPS:.0e} tops, but makes {tops:.3g}.")
    return sentences


def _key_faults(base: Problem, keys: list[str]) -> list[str]:
    """What is wrong with varying these keys of the base."""
    plain = [key for key in keys if key not in derived.DERIVED]
    return [
        *derived.faults(base, keys),
        *ensemble.base_faults(base),
        *key_faults(base, plain, derived.DERIVED),
    ]


def _whole_faults(plan: Plan) -> list[str]:
    """What is wrong with the plan as a whole."""
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
    if plan.keep is not None:
        from .chunk import column_names

        known = column_names(plan.base)
        if LYAPUNOV in plan.keep and LYAPUNOV not in known:
            sentences += [
                f"`keep` must not have lyapunov here: {s}" for s in derivative_faults(plan.base)
            ]
            known.append(LYAPUNOV)
        sentences += [
            f"`keep` must be of {', '.join(known)}, but has {name!r}."
            for name in plan.keep
            if name not in known
        ]
    return sentences


def scenario_sentence(error: Any) -> str:
    """One pydantic error of a plan as `key` must ..., but is ...; axes are counted from 1."""
    place = [
        p + 1 if isinstance(p, int) and error["loc"][0] == "axis" and i == 1 else p
        for i, p in enumerate(error["loc"])
    ]
    models: dict[Any, type[Table]] = {"axis": _Axis, "sample": _Sample}
    inner = models.get(place[0]) if len(place) > 1 else None
    key = ".".join(str(p) for p in place if p not in ("str", "dict[str,any]"))
    return error_sentence(error, key, list((inner or _Plan).model_fields))
