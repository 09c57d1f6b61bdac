"""`tippetop run`: integrate a scenario, store it, draw it, say what happened."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter


def run(
    scenario: str,
    *,
    out: Path | None = None,
    until: float | None = None,
    set_: Annotated[list[str] | None, Parameter(name="--set", negative=())] = None,
    figure: Path | None = None,
    as_json: Annotated[bool, Parameter(name="--json", negative=())] = False,
    overwrite: Annotated[bool, Parameter(negative=())] = False,
) -> int:
    """Integrate a scenario: a TOML file or the name of a preset.

    Parameters
    ----------
    scenario
        TOML file, or preset (see `tippetop presets`).
    out
        Store to write, a zarr folder; must not exist yet.
    until
        End of the run [s], instead of the scenario's.
    set_
        Change a value: table.key=value. May be repeated.
    figure
        Draw theta(t) with the nutational band to this PNG, SVG or PDF.
    as_json
        Print the result as one JSON object.
    overwrite
        Replace an existing store.
    """
    from contextlib import ExitStack

    from tippetop import archive, results
    from tippetop import scenario as door

    from .text import Progress, summary

    problem = door.load(scenario, set_, until)
    if figure is not None:
        _check_picture(figure)
    with ExitStack() as stack:
        scratch = stack.enter_context(archive.new_store(out, overwrite=overwrite)) if out is not None else None
        from tippetop.solve import solve

        with Progress(problem.until) as progress:
            done = solve(problem, progress.update)
        attrs, groups = results.attributes(done), results.groups(done)
        if scratch is not None:
            archive.write(scratch, groups, attrs)
    if figure is not None:
        from tippetop.figures import draw

        draw("theta", groups, attrs, figure)
    if as_json:
        print(json.dumps(archive.finite(results.info(archive.finite(attrs))), allow_nan=False))
    else:
        places = {"store": out, "figure": figure}
        summary(results.headline(done), results.info(attrs), done.seconds, places)
    if done.status.value in ("finished", "liftoff", "fallen"):
        return 0
    print(f"tippetop: {done.reason}", file=sys.stderr)
    return 3


def _check_picture(path: Path) -> None:
    """Raises ScenarioError or StoreError now rather than after the run."""
    from tippetop.archive import StoreError
    from tippetop.scenario import ScenarioError

    if path.suffix.lower() not in (".png", ".svg", ".pdf"):
        raise ScenarioError([f"--figure must end with .png, .svg or .pdf, but is `{path}`."])
    if not path.parent.is_dir():
        raise StoreError(f"`{path.parent}` must be a folder, but is not.")


COMMANDS: list[Any] = [run]
