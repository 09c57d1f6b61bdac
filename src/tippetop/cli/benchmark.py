"""`tippetop benchmark`: named cases for developers of contact simulators, and their score."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from .streams import complain, print_json, visible


def benchmark(
    action: Literal["list", "export", "score"],
    /,
    *arguments: str,
    case: str | None = None,
    figures: Path | None = None,
    markdown: bool = False,
    overwrite: bool = False,
    as_json: bool = False,
) -> int:
    """Export reference cases for contact simulators, and score the results of an engine.

    Parameters
    ----------
    action
        list, export or score.
    arguments
        For export a folder, and the names of cases (by default all). For score files
        ENGINE/SETTING/CASE/dt=STEP.csv, or folders that contain them.
    case
        For score: the case of all files, instead of the names of their folders.
    figures
        For score: write a figure of each case, CASE.png, to this folder.
    markdown
        For score: print the table as Markdown.
    overwrite
        Replace existing files.
    as_json
        Print the result as one JSON object.
    """
    from ..errors import InputError

    if action == "score":
        return _score(arguments, case, figures, markdown, overwrite, as_json)
    from .. import benchmark as cases
    from .text import table

    given = {"--case": case, "--figures": figures, "--markdown": markdown}
    if wrong := [option for option, value in given.items() if value]:
        raise InputError(f"`{wrong[0]}` requires the action score, but the action is {action}.")
    if action == "export":
        if not arguments:
            raise InputError("a folder is required: tippetop benchmark export DIR [CASE ...].")
        made = cases.export(arguments[0], arguments[1:], overwrite=overwrite)
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
    figures: Path | None,
    markdown: bool,
    overwrite: bool,
    as_json: bool,
) -> int:
    """Print the score of results, and draw the figures."""
    from itertools import groupby

    from ..benchmark import score
    from ..errors import InputError
    from ..store.files import writing

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

        for name, group in groupby(scored.results, key=lambda result: result.case):
            drawing.write(
                errors_by_step(name, list(group)), figures / f"{name}.png", overwrite=overwrite
            )
    if as_json:
        print_json({"results": scored.to_dict()})
    else:
        print(visible(scored.to_markdown() if markdown else str(scored)))
    return complain(sentences, 2 if sentences else 0)
