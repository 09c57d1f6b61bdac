"""`tippetop sweep`: run the tops of a plan, and print their fates."""

from __future__ import annotations

import shlex
from functools import partial
from pathlib import Path

from ..arguments import PlainData
from .streams import complain, print_json, report, visible
from .text import table, units_of, warn
from .values import Place, Whole


def sweep(
    plan: Place,
    *,
    out: Place,
    workers: Whole | None = None,
    scheduler: str | None = None,
    overwrite: bool = False,
    as_json: bool = False,
) -> int:
    """Run the many tops of a plan into a store, or continue an unfinished one with the same bits.

    Parameters
    ----------
    plan
        TOML file: a scenario, and the axes along which it varies.
    out
        Store to write or to continue, a zarr folder. A finished one is left as it is.
    workers
        Processes on this machine; by default as many as usable cores. 1 computes in this process.
    scheduler
        Address of a running dask scheduler, such as tcp://host:8786, whose workers compute instead.
    overwrite
        Replace a store that exists, finished or not.
    as_json
        Print the result as one JSON object.
    """
    from .. import errors
    from ..cli import CHUNKS, INTERRUPTED, TERMINATED
    from ..library.variations import sweep as swept
    from ..store import root
    from ..sweeps import sweep_summary

    words = ["tippetop", "sweep", str(plan), "--out", str(out)]
    for name, value in (("--workers", workers), ("--scheduler", scheduler)):
        words += [] if value is None else [name, str(value)]
    again = f"Continue with: {shlex.join(words)}"
    # a damaged store may be overwritten
    here = out.is_dir() and not overwrite
    was_finished = here and root.root_of(out).get("status") == "finished"
    failed: list[str] = []
    try:
        swept(plan, out, workers=workers, scheduler=scheduler, overwrite=overwrite)
    except errors.Unfinished as unfinished:
        failed = unfinished.sentences
    except (KeyboardInterrupt, SystemExit) as stopped:  # not after the chunks under way
        code = INTERRUPTED if isinstance(stopped, KeyboardInterrupt) else TERMINATED
        return complain([f"interrupted; every finished chunk is kept. {again}"], code)
    facts = sweep_summary.report(out)
    if was_finished and not failed:
        report(f"`{out}` was finished: its chunks are checked.")
    describe(facts, as_json)
    if not failed:
        return 0
    return complain([*failed, f"the sweep ended without these chunks. {again}"], CHUNKS)


def describe(report: PlainData, as_json: bool) -> int:
    """Print the content of a sweep's store, a `sweep_summary.report`; return exit code 0."""
    from ..sweeps.sweep_summary import lines

    if as_json:
        return print_json(report)
    print(visible(report["title"]))
    table(lines(report))
    return 0


def examine(tables: PlainData, folder: Path) -> tuple[PlainData, dict[str, str]]:
    """Return the axes, the size and the cost of a plan, and the units of its scenario, for `check`.

    Relative paths in `tables` start at `folder`. `check --json` prints the facts under these names.
    """
    from ..awaiting import awaited
    from ..scenario import build
    from ..sweeps import chunk
    from ..sweeps.measuring import measured
    from ..sweeps.plan import Plan

    plan = Plan.from_tables(tables, folder)
    columns = chunk.column_schema(plan.base, plan.keep).values()
    expected = awaited(
        partial(measured, plan), "some tops are being run (their equations are compiled first)"
    )
    size = round(plan.n * sum(c.values.itemsize for c in columns) / 1e6, 3)
    if "events" not in (plan.keep or ()):  # as many as they are
        expected["megabytes_at_most"] = size
    facts = {
        "tops": plan.n,
        "axes": plan.design.sizes,
        "chunks": plan.chunks,
        "tops_per_chunk": plan.chunk,
        "expected": expected,
        "plan": plan.document,
        "warnings": warn(plan.doubts),
    }
    return facts, units_of(build.resolved(plan.base)) | {"compiling": "s"}
