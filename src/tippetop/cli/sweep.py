"""`tippetop sweep`: run the tops of a plan, and print their fates."""

from __future__ import annotations

import re
import sys
from functools import partial
from pathlib import Path
from typing import Any

from .numbers import Whole
from .streams import print_json


def sweep(
    plan: Path,
    *,
    out: Path,
    workers: Whole | None = None,
    scheduler: str | None = None,
    overwrite: bool = False,
    as_json: bool = False,
) -> int:
    """Run the many tops of a plan into a store; the same command continues an unfinished one: the
    same bits.

    Parameters
    ----------
    plan
        TOML file: a scenario, and the axes along which it varies.
    out
        Store to write or to continue, a zarr folder. Of a finished one there is nothing to do.
    workers
        Processes on this machine; by default as many as usable cores. 1 computes in this process.
    scheduler
        Address of a running dask scheduler, such as tcp://host:8786, whose workers compute instead.
    overwrite
        Make a store anew that exists, finished or not.
    as_json
        Print the result as one JSON object.
    """
    from .. import errors
    from ..cli import CHUNKS, INTERRUPTED, TERMINATED, complain
    from ..store import root
    from ..sweeps import summary, sweep
    from .overwrite import remove_store

    again = f"Continue with: {_command(plan, out, workers, scheduler)}"
    if overwrite:
        remove_store(out)
    was_finished = out.is_dir() and root.attributes(out, whole=False).get("status") == "finished"
    try:
        sweep.sweep(plan, out, workers=workers, scheduler=scheduler, progress=True)
        failed = []
    except errors.InputError as error:
        words = (
            re.sub("^`(workers|scheduler)` must", r"--\1 must", sentence)
            for sentence in error.sentences
        )
        raise errors.InputError(list(words)) from None
    except errors.Unfinished as unfinished:
        failed = unfinished.sentences
    except (
        KeyboardInterrupt,
        SystemExit,
    ) as stopped:  # at once: not after the chunks that are being computed
        code = INTERRUPTED if isinstance(stopped, KeyboardInterrupt) else TERMINATED
        return complain([f"interrupted; every finished chunk is kept. {again}"], code)
    report = summary.report(out)
    if was_finished and not failed:
        print(f"tippetop: `{out}` was finished: its chunks are checked.", file=sys.stderr)
    describe(report, as_json)
    return (
        complain([*failed, f"the sweep ended without these chunks. {again}"], CHUNKS)
        if failed
        else 0
    )


def _command(plan: Path, out: Path, workers: int | None, scheduler: str | None) -> str:
    """The command line that continues the sweep."""
    words = ["tippetop", "sweep", str(plan), "--out", str(out)]
    words += ["--workers", str(workers)] if workers is not None else []
    return " ".join(words + (["--scheduler", scheduler] if scheduler is not None else []))


def describe(report: dict[str, Any], as_json: bool) -> int:
    """Prints what is in a sweep's store."""
    from ..sweeps.summary import lines
    from .text import heading, table

    if as_json:
        return print_json(report)
    heading(report["title"])
    table(lines(report))
    return 0


def examine(tables: dict[str, Any], folder: Path, as_json: bool) -> int:
    """Prints what a plan would take."""
    from ..awaiting import awaited
    from ..sweeps import chunk
    from ..sweeps.measuring import measured
    from ..sweeps.plan import Plan
    from .show import entries, plain, units_of
    from .text import table

    plan = Plan.from_tables(tables, folder)
    columns = chunk.column_schema(plan.base, plan.keep).values()
    report: dict[str, Any] = {
        "tops": plan.n,
        "axes": plan.design.sizes,
        "chunks": plan.chunks,
        "tops_per_chunk": plan.chunk,
        "expected": {
            **awaited(
                partial(measured, plan),
                "some tops are being run (their equations are compiled first)",
            ),
            "megabytes_at_most": round(plan.n * sum(c.values.itemsize for c in columns) / 1e6, 3),
        },
        "plan": plan.document,
    }
    if as_json:
        return print_json(report)
    units = units_of(plan.base) | {"compiling": "s"}
    facts = report | report.pop("plan")["scenario"]
    table(
        (name.replace("_", " "), entries(value, units) if isinstance(value, dict) else plain(value))
        for name, value in facts.items()
    )
    return 0
