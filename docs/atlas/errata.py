"""What a correction is: the printed and the correct form, and how both are evaluated. The records stand by chapter."""

import inspect
from collections.abc import Callable
from typing import Any, NamedTuple

import mpmath as mp
from exact import MOTIONS, of_letters, residual


STATES = 12  # random states at which a formula is evaluated


class Erratum(NamedTuple):
    """One correction.

    `kind`: misprint; bracket (only the grouping is lost, perhaps in the transcription alone); statement. `harmless`
    says why the conclusion stands all the same. `evidence` takes letters of `motion` and gives truth, printed and
    correct side; where `motion` is empty it gives findings.
    """

    number: int
    where: str
    kind: str
    printed: str
    correct: str
    by: str
    evidence: Callable
    motion: str = ""
    harmless: str = ""


class Sides(NamedTuple):
    """What a formula gives as printed and as corrected, beside the value that it must give."""

    truth: Any
    printed: Any
    correct: Any


class Finding(NamedTuple):
    """A statement in one case: what it says as printed, as corrected (None: nothing), and what is so."""

    case: str
    printed: Any
    correct: Any
    found: Any


class Residuals(NamedTuple):
    """Relative residuals at random states."""

    printed: list[mp.mpf]
    correct: list[mp.mpf]


def residuals(erratum: Erratum, states: int = STATES) -> Residuals:
    """|form - truth| over the larger of both, at random bodies and states, in 50 digits."""
    sides = [of_letters(erratum.evidence, MOTIONS[erratum.motion](seed)) for seed in range(states)]
    return Residuals(
        [residual(x.truth, x.printed) for x in sides], [residual(x.truth, x.correct) for x in sides]
    )


def short(x: mp.mpf) -> str:
    """A residual with two digits; what is below 1e-45 is rounding of numbers of 50 digits."""
    return mp.nstr(x, 2, min_fixed=1, max_fixed=0) if x else "0"


def _row(name: str, numbers: list[mp.mpf]) -> str:
    return f"| {name} | {short(min(numbers))} | {short(max(numbers))} |"


def _cell(x: Any) -> str:
    """A value of a finding."""
    return "" if x is None else ("no", "yes")[x] if isinstance(x, bool) else f"{x}"


def text(erratum: Erratum) -> str:
    """A correction as Markdown: both forms, their evidence, the code that made it."""
    lines = [
        f"**{erratum.where}** · {erratum.kind}",
        "",
        "Printed or read:",
        "",
        f"$$\n{erratum.printed}\n$$",
        "",
    ]
    lines += ["Correct:", "", f"$$\n{erratum.correct}\n$$", ""]
    if erratum.motion:
        found = residuals(erratum)
        lines += [
            f"| relative residual, {STATES} random states of a {erratum.motion} | smallest | largest |"
        ]
        lines += [
            "|---|---|---|",
            _row("as printed", found.printed),
            _row("corrected", found.correct),
        ]
    else:
        lines += ["| case | as printed | as corrected | computed |", "|---|---|---|---|"]
        for case, *values in erratum.evidence():
            printed, correct, computed = map(_cell, values)
            lines.append(f"| {case} | {printed} | {correct} | **{computed}** |")
    lines += [""] + ([f"Harmless: {erratum.harmless}", ""] if erratum.harmless else [])
    lines += [f"Reached by {erratum.by}.", "", ":::{dropdown} The code that was evaluated"]
    lines += ["```python", inspect.getsource(erratum.evidence).rstrip(), "```", ":::"]
    return "\n".join(lines)


def every() -> dict[int, Erratum]:
    """All corrections by number."""
    import errata_2
    import errata_3
    import errata_4
    import errata_5

    records = [*errata_2.ERRATA, *errata_3.ERRATA, *errata_4.ERRATA, *errata_5.ERRATA]
    return {record.number: record for record in records}


def show(number: int) -> Any:
    """The correction, for a page."""
    from IPython.display import Markdown

    return Markdown(text(every()[number]))


PAGES = {**dict.fromkeys(range(1, 6), "chapter-2"), **dict.fromkeys(range(6, 19), "chapter-3")}
PAGES |= {
    **dict.fromkeys(range(19, 25), "chapter-4"),
    **dict.fromkeys(range(25, 36), "chapter-5"),
    36: "appendix-a",
}


def summary() -> Any:
    """The table of all corrections, for a page."""
    from IPython.display import Markdown

    lines = [
        "| no. | where | kind | matters | printed: least residual | corrected: largest residual |",
        "|---|---|---|---|---|---|",
    ]
    for number, record in sorted(every().items()):
        ends = [""] * 2
        if record.motion:
            found = residuals(record)
            ends = [short(min(found.printed)), short(max(found.correct))]
        row = [
            f"[{number}](#erratum-{number})",
            record.where,
            record.kind,
            "harmless" if record.harmless else "yes",
            *ends,
        ]
        lines.append(f"| {' | '.join(row)} |")
    return Markdown("\n".join(lines))
