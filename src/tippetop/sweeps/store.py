"""A sweep on disk: columns with a row per top, written chunk by chunk.

A finished store does not depend on who computed what or when: equal sweeps make equal files.
"""

from pathlib import Path
from typing import Any

import numpy as np

from ..columns import Column
from ..scenario.identity import DIGESTS, digests_of
from ..store import ledger, provenance, zarr3
from ..store.ledger import Ledger
from ..store.root import RUNS, finite
from ..store.writer import begin_or_continue
from . import chunk, derived_axes
from .plan import Plan


GROUP = "sweep"


def chunk_counts(path: Path, attrs: dict[str, Any]) -> tuple[dict[str, int], dict[str, str]]:
    """Count the chunks that are todo, done and failed; return them, and why chunks failed."""
    state = ledger.read(path, chunks=False)
    failed = {key.rpartition("/")[2]: sentence for key, sentence in state.failed.items()}
    done = len(state.chunks)
    todo = -(-attrs["tops"] // attrs["chunk"]) - done - len(failed)
    return {"todo": todo, "done": done, "failed": len(failed)}, failed


def opened(path: str | Path, plan: Plan, overwrite: bool) -> Ledger:
    """Open the store of a sweep to write it, new or continued. Raises StoreError."""
    same = ("plan", DIGESTS, "versions", "cpu", "chunk")
    return begin_or_continue(path, lambda: _header(plan), same, overwrite)


def _header(plan: Plan) -> dict[str, Any]:
    coordinates, columns = _coordinates(plan), chunk.column_schema(plan.base, plan.keep)
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
        "columns": list(columns),
        **({DIGESTS: digests} if (digests := digests_of(plan.base)) else {}),
        **provenance.provenance(),
    }
    sizes = {"top": (plan.n, plan.chunk)}
    arrays = {
        f"{GROUP}/{name}": zarr3.array(column, sizes)
        for name, column in {**coordinates, **columns}.items()
    }
    header = ledger.header(finite(attributes), {GROUP: arrays})
    header["members"] |= {RUNS: zarr3.group({})} if plan.runs else {}
    return header


def _coordinates(plan: Plan) -> dict[str, Column]:
    """Return the varied keys: axes, and the keys that derived axes set."""
    rules, first = plan.base.rules, np.zeros(1, int)
    about = {
        key: (rules[key].unit.symbol, rules[key].long_name)
        if key in rules
        else ("1", derived_axes.DERIVED[key].long_name)
        for key in {**plan.design.numbers(first), **plan.columns(first)}
    }
    return {
        key: Column(("top",), np.zeros(0), {"units": units, "long_name": long_name})
        for key, (units, long_name) in about.items()
    }
