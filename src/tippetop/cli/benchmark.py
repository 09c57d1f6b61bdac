"""`tippetop benchmark`: named cases for developers of contact simulators, and their score."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

from ..errors import InputError
from .streams import complain, print_json, visible
from .text import table


def benchmark(
    action: Literal["list", "export", "score"],
    /,
    *arguments: str,
    scenario: list[Path] | None = None,
    case: str | None = None,
    fail_above: list[str] | None = None,
    figures: Path | None = None,
    markdown: bool = False,
    overwrite: bool = False,
    as_json: bool = False,
) -> int:
    """Export reference cases for contact simulators, and score the results of an engine.

    The order of a result is log(e1/e2)/log(h1/h2) of the rms error e of the attitude at its step
    h2 and the next larger one, h1; it is blank where an attitude is off by more than 1 rad.

    Parameters
    ----------
    action
        list, export or score.
    arguments
        For export a folder, and the names of cases (by default all). For score files
        ENGINE/SETTING/CASE/dt=STEP.csv, or folders that contain them.
    scenario
        For export: a TOML file or a preset to export as a case. May be repeated.
    case
        For score: the case of all files, instead of the names of their folders; a TOML file for a
        scenario that was exported.
    fail_above
        For score: exit 4 if the largest error of a result exceeds this, [quantity=]number: the
        attitude [rad], or theta, position, spin, energy, force, such as position=1e-3; or if an
        outcome is wrong, or rows are missing. May be repeated.
    figures
        For score: write a figure of each case, CASE.png, to this folder.
    markdown
        For score: print the table as Markdown.
    overwrite
        Replace existing files.
    as_json
        Print the result as one JSON object.
    """
    from .. import benchmark as cases

    given: dict[str, dict[str, Any]] = {
        "score": {"case": case, "fail-above": fail_above, "figures": figures, "markdown": markdown},
        "export": {"scenario": scenario},
    }
    for other, options in given.items():
        if other != action and (wrong := [name for name, value in options.items() if value]):
            raise InputError(
                f"`--{wrong[0]}` requires the action {other}, but the action is {action}."
            )
    if action == "score":
        return _score(arguments, case, fail_above or [], figures, markdown, overwrite, as_json)
    if action == "export":
        if not arguments:
            raise InputError("a folder is required: tippetop benchmark export DIR [CASE ...].")
        made = cases.export(arguments[0], [*arguments[1:], *(scenario or ())], overwrite=overwrite)
        if as_json:
            return print_json({"files": [str(path) for path in made]})
        print(f"folder  {arguments[0]}, {len(made)} files")
        return 0
    if arguments:
        raise InputError(f"list takes no arguments, but `{arguments[0]}` is given.")
    known = [cases.case(name) for name in cases.names()]
    if as_json:
        return print_json({each.name: each.title for each in known})
    table([(each.name, each.title) for each in known])
    return 0


def _score(
    results: tuple[str, ...],
    case: str | None,
    fail_above: list[str],
    figures: Path | None,
    markdown: bool,
    overwrite: bool,
    as_json: bool,
) -> int:
    """Print the score of results, and draw the figures; return the exit code.

    The arguments are those of `benchmark`. The code is 2 (`cli.USAGE`) if a file of results could
    not be read, else 4 (`cli.ACCURACY`) if a result fails `fail_above`.
    """
    from itertools import groupby

    from ..arguments import choice, measured
    from ..benchmark.score import QUANTITIES, score
    from ..mechanics.units import ONE
    from ..store.files import writing

    limits = {}
    for text in fail_above:
        name, _, number = text.rpartition("=")
        name = name or QUANTITIES[0]
        choice("--fail-above", name, QUANTITIES)
        limits[name] = measured("--fail-above", number, ONE)
    if figures is not None:
        with writing(figures):
            figures.mkdir(parents=True, exist_ok=True)
    faults: list[InputError] = []
    scored = score(results, case, skip=faults.append)
    sentences = [sentence for fault in faults for sentence in fault.sentences]
    if faults and not scored.results:
        raise InputError(sentences)
    if figures is not None:
        from ..figures import drawing
        from ..figures.errors_by_step import errors_by_step

        # `score` sorts by case
        for name, group in groupby(scored.results, key=lambda result: result.case):
            drawing.write(
                errors_by_step(name, list(group)), figures / f"{name}.png", overwrite=overwrite
            )
    if as_json:
        print_json({"results": scored.to_dict()})
    else:
        print(visible(scored.to_markdown() if markdown else str(scored)))
    failures = scored.failures(limits) if limits else []
    return complain(sentences + failures, 2 if sentences else 4 if failures else 0)
