"""The options of a run, [run] in a scenario: each is declared once, as a field of `RunOptions`.

`RunOptions` is the base of `Problem`; help, templates and signatures are made of the same fields.
"""

from __future__ import annotations

import inspect
import itertools
import textwrap
from collections.abc import Sequence
from dataclasses import MISSING, Field, dataclass, field, fields
from typing import Any, Literal, get_type_hints

import numpy as np

from ..errors import suggestion
from ..mechanics.number import Number
from ..mechanics.units import ONE, SECOND, Unit
from ..sampling import EvenTimes, ListedTimes


ROUNDING = {"double": 2.0**-52, "longdouble": 2.0**-63, "quad": 2.0**-112}

# 20 to 60 ms of computing: what a replay does before its first row. 0.1 kB a step are 10 of rows.
KEYFRAME_STEPS = 8192

# More rows are a mistake: 200 TB.
MOST_ROWS = 10**12

# Smallest tolerance in rounding units, 2.2e-21 in double. Over 200 s of rolling in vector form,
# 1e-20 and 1e-21 change E no less than 0 does (1.4e-14, 1.7e-14; 1.5e-14), and compile in 46 s
# where 1e-18 takes 32 s.
LEAST_TOLERANCE = 1e-5


def option(
    words: str,
    unit: Unit | None = None,
    *,
    default: Any = MISSING,
    note: str = "",
    given: str = "",
    example: Any = None,
    **interval: float,
) -> Any:
    """Declare an option of a run.

    Parameters
    ----------
    words
        Its meaning, for `tippetop help` and templates.
    unit
        The unit of a number, for which a text such as "2 min" may be given.
    default
        Its value where it is left out; without, it must be given.
    note
        Further words for callers from Python.
    given
        The type that callers may pass, where it is wider than the type of the field.
    example
        A value for templates, if there is no default.
    interval
        `above`, `least`, `below`, `most` of a number, or of each in a list.
    """
    metadata = {
        "words": words,
        "unit": unit,
        "note": note,
        "given": given,
        "example": example,
        "rule": Number(unit or ONE, words, **interval),  # type: ignore[arg-type]
    }
    return field(default=default, metadata=metadata)


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """The end of a run, its accuracy, and the rows and columns that are kept.

    Names and order of the fields are those of [run] in scenarios and stores, of help and of the
    signatures of `run` and `load`; `metadata` is made by `option`.
    """

    until: float = option(
        "end of the run",
        SECOND,
        above=0,
        most=1e16,
        note="required, except if the source has an end, as every preset has",
    )
    output_step: float | None = option(
        "time between two rows; not together with output_times",
        SECOND,
        default=None,
        above=0,
        note="by default that of the source, or else a thousandth of the run",
    )
    output_times: tuple[float, ...] | None = option(
        "the times of the rows, instead of output_step",
        SECOND,
        default=None,
        least=0,
        note="(n,), ascending",
        given="Sequence[float] | np.ndarray | Any",
        example=(0.0, 1.0),
    )
    output: Literal["times", "events", "steps", "keyframes"] = option(
        "where the rows are: at times, at events, at the steps of the integrator; keyframes: no "
        "rows, but exact states from which rows can be computed later",
        default="times",
        note='"keyframes" requires `out`; `StoredRun.replay` computes the rows of any part',
    )
    keyframe_steps: int | None = option(
        "steps between two keyframes; by default 8192",
        default=None,
        least=1,
        example=KEYFRAME_STEPS,
    )
    stop_when: Literal["until", "settled"] = option(
        "end at `until`, or earlier, once sliding has ended", default="until"
    )
    events: tuple[str, ...] | None = option(
        "the kinds of events that are logged; by default all of the system",
        default=None,
        note="an empty list logs none. An Event record is logged together with the kinds that are "
        "named next to it; its name must be new, of letters, digits and _. Rows of `events` then "
        "have the columns of `trajectory` too: the state at the event",
        given="Iterable[str | Event] | str | Event",
    )
    on_liftoff: Literal["stop", "continue", "fly"] | None = option(
        "where the normal force vanishes: end the run, continue as if the contact pulled, or fly",
        default=None,
        note='by default "stop"; "fly" with `contact`, `stem`, or a Coulomb law without eps',
        example="stop",
    )
    precision: Literal["double", "longdouble", "quad"] = option(
        "precision of all numbers: 53, 64 or 113 bits", default="double"
    )
    tolerance: float = option(
        "largest relative error of a step; 0 means the rounding error of the precision",
        default=0.0,
        least=0,
        below=1,
    )
    columns: tuple[str, ...] | None = option(
        "the columns of the rows, in addition to the time; by default all",
        default=None,
        note="other columns are not stored; the turn of the body is integrated only if psi or "
        "orientation is among them. User-defined columns are Quantity records with new names; a "
        "list that contains only such records adds them to all columns",
        given="Iterable[str | Quantity] | str | Quantity",
        example=("theta",),
    )
    orientation: bool | None = option(
        "integrate the turn of the body about its axis; by default if a column needs it",
        default=None,
        note="the columns `psi` and `orientation`",
        example=True,
    )

    def rows(self) -> EvenTimes | ListedTimes:
        """Return the times of the rows; a grid always ends with `until` itself."""
        if self.output_times is not None:
            return ListedTimes(np.array(self.output_times, dtype=float))
        step = self.output_step or self.until / 1000 or self.until  # a thousandth may underflow
        return EvenTimes(step, self.until)

    def option_faults(self, events: Sequence[str]) -> list[str]:
        """Return sentences on options that contradict each other, in a system with these events."""
        step = self.output_step
        times = self.output_times or ()
        until = self.until
        faults = [
            f"`run.events` must be of {', '.join(events)}, but has "
            f"{name!r}.{suggestion(name, events)}"
            for name in self.events or ()
            if name not in events
        ]
        if step is not None and self.output_times is not None:
            faults.append(
                "`run.output_step` must be given alone, but `run.output_times` is given too: "
                "remove one (--set run.output_step=)."
            )
        if step is not None and not until / step <= MOST_ROWS:
            faults.append(
                f"`run.output_step` must give at most {MOST_ROWS:.0e} rows, but {step:g} gives "
                f"{until / step:.3g}."
            )
        least = LEAST_TOLERANCE * ROUNDING[self.precision]
        if 0 < self.tolerance < least:  # which costs order after order for nothing
            faults.append(
                f"`run.tolerance` must be 0 (the rounding unit) or at least {least:.1g} in "
                f"{self.precision} precision, but is {self.tolerance:g}: rounding hides what lies "
                "below, and each power of ten takes longer to compile."
            )
        rows = "output_times" if step is None else "output_step"
        for name, output in ((rows, "times"), ("keyframe_steps", "keyframes")):
            if self.output != output and getattr(self, name) is not None:
                faults.append(
                    f'`run.output` must be "{output}" where `run.{name}` is given, but is '
                    f'"{self.output}": remove one (--set run.{name}=).'
                )
        if any(b <= a for a, b in itertools.pairwise(times)):
            faults.append("`run.output_times` must ascend strictly, but do not.")
        if times and times[-1] > until:
            faults.append(
                f"`run.output_times` must not exceed run.until = {until:g}, but reach "
                f"{times[-1]:g}."
            )
        return faults


OPTIONS: dict[str, Field[Any]] = {f.name: f for f in fields(RunOptions)}
UNTIL: Number = OPTIONS["until"].metadata["rule"]
HINTS = get_type_hints(RunOptions)
UNITS: dict[str, Unit] = {
    name: f.metadata["unit"] for name, f in OPTIONS.items() if f.metadata["unit"]
}


def given_type(name: str) -> str:
    """Return the type that callers may pass for an option, as text, such as "float | str | None".

    An option with a unit may be a text; None leaves it out.
    """
    each = OPTIONS[name]
    own = str(each.type).removesuffix(" | None") + (" | str" if each.metadata["unit"] else "")
    return f"{each.metadata['given'] or own} | None"


def run_options(**options: Any) -> dict[str, Any]:
    """Return the options that are given, not None, as the table [run] of a scenario.

    Its signature, set below, lists each option: `takes(run_options)` adds them to other functions.
    """
    return {name: value for name, value in options.items() if value is not None}


run_options.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
    [
        inspect.Parameter(n, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=given_type(n))
        for n in OPTIONS
    ]
)


def documentation() -> str:
    """Return the options as a numpydoc section of parameters."""
    lines = []
    for name, each in OPTIONS.items():
        about = each.metadata
        unit = f" [{about['unit'].symbol}]" if about["unit"] else ""
        note = f". {about['note'][0].upper()}{about['note'][1:]}" if about["note"] else ""
        text = f"{about['words'][0].upper()}{about['words'][1:]}{unit}{note}."
        lines += [f"{name} : {given_type(name).replace(' | None', ', optional')}"]
        lines += textwrap.wrap(text, 106, initial_indent=" " * 4, subsequent_indent=" " * 4)
    return "\n".join(lines)
