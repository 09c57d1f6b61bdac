"""`tippetop run, resume, replay`: integrate a scenario, store it, draw it, print its summary."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from threading import Event
from typing import Any

from ..arguments import PlainData
from ..errors import InputError
from .streams import complain, print_json, report, visible
from .text import table, warn
from .values import Place, Seconds


def run(
    scenario: str,
    *,
    out: Place | None = None,
    until: Seconds | None = None,
    set_: list[str] | None = None,
    figure: Place | None = None,
    as_json: bool = False,
    overwrite: bool = False,
    certify: bool = False,
) -> int:
    """Integrate a scenario: a TOML file or the name of a preset.

    Parameters
    ----------
    scenario
        TOML file, or preset (see `tippetop presets`).
    out
        Store to write, a zarr folder; must not exist yet (or use --overwrite).
    until
        End of the run [s, or with a unit: 2min], instead of the scenario's.
    set_
        Change a value: table.key=value, such as initial.theta=0.2. table.key= removes it. May be
        repeated.
    figure
        Draw theta(t) with the nutational band to this PNG, SVG or PDF; must not exist yet (or use
        --overwrite).
    as_json
        Print the result as one JSON object.
    overwrite
        Replace an existing store and an existing picture.
    certify
        Repeat the run in wider numbers and report the difference; exit 4 if the accuracy contract
        is broken.
    """
    from ..columns import require
    from ..runs import attributes, starting
    from ..runs.certificate import certificate
    from ..runs.cost import bar_of_run
    from ..runs.recording import record
    from ..runs.run import solve
    from ..scenario.doubts import doubts
    from ..store.chunks import for_figures
    from ..store.root import annotate, finite

    problem = starting.load(scenario, set_, until)
    warn(doubts(problem))
    if figure is not None:
        from .targets import check_picture

        check_picture(figure, overwrite)
        if problem.output == "keyframes":
            raise InputError('`--figure` requires rows, but `run.output` is "keyframes".')
        require(("theta",), problem.kept_columns, "what --figure draws")
    with bar_of_run() as progress:
        if out is None:
            done = solve(problem, progress, keep=figure is not None)
            attrs = attributes.attributes(done.progress)
            seconds = done.seconds
        else:
            attrs, seconds = _interruptible(
                lambda stop: record(
                    problem, out, overwrite=overwrite, progress=progress, stop=stop
                ),
                out,
            )
    if certify:
        with bar_of_run() as progress:
            attrs["certificate"] = finite(certificate(problem, progress=progress))
        if out is not None:
            annotate(out, {"certificate": attrs["certificate"]})
    if figure is not None:
        from ..figures import drawing

        groups = attributes.datasets(done, attrs) if out is None else for_figures(out)
        drawing.write(drawing.axes_of("theta", groups, attrs), figure, overwrite=overwrite)
    return _print(attrs, seconds, {"store": out, "figure": figure}, as_json)


def resume(
    store: Place,
    *,
    until: Seconds | None = None,
    accept_other_version: bool = False,
    as_json: bool = False,
) -> int:
    """Continue an interrupted run, or a finished one to a later end, with the bits of one run.

    Parameters
    ----------
    store
        The store of the run.
    until
        A later end of the run [s, or with a unit: 2min]: a finished run is continued too.
    accept_other_version
        Continue a run of other versions or of another processor: bits may differ, and the store
        names both.
    as_json
        Print the result as one JSON object.
    """
    from ..runs.cost import bar_of_run
    from ..runs.resuming import resume as resumed

    with bar_of_run() as progress:
        attrs, seconds = _interruptible(
            lambda stop: resumed(
                store, progress, until=until, stop=stop, accept_other_version=accept_other_version
            ),
            store,
        )
    return _print(attrs, seconds, {"store": store}, as_json)


def replay(
    store: Place,
    *,
    from_: Seconds,
    until: Seconds,
    step: Seconds,
    out: Place,
    overwrite: bool = False,
    accept_other_version: bool = False,
    as_json: bool = False,
) -> int:
    """Make rows of a part of a stored run from its nearest keyframe, with the bits of the run.

    Parameters
    ----------
    store
        The store of a finished run: with keyframes (run.output = "keyframes"), or so short that its
        start is near.
    from_
        Time of the first row [s, or with a unit: 10ms].
    until
        Time of the last row [s].
    step
        Time between two rows [s].
    out
        Store to write, a zarr folder; must not exist yet (or use --overwrite).
    overwrite
        Replace an existing store.
    accept_other_version
        Replay a run of other versions or of another processor: bits may differ.
    as_json
        Print the result as one JSON object.
    """
    from ..runs.replay import into_store
    from ..sampling import EvenTimes

    done = into_store(
        store,
        EvenTimes(step, until, from_),
        out,
        overwrite=overwrite,
        accept_other_version=accept_other_version,
    )
    if as_json:
        return print_json(done)
    print(
        f"{done['rows']} rows, t = {from_:.9g} to {until:.9g} s, from t = {done['began']:.9g} "
        f"s: {done['steps']} steps, integrated in {1e3 * done['seconds']:.1f} ms\nstore  {out}"
    )
    return 0


def _interruptible(
    work: Callable[[Event], tuple[Any, PlainData]], store: Path
) -> tuple[PlainData, dict[str, float]]:
    """Return the attributes and the seconds of a run; on a signal exit with 128 + its number.

    work(stop) makes the run in `store`, as `record` does: it returns the Integration and the
    attributes, or raises Interrupted after `stop` is set.
    """
    from ..errors import Interrupted
    from ..store.root import root_of
    from .host import stopping

    with stopping() as (stop, signals):
        try:
            integration, attrs = work(stop)
            return attrs, integration.seconds
        except Interrupted:
            pass
    kept = "nothing was stored."
    if store.exists():
        t_end = root_of(store)["report"]["t_end"]
        kept = f"kept until t = {t_end:.9g} s. Continue with: tippetop resume {store}"
    raise SystemExit(complain([f"interrupted; {kept}"], 128 + signals[0]))


def _print(
    attrs: PlainData, seconds: dict[str, float], places: dict[str, Any], as_json: bool
) -> int:
    """Print the result of a run; return its exit code.

    Parameters
    ----------
    attrs
        The root attributes of its store.
    seconds
        Times of compiling and of integrating.
    places
        Paths that were written, by their name in the output.
    as_json
        Whether to print one JSON object.
    """
    from ..runs.attributes import headline_of
    from ..runs.certificate import broken_promises
    from ..runs.results import summary_of
    from ..runs.summary import lines

    content = summary_of(attrs)
    if as_json:
        print_json(content.to_dict())
    else:
        print(visible(headline_of(attrs)))
        files = [(name, str(place)) for name, place in places.items() if place is not None]
        table([*lines(content, seconds), *files])
    if attrs["status"] in ("non-finite", "stalled"):
        return complain([attrs["reason"]], 3)  # `cli.PHYSICS`
    broken = broken_promises(attrs)
    for sentence in broken:
        report(sentence)
    return 4 if broken else 0  # `cli.ACCURACY`
