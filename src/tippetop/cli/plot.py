"""`tippetop plot`: figures of runs, sweeps, surfaces and potentials, and of a scenario its diagram
of states.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from ..figures import catalogue, drawing
from ..figures.catalogue import Look
from .numbers import Seconds


def plot(
    store: Path,
    *words: Annotated[str, Parameter(help=catalogue.described())],
    out: Path,
    from_: Seconds | None = None,
    until: Seconds | None = None,
    title: str | None = None,
    size: str | None = None,
    dpi: float = 150,
    dark: bool = False,
    overwrite: bool = False,
) -> int:
    """Draw a store to a PNG, SVG or PDF file; several runs in one panel; of a scenario its diagram
    of states.

    Parameters
    ----------
    store
        A store that `run`, `sweep`, `surface` or `potential` wrote; for `states` also a scenario.
    out
        The picture to write: a name that ends with .png, .svg or .pdf; must not exist yet (or say
        --overwrite).
    from_
        Draw a run from this time on [s].
    until
        Draw a run up to this time [s].
    title
        Instead of the figure's own title; "" for none.
    size
        Width and height in inches: 8x5. Below 5x4, such as 3.4x2.5, only the curves are drawn, in
        smaller letters.
    dpi
        Dots per inch of a PNG.
    dark
        Draw light on dark.
    overwrite
        Replace an existing picture.
    """
    from ..awaiting import awaited

    check_picture(out, "--out", overwrite)
    look = Look(title, _size(size), dpi, dark)
    catalogue.check_look(look)
    stores, kind = _parted([str(store), *words])
    figure = awaited(
        lambda: _drawn(stores, kind, (from_, until), look),
        "the figure is being made (its formulas are compiled first)",
    )
    drawing.write(figure, out, look, overwrite=overwrite)
    return 0


def _parted(words: list[str]) -> tuple[list[Path], str | None]:
    """The stores, and the kind of figure, which is the last word if that is no store."""
    last = words[-1]
    named = len(words) > 1 and not last.rstrip("/").endswith(".zarr") and not os.path.lexists(last)
    return [Path(word) for word in (words[:-1] if named else words)], last if named else None


def _drawn(
    stores: list[Path], kind: str | None, window: tuple[float | None, float | None], look: Look
) -> Any:
    """The figure of some stores, or of a scenario."""
    from ..errors import InputError
    from ..figures.window import in_window
    from ..runs import keyframes
    from ..scenario import build
    from ..store import chunks, root

    if len(stores) == 1 and kind == "states" and not stores[0].is_dir():
        return _states(str(stores[0]), look)
    attributes = [root.attributes(store) for store in stores]
    contents = [attrs.get("content", "run") for attrs in attributes]
    if len(stores) > 1 and set(contents) != {"run"}:
        other = next(
            store for store, content in zip(stores, contents, strict=True) if content != "run"
        )
        raise InputError(
            f"several stores are drawn together if all are runs, but `{other}` is not."
        )
    if contents[0] != "run" and window != (None, None):
        raise InputError(f"--from and --until are for runs, but `{stores[0]}` is a {contents[0]}.")
    if contents[0] == "sweep":
        catalogue.check_kind(kind or "class", catalogue.SWEEP_KINDS)
        return drawing.figure_of_sweep(kind or "class", stores[0], look)
    if contents[0] != "run":
        from .landscape import picture

        catalogue.check_kind(kind or contents[0], [contents[0]])
        return picture(stores[0], attributes[0], look)
    kind = kind or "theta"
    catalogue.check_kind(kind)
    parts = []
    for store, attrs in zip(stores, attributes, strict=True):
        groups = chunks.for_figures(store, window)
        if kind == "growth" and root.has_keyframes(attrs):
            groups["trajectory"] = keyframes.rows(store, build.stored(attrs))
        parts.append(in_window(groups, attrs, *window))
    if len(stores) > 1:
        names = [store.name.removesuffix(".zarr") for store in stores]
        runs = [(groups["trajectory"], attrs) for groups, attrs in parts]
        return drawing.several(kind, runs, names, look).get_figure(root=True)
    return drawing.figure_of(kind, *parts[0], look)


def _states(scenario: str, look: Look) -> Any:
    """The diagram of states of the body of a scenario, with lambda of its start."""
    from ..landscape import along_run
    from ..runs import forecast
    from ..scenario import build

    problem = build.load(scenario)
    along_run.refuse_parts(problem.friction._asdict())
    lam = forecast.at_start(problem).get("jellett", 0.0)
    parameters = {name: float(value) for name, value in problem.parameters.items()}
    return drawing.states_of(problem.system.name, parameters, lam, look, scenario)


def _size(text: str | None) -> tuple[float, float] | None:
    """Width and height [inches] from WxH. Raises InputError."""
    from ..errors import InputError

    if text is None:
        return None
    try:
        width, height = (float(side) for side in text.lower().split("x"))
    except ValueError:
        raise InputError(
            f"--size must be width x height in inches, such as 8x5, but is `{text}`."
        ) from None
    return width, height


def check_picture(path: Path | None, option: str, overwrite: bool = False) -> None:
    """Refuse a picture before the run rather than after it; `option` gives its file."""
    from ..errors import InputError, StoreError, refuse_without

    if path is None:
        return

    refuse_without("matplotlib")
    if path.suffix.lower() not in catalogue.ENDINGS:
        raise InputError(f"{option} must end with .png, .svg or .pdf, but is `{path}`.")
    if not path.parent.is_dir():
        raise StoreError(f"`{path}` cannot be written: `{path.parent}` is not a folder.")
    if not os.access(path.parent, os.W_OK):
        raise StoreError(f"`{path}` cannot be written: its folder is read-only.")
    if not overwrite and os.path.lexists(path):
        raise StoreError(f"`{path}` exists: name another picture, or say --overwrite.")
