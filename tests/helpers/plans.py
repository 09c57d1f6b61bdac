"""A small sweep for tests, and how stores are compared."""

from pathlib import Path

import numpy as np
import zarr


PLAN = """
scenario = "inverting"
set.run.until = 0.5
chunk = 7
runs = [5]
[[axis]]
of = "initial.omega3"
linspace = [100.0, 175.0]
n = 6
[[axis]]
of = "friction.mu"
values = [0.3, 0.1, 0.2, 0.4]
"""


def files(store: Path) -> dict[str, bytes]:
    return {str(p.relative_to(store)): p.read_bytes() for p in sorted(store.rglob("*")) if p.is_file()}


def assert_same(store: Path, other: Path) -> None:
    mine, yours = files(store), files(other)
    assert sorted(mine) == sorted(yours)
    assert [name for name in mine if mine[name] != yours[name]] == []


def chunks(store: Path) -> list[int]:
    """What became of each chunk."""
    return np.asarray(zarr.open_group(store=str(store), mode="r")["chunk_status"]).tolist()


def written(store: Path) -> int:
    """How many chunks are done."""
    return chunks(store).count(1)
