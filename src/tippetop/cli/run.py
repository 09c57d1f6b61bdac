"""`tippetop run, resume, replay`: integrate a scenario, store it, draw it, print its summary."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from threading import Event
from typing import Any

from .numbers import Seconds
from .streams import print_json, report


def run(
    scenario: str,
    *,
    out: Path | None = None,
    until: Seconds | None = None,
    set_: list[str] | None = None,
    figure: Path | None = None,
    as_json: bool = False,
    overwrite: bool = False,
    certify: bool = False,
    window: Seconds | None = None,
    columns: str | None = None,
) -> int:
    """Integrate a scenario: a TOML file or the name of a preset.

    Parameters
    ----------
    scenario
        TOML file, or preset (see `tippetop presets`).
    out
        Store to write, a zarr folder; must not exist yet (or say --overwrite).
    until
        End of the run [s, or with a unit: 2min], instead of the scenario's.
    set_
        Change a value: table.key=value, such as initial.theta=0.2. table.key= removes it. May be
        repeated.
    figure
        Draw theta(t) with the nutational band to this PNG, SVG or PDF; must not exist yet (or say
        --overwrite).
    as_json
        Print the result as one JSON object.
    overwrite
        Replace an existing store and an existing picture.
    certify
        Repeat the run in wider numbers and report the difference; exit 4 if the accuracy contract
        is broken.
    window
        Certify only the first so many seconds.
    columns
        Keep these columns alone beside the time: names with commas between them, such as
        theta,normal_force.
    """
    from ..columns import require
    from ..errors import InputError
    from ..runs import attributes, starting
    from ..runs.certificate import check_window
    from ..scenario.doubts import doubts
    from ..store import root
    from .text import following, warn

    check_window(window, "--window")
    if window is not None and not certify:
        raise InputError("--window must stand with --certify, whose part it is.")
    kept = (
        []
        if columns is None
        else [f"run.columns={json.dumps([name.strip() for name in columns.split(',')])}"]
    )
    try:
        problem = starting.load(scenario, [*(set_ or []), *kept], until)
    except InputError:
        _refuse_plan(scenario)
        raise
    warn(doubts(problem))
    if figure is not None:
        from .plot import check_picture

        check_picture(figure, "--figure", overwrite)
        if problem.output == "keyframes":
            raise InputError(
                '`run.output` must keep rows to be drawn by --figure, but is "keyframes".'
            )
        require(("theta",), problem.kept_columns, "what --figure draws")
    if out is None:
        from ..runs.run import solve

        with following() as progress:
            done = solve(problem, progress, keep=figure is not None)
        attrs = root.finite(attributes.attributes(done.progress))
        if certify:
            attrs["certificate"] = _certificate(problem, window, None)
        _picture(figure, attributes.groups(done), attrs, overwrite)
        return _say(attrs, done.seconds, {"figure": figure}, as_json)
    from ..runs.recording import record

    with following() as progress:
        integration, attrs = _interruptible(
            lambda stop: record(problem, out, overwrite=overwrite, progress=progress, stop=stop),
            out,
        )
    if certify:
        attrs["certificate"] = _certificate(problem, window, out)
    _picture(figure, out, attrs, overwrite)
    return _say(attrs, integration.seconds, {"store": out, "figure": figure}, as_json)


def resume(
    store: Path,
    *,
    until: Seconds | None = None,
    accept_other_version: bool = False,
    as_json: bool = False,
) -> int:
    """Continue an interrupted run, or a finished one to a later end; the store equals that of one
    run, bit by bit.

    Parameters
    ----------
    store
        The store of the run.
    until
        A later end of the run [s, or with a unit: 2min]: what is finished is continued too.
    accept_other_version
        Continue also what other versions or another processor began: bits may differ, and the store
        names both.
    as_json
        Print the result as one JSON object.
    """
    from ..runs.resuming import resume as resumed
    from .text import following

    with following() as progress:
        integration, attrs = _interruptible(
            lambda stop: resumed(
                store, progress, until=until, stop=stop, accept_other_version=accept_other_version
            ),
            store,
        )
    return _say(attrs, integration.seconds, {"store": store}, as_json)


def replay(
    store: Path,
    *,
    from_: Seconds,
    until: Seconds,
    step: Seconds,
    out: Path,
    overwrite: bool = False,
    accept_other_version: bool = False,
    as_json: bool = False,
) -> int:
    """Integrate a part of a stored run again, from its nearest keyframe: the rows it would have
    stored, bit by bit.

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
        Store to write, a zarr folder; must not exist yet (or say --overwrite).
    overwrite
        Replace an existing store.
    accept_other_version
        Replay also what other versions or another processor made: bits may differ.
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
    seconds = f"{done['steps']} steps, integrated in {1e3 * done['seconds']:.1f} ms"
    print(
        f"{done['rows']} rows, t = {from_:.9g} to {until:.9g} s, from t = {done['began']:.9g} "
        f"s: {seconds}"
    )
    print(f"store  {out}")
    return 0


def _interruptible(
    work: Callable[[Event], tuple[Any, dict[str, Any]]], store: Path
) -> tuple[Any, dict[str, Any]]:
    """Does the work; where a signal stopped it, says how to continue and exits with 128 + the
    signal's number.
    """
    from ..errors import Interrupted
    from .host import stopping

    with stopping() as stop:
        try:
            return work(stop.event)
        except Interrupted:
            pass
    kept = (
        f"what is done is kept. Continue with: tippetop resume {store}"
        if store.exists()
        else "nothing was stored."
    )
    report(f"interrupted; {kept}")
    raise SystemExit(128 + stop.signal)


def _certificate(problem: Any, window: float | None, store: Path | None) -> dict[str, Any]:
    """The certificate of a problem, also written into the store."""
    from ..runs.certificate import certificate
    from ..store.root import annotate, finite
    from .text import following

    result = finite(certificate(problem, window, following))
    if store is not None:
        annotate(store, {"certificate": result})
    return result


def _picture(figure: Path | None, groups: Any, attrs: dict[str, Any], overwrite: bool) -> None:
    """Draws theta(t) of a run in memory or of a store."""
    if figure is None:
        return
    from ..figures import drawing
    from ..store.chunks import for_figures

    if isinstance(groups, Path):
        groups = for_figures(groups)
    drawing.write(drawing.figure_of("theta", groups, attrs), figure, overwrite=overwrite)


def _say(
    attrs: dict[str, Any], seconds: dict[str, float], places: dict[str, Any], as_json: bool
) -> int:
    """Prints the result; gives the exit code."""
    from ..runs.attributes import headline_of
    from ..runs.results import summary_of
    from .text import summary

    content = summary_of(attrs)
    if as_json:
        print_json(content.to_dict())
    else:
        summary(headline_of(attrs), content, seconds, places)
    if attrs["status"] in ("non-finite", "stalled"):
        report(attrs["reason"])
        return 3
    return _contract(attrs)


def _refuse_plan(scenario: str) -> None:
    """Raises InputError if what should be a scenario is a plan."""
    from ..errors import InputError
    from ..scenario import reading
    from ..sweeps.plan import is_plan

    if is_plan(reading.read(scenario)):
        raise InputError(
            f"`{scenario}` must be a scenario, but is the plan of a sweep: tippetop sweep runs it."
        )


def _contract(attrs: dict[str, Any]) -> int:
    """4 and a sentence for each promise that was broken, else 0."""
    from ..runs.certificate import certificate_violations, contract_violations, suggest_form

    broken = contract_violations(attrs["report"], attrs["tolerance"])
    if "certificate" in attrs:
        broken += certificate_violations(attrs["certificate"])
    if broken and (better := suggest_form(attrs)):
        broken[-1] += f" {better[0].upper()}{better[1:]}"
    for sentence in broken:
        report(f"the accuracy contract is broken: {sentence}")
    return 4 if broken else 0
