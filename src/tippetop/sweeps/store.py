"""A sweep on disk: columns with a row per top, written chunk by chunk.

A `Plan` goes in, a locked `Ledger` comes out, into which `sweep` writes chunks.

A finished store does not depend on who computed what or when: equal sweeps make equal files.
"""

from pathlib import Path

import numpy as np

from ..arguments import PlainData
from ..columns import Column, column
from ..mechanics.units import ONE
from ..scenario.identity import DIGESTS, digests_of
from ..store import ledger, provenance, zarr3
from ..store.ledger import Ledger
from ..store.root import RUNS, finite
from ..store.writer import begin_or_continue
from . import chunk, derived_axes
from .chunk import EVENTS, Rows
from .plan import Plan


GROUP = "sweep"
PER_FILE = 1 << 17  # events


def chunk_counts(path: Path, attrs: PlainData) -> tuple[dict[str, int], dict[str, str]]:
    """Count the chunks that are todo, done and failed; return them, and why chunks failed."""
    state = ledger.read(path, chunks=False)
    failed = {key.rpartition("/")[2]: sentence for key, sentence in state.failed.items()}
    done = sum(key.startswith(f"{GROUP}/") for key in state.chunks)
    todo = -(-attrs["tops"] // attrs["chunk"]) - done - len(failed)
    return {"todo": todo, "done": done, "failed": len(failed)}, failed


def opened(path: str | Path, plan: Plan, overwrite: bool) -> Ledger:
    """Open the store of a sweep to write it, new or continued. Raises StoreError.

    A store that differs in an attribute of `same` is refused: its chunks may have other bits.
    """
    same = ("plan", DIGESTS, "versions", "cpu", "chunk")
    return begin_or_continue(path, lambda: _header(plan), same, overwrite)


def _header(plan: Plan) -> PlainData:
    """Return the header of the store of a sweep, for `Ledger.created`: attributes and arrays.

    It does not depend on who computes, or when. `root.open_group` takes `coordinates`, `columns`,
    `dimensions` and `shape` from the attributes; names with "/" are columns of another table.
    """
    coordinates = _coordinates(plan)
    columns = chunk.column_schema(plan.base, plan.keep)
    sizes = {"top": (plan.n, plan.chunk), "row": (0, PER_FILE), "part": (plan.chunks, 1)}
    tables: dict[str, PlainData] = {}
    for name, each in {**coordinates, **columns}.items():
        path = name if "/" in name else f"{GROUP}/{name}"
        tables.setdefault(path.partition("/")[0], {})[path] = zarr3.array(each, sizes)
    attributes = {
        "content": GROUP,
        "title": f"sweep: {plan.base.system.title}",
        "status": "running",
        "reason": "tops are still to be run",
        "plan": plan.document,
        "tops": plan.n,
        "chunk": plan.chunk,
        "dimensions": list(plan.design.sizes),
        "shape": list(plan.design.sizes.values()),
        "coordinates": list(coordinates),
        "columns": [name for name in columns if "/" not in name],
        **({DIGESTS: digests} if (digests := digests_of(plan.base)) else {}),
        **provenance.provenance(),
    }
    header = ledger.header(finite(attributes), tables)
    header["members"] |= {RUNS: zarr3.group({})} if plan.runs else {}
    return header


def put_events(store: Ledger, part: int, first: int, result: Rows) -> dict[str, int]:
    """Write the events of a chunk of tops, of which `first` is the first.

    Return the rows of the longest part by table, for a commit; empty without events. `part` is the
    number of the chunk: by it `writer.begin_or_continue` drops events of tops that are damaged.
    """
    rows = {name.partition("/")[2]: values for name, values in result.items() if "/" in name}
    if not rows:
        return {}
    rows["top"] += first
    count = len(rows["top"])
    for start in range(0, count, PER_FILE):
        some = {name: values[start : start + PER_FILE] for name, values in rows.items()}
        store.put(f"{EVENTS}/{start // PER_FILE}.{part}", some)
    return {EVENTS: max(count, store.state.rows.get(EVENTS, 0))}


def _coordinates(plan: Plan) -> dict[str, Column]:
    """Return columns without rows for the varied keys: axes, and the keys that derived axes set.

    `sweep` writes chunks with the same keys, those of `Design.numbers` and `Plan.columns`.
    """
    rules = plan.base.rules
    first = np.zeros(1, int)
    about = {
        key: (rules[key].unit, rules[key].long_name)
        if key in rules
        else (ONE, derived_axes.DERIVED[key].long_name)
        for key in {**plan.design.numbers(first), **plan.columns(first)}
    }
    return {key: column(np.zeros(0), *words, ("top",)) for key, words in about.items()}
