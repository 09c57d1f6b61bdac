"""`tippetop plot`: figures of runs, sweeps, surfaces and potentials."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from ..errors import InputError
from ..figures import catalogue
from ..figures.catalogue import Look
from .values import Place, Seconds, sides


def plot(
    store: Place,
    *words: Annotated[str, Parameter(help=catalogue.described())],
    out: Place,
    from_: Seconds | None = None,
    until: Seconds | None = None,
    title: str | None = None,
    size: str | None = None,
    dpi: float = 150,
    dark: bool = False,
    overwrite: bool = False,
) -> int:
    """Draw a store to a PNG, SVG or PDF file; several runs in one panel; the states of a scenario.

    Parameters
    ----------
    store
        A store that `run`, `sweep`, `surface` or `potential` wrote; for `states` also a scenario.
    out
        The picture to write: a name that ends with .png, .svg or .pdf; must not exist yet (or use
        --overwrite).
    from_
        Draw a run from this time on [s].
    until
        Draw a run up to this time [s].
    title
        Instead of the figure's own title; "" for none.
    size
        Width and height in inches: 8x5. Below 5x4, such as 3.4x2.5, titles and labels are short,
        and notes and further panels are left out.
    dpi
        Dots per inch of a PNG.
    dark
        Draw light on dark.
    overwrite
        Replace an existing picture.
    """
    from ..awaiting import awaited
    from ..figures import drawing
    from .targets import check_picture

    check_picture(out, overwrite)
    look = Look(title, sides(size, "8x5") if size else None, dpi, dark)
    catalogue.check_look(look)
    names = [str(store), *words]
    kind = None
    last = names[-1]
    if words and not last.rstrip("/").endswith(".zarr") and not os.path.lexists(last):
        kind = names.pop()
    stores = [Path(name) for name in names]
    figure = awaited(
        lambda: _drawn(stores, kind, (from_, until), look),
        "the figure is being made (its formulas are compiled first)",
    )
    drawing.write(figure, out, look, overwrite=overwrite)
    return 0


def _drawn(
    stores: list[Path], kind: str | None, window: tuple[float | None, float | None], look: Look
) -> Any:
    """Return the figure of the kind `kind` of some stores, or of a scenario, as matplotlib's Axes.

    `kind` None is the first kind that the store has; `window` is the part of a run, (start, end)
    [s], for stores of runs only. Raises InputError.
    """
    from ..figures import drawing
    from ..library.stored_run import StoredRun
    from ..store import root

    first, *others = stores
    if not others and kind == "states" and not first.is_dir():
        attributes = [{"content": "scenario"}]
    else:
        attributes = [root.attributes(store) for store in stores]
    content = attributes[0].get("content", "run")
    for store, attrs in zip(stores, attributes, strict=True):
        if others and "content" in attrs:
            raise InputError(
                f"several stores are drawn together if all are runs, but `{store}` is not."
            )
    if content == "run":
        run, *more = map(StoredRun, stores)
        start, until = window
        return run.plot(kind or "theta", others=more, start=start, until=until, **vars(look))
    if window != (None, None):
        raise InputError(f"`--from` and `--until` require a run, but `{first}` is a {content}.")
    if content == "scenario":
        return _asymptotic_states(str(first), look)
    if content == "sweep":
        catalogue.check_kind(kind or "class", catalogue.SWEEP_KINDS)
        from ..figures.sweep_map import draw_map
        from ..sweeps.maps import make_map

        chosen = make_map(first, kind or "class")
        return drawing.drawn(lambda: draw_map(chosen), look)
    from .landscape_commands import picture

    catalogue.check_kind(kind or content, [content])
    return picture(first, attributes[0], look)


def _asymptotic_states(scenario: str, look: Look) -> Any:
    """Return the figure `states` of a scenario, as Axes: where its body can end, over lambda.

    |lambda| of the start is marked; without a run there is no path.
    """
    from ..figures import drawing
    from ..figures.stability import states
    from ..figures.style import literal
    from ..landscape import run_landscape
    from ..landscape.landscape_body import top
    from ..runs import forecast
    from ..runs.starting import load

    problem = load(scenario)
    run_landscape.refuse_parts(problem.friction._asdict())
    lam = forecast.at_start(problem).get("jellett", 0.0)
    branches, marks = run_landscape.diagram(top(problem.parameters, problem.system), lam)
    marks["|λ| of the start"] = abs(lam)
    return drawing.drawn(lambda: states(branches, marks, literal(scenario)), look)
