"""Landscapes on disk. Surfaces beyond memory are written chunk by chunk, and can be continued."""

import itertools
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import PlainData
from ..columns import Column
from ..progress import Report
from ..store import files, ledger, zarr3
from ..store.ledger import Ledger
from ..store.provenance import provenance
from ..store.root import new_store
from ..store.writer import begin_or_continue
from . import landscape_body as bodies
from . import landscape_labels, surface


CHUNK = 1024  # rows and columns: 8 MB a variable
GROUP = "surface"
AXES = "axes/0"  # the chunk of the axes in the ledger
SAME = ("system", "parameters", "axes", "chunk", "versions", "cpu")
RUNNING = {"status": "running"}
FINISHED = {"status": "finished"}


class Surface:
    """A minimal surface F [J] over two momenta of a body, in square chunks of `chunk` points.

    Raises InputError for axes that do not ascend.
    """

    def __init__(
        self,
        parameters: Mapping[str, float],
        x: Any,
        y: Any,
        system: str = "tippe-top",
        *,
        chunk: int = CHUNK,
    ):
        self.top = bodies.top(parameters, system)
        self.chunk = chunk
        self.x, self.y = map(landscape_labels.axis, self.top.momenta, (x, y))

    def axes(self) -> dict[str, Column]:
        """Return the axes as columns."""
        return {
            name: Column((name,), *values[1:])
            for name, values in landscape_labels.momenta(self.top, self.x, self.y).items()
        }

    def header(self) -> PlainData:
        """Return the header of the ledger: the axes, and F, z and status over them."""
        axes = self.axes()
        about = {
            name: [axis.values.size, ledger.digest(axis.values.tobytes())]
            for name, axis in axes.items()
        }
        attributes = {
            "content": GROUP,
            "title": "minimal surface F = inf V",
            **RUNNING,
            "system": self.top.system.name,
            "parameters": self.top.parameters,
            "axes": about,
            "chunk": self.chunk,
            **provenance(),
        }
        none = np.zeros((0, 0))
        schema = surface.variables(self.top, none, none, none.astype(np.int8))
        sizes = {name: (v.values.size, min(self.chunk, v.values.size)) for name, v in axes.items()}
        fills = {"F": None, "z": None, "status": -1}
        tables = {
            "axes": {f"{GROUP}/{name}": zarr3.array(axis, {}, 0) for name, axis in axes.items()},
            GROUP: {
                f"{GROUP}/{name}": zarr3.array(Column(*schema[name]), sizes, fill)
                for name, fill in fills.items()
            },
        }
        return ledger.header(attributes, tables)


def write(
    path: Path,
    wanted: Surface,
    *,
    threads: int | None = None,
    progress: Report | None = None,
    overwrite: bool = False,
) -> Path:
    """Write F [J], z and status of a surface into a store at `path`, or continue it.

    Damaged chunks are computed again.

    Parameters
    ----------
    path
        The store.
    wanted
        The surface.
    threads
        How many compute; all cores if None.
    progress
        Called as progress(done, of), which count chunks.
    overwrite
        Whether an existing store is replaced.

    Returns
    -------
    Path
        Of the store.

    Raises
    ------
    StoreError
        If `path` is another surface or something else, or cannot be written.

    Notes
    -----
    17 bytes a point before compression; memory: some 40 bytes a point of one chunk.
    """
    firsts = [range(0, axis.size, wanted.chunk) for axis in (wanted.x, wanted.y)]
    blocks = list(itertools.product(*firsts))
    with (
        begin_or_continue(path, wanted.header, SAME, overwrite) as store,
        files.writing(path, "The same command without --overwrite continues it."),
    ):
        if AXES not in store.state.chunks:
            store.put(AXES, {name: axis.values for name, axis in wanted.axes().items()})
            store.commit()
        for done, (i, j) in enumerate(blocks, 1):
            key = f"{GROUP}/{i // wanted.chunk}.{j // wanted.chunk}"
            if key not in store.state.chunks:
                x = wanted.x[i : i + wanted.chunk]
                y = wanted.y[j : j + wanted.chunk]
                values = surface.variables(wanted.top, *surface.minima(wanted.top, x, y, threads))
                store.put(key, {name: variable[1] for name, variable in values.items()})
                store.commit()
            if progress is not None:
                progress(done, len(blocks))
        if not store.state.seal:
            store.finish(FINISHED)
    return path


def write_potential(path: str | Path, V: Any, attrs: PlainData, *, overwrite: bool = False) -> None:
    """Write the Dataset V of `potential` along z into a new store. Raises StoreError."""
    group = "potential"
    columns = {
        str(name): Column(("z",), np.asarray(v), dict(v.attrs))
        for name, v in V.variables.items()
        if v.dims == ("z",)
    }
    arrays = {f"{group}/{name}": zarr3.array(column, {}) for name, column in columns.items()}
    attributes = {"content": group, **attrs, **RUNNING, **provenance()}
    header = ledger.header(attributes, {group: arrays})
    with new_store(path, overwrite=overwrite) as scratch, Ledger.created(scratch, header) as store:
        store.put(f"{group}/0", {name: column.values for name, column in columns.items()})
        store.finish(FINISHED)
