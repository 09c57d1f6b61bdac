"""Landscapes on disk. Surfaces are computed and written chunk by chunk, also beyond memory."""

import itertools
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import PlainData
from ..columns import Arrays, Column
from ..progress import Report
from ..store import ledger, zarr3
from ..store.ledger import Ledger
from ..store.provenance import provenance
from ..store.root import new_store
from . import landscape_labels, surface
from .landscape_body import Top


CHUNK = 1024  # rows and columns: 8 MB a variable
FILLS = {"F": None, "z": None, "status": -1}
"""The variables of a stored surface, with their values for missing data: part of the format."""


def write(
    path: Path,
    top: Top,
    x: Any,
    y: Any,
    *,
    chunk: int = CHUNK,
    threads: int | None = None,
    progress: Report = lambda *_: None,
    overwrite: bool = False,
) -> None:
    """Write F [J], z and status of a minimal surface over two momenta into a new store.

    Parameters
    ----------
    path
        The store.
    top, x, y
        As for `minimal_surface`.
    chunk
        Points along each side of a chunk.
    threads
        How many compute; all cores if None.
    progress
        Called as progress(done, of), which count chunks.
    overwrite
        Whether an existing store is replaced.

    Raises
    ------
    InputError
        For axes that do not ascend.
    StoreError
        If `path` exists, or cannot be written.

    Notes
    -----
    17 bytes a point before compression; memory: some 40 bytes a point of one chunk.
    """
    x, y = map(landscape_labels.axis, top.momenta, (x, y))
    axes = landscape_labels.momenta(top, x, y)
    firsts = [range(0, axis.size, chunk) for axis in (x, y)]
    blocks = list(itertools.product(*firsts))

    def chunks() -> Iterator[tuple[str, Arrays]]:
        """Yield the axes, then each block of the surface: key in the store, values by name.

        The first part of a key is the table; "i.j" counts chunks, as zarr names their files.
        """
        yield "axes/0", {name: values for name, (_, values, _) in axes.items()}
        for done, (i, j) in enumerate(blocks, 1):
            minima = surface.minima(top, x[i : i + chunk], y[j : j + chunk], threads)
            variables = surface.variables(top, *minima)
            yield f"surface/{i // chunk}.{j // chunk}", {name: variables[name][1] for name in FILLS}
            progress(done, len(blocks))

    none = np.zeros((0, 0))
    schema = surface.variables(top, none, none, none.astype(np.int8))
    sizes = {name: (v.size, min(chunk, v.size)) for name, (_, v, _) in axes.items()}
    tables = {
        "axes": {
            f"surface/{name}": zarr3.array(Column((name,), *column[1:]), {}, 0)
            for name, column in axes.items()
        },
        "surface": {
            f"surface/{name}": zarr3.array(Column(*schema[name]), sizes, fill)
            for name, fill in FILLS.items()
        },
    }
    about = {
        "title": "minimal surface F = inf V",
        "system": top.system.name,
        "parameters": top.parameters,
    }
    _write(path, "surface", about, tables, chunks(), overwrite)


def write_potential(path: Path, V: Any, attrs: PlainData, *, overwrite: bool = False) -> None:
    """Write the Dataset V of `potential` along z into a new store. Raises StoreError.

    `attrs` are root attributes: those that `cli.landscape_commands.picture` reads, and more.
    """
    columns = {
        str(name): Column(("z",), np.asarray(v), dict(v.attrs))
        for name, v in V.variables.items()
        if v.dims == ("z",)
    }
    arrays = {f"potential/{name}": zarr3.array(column, {}) for name, column in columns.items()}
    values = {name: column.values for name, column in columns.items()}
    chunks = [("potential/0", values)]
    _write(path, "potential", attrs, {"potential": arrays}, chunks, overwrite)


def _write(
    path: Path,
    content: str,
    about: PlainData,
    tables: dict[str, PlainData],
    chunks: Iterable[tuple[str, Arrays]],
    overwrite: bool,
) -> None:
    """Write a new store, complete or not at all.

    `content` is its kind, "surface" or "potential", by which commands tell stores apart; `about`
    are further root attributes, `tables` as for `ledger.header`, and `chunks` pairs of a key and
    values. `info` and `plot` read the attributes.
    """
    attributes = {"content": content, **about, "status": "running", **provenance()}
    header = ledger.header(attributes, tables)
    with new_store(path, overwrite=overwrite) as scratch, Ledger.created(scratch, header) as store:
        for key, values in chunks:
            store.put(key, values)
        store.finish({"status": "finished"})
