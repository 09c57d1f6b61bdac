"""Landscapes on disk.

Surfaces beyond memory are written chunk by chunk; the ledger lists what is done.

A second call with the same body and axes continues a surface that was interrupted.
"""

import contextlib
import itertools
import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..columns import Column
from ..errors import StoreError
from ..store import files, ledger, zarr3
from ..store.ledger import Ledger
from ..store.provenance import provenance
from ..store.root import new_store
from . import body as bodies
from . import labels, surface


CHUNK = 1024  # rows and columns: 8 MB a variable
GROUP = "surface"
AXES = "axes/0"  # the chunk of the axes in the ledger
SAME = ("system", "parameters", "axes", "chunk")  # attributes of a surface that is continued
BEGUN, FINISHED = {"status": "running"}, {"status": "finished"}


@dataclass(frozen=True)
class Surface:
    """A minimal surface F [J] over x times y, the momenta of a body, in chunks of so many rows and
    columns.
    """

    top: bodies.Top
    x: np.ndarray
    y: np.ndarray
    chunk: int = CHUNK

    @classmethod
    def over(
        cls,
        parameters: Mapping[str, float],
        x: Any,
        y: Any,
        system: str = "tippe-top",
        *,
        chunk: int = CHUNK,
    ) -> "Surface":
        """The surface of a body. Raises ValueError for axes that are empty or do not ascend."""
        top = bodies.top(parameters, system)
        return cls(top, labels.axis(top.momenta[0], x), labels.axis(top.momenta[1], y), chunk)

    def axes(self) -> dict[str, Column]:
        """The axes as columns."""
        return {
            m.symbol: Column(
                (m.symbol,), values, {"units": m.unit.symbol, "long_name": m.long_name}
            )
            for m, values in zip(self.top.landscape.momenta, (self.x, self.y), strict=True)
        }

    def blocks(self) -> Iterator[tuple[int, int]]:
        """The first row and column of every chunk."""
        return itertools.product(
            range(0, self.x.size, self.chunk), range(0, self.y.size, self.chunk)
        )

    def attributes(self) -> dict[str, Any]:
        """The root attributes of the store."""
        return {
            "content": GROUP,
            "title": "minimal surface F = inf V",
            **BEGUN,
            "system": self.top.system.name,
            "parameters": self.top.parameters,
            "axes": {
                name: [float(v.values[0]), float(v.values[-1]), int(v.values.size)]
                for name, v in self.axes().items()
            },
            "chunk": self.chunk,
            **provenance(),
        }

    def header(self) -> dict[str, Any]:
        """The header of the store's ledger: the axes, and F, z and status over them."""
        from tippetop_kernels.minimise import Status

        axes, dims, none = self.axes(), self.top.momenta, np.zeros((0, 0))
        flags = {
            k: v.tolist() if isinstance(v, np.ndarray) else v
            for k, v in labels.flags(Status, "how F is taken").items()
        }
        columns = {
            "F": Column(
                dims, none, dict(zip(("units", "long_name"), labels.NAMES["F"], strict=True))
            ),
            "z": Column(dims, none, {"units": "1", "long_name": "z = cos(theta) where V is least"}),
            "status": Column(dims, none.astype(np.int8), flags),
        }
        sizes = {
            dim: (n, min(self.chunk, n))
            for dim, n in zip(dims, (self.x.size, self.y.size), strict=True)
        }
        members = {name: zarr3.array(axis, {}, 0) for name, axis in axes.items()}
        members |= {
            name: zarr3.array(c, sizes, -1 if name == "status" else None)
            for name, c in columns.items()
        }
        arrays = {f"{GROUP}/{name}": document for name, document in members.items()}
        tables = {
            name: [f"{GROUP}/{column}" for column in of]
            for name, of in (("axes", axes), (GROUP, columns))
        }
        return ledger.header(self.attributes(), {GROUP: zarr3.group({}), **arrays}, tables)


def write(
    path: str | Path,
    wanted: Surface,
    *,
    threads: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Write F [J], z and status of a surface into a store, or continue it; check a finished one.

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
    path = files.own_folder(path)
    files.refuse_inside(path)
    with files.writing(path, "The same command continues it."), _opened(path, wanted) as store:
        blocks = list(wanted.blocks())
        for done, (i, j) in enumerate(blocks, 1):
            key = f"{GROUP}/{i // wanted.chunk}.{j // wanted.chunk}"
            if key not in store.state.chunks:
                values = _values(
                    wanted, slice(i, i + wanted.chunk), slice(j, j + wanted.chunk), threads=threads
                )
                store.check()
                store.put(key, values)
                store.commit()
            if progress is not None:
                progress(done, len(blocks))
        store.check()
        if not store.state.seal:
            store.finish(FINISHED)
    return path


def write_potential(path: str | Path, V: Any, attrs: dict[str, Any]) -> None:
    """Writes the Dataset V of `potential` along z into the group `potential` of a new store.

    Raises StoreError.
    """
    group = "potential"
    columns = {
        f"{group}/{name}": Column(("z",), np.asarray(v), dict(v.attrs))
        for name, v in V.variables.items()
        if v.dims == ("z",)
    }
    arrays = {name: zarr3.array(column, {}) for name, column in columns.items()}
    attributes = {"content": group, **attrs, **BEGUN, **provenance()}
    header = ledger.header(attributes, {group: zarr3.group({}), **arrays}, {group: list(columns)})
    with new_store(path) as scratch, Ledger.created(scratch, header) as store:
        store.put(
            f"{group}/0",
            {name.rpartition("/")[2]: column.values for name, column in columns.items()},
        )
        store.finish(FINISHED)


def _opened(path: Path, wanted: Surface) -> Ledger:
    """Open the store of a surface, new or continued. Raises StoreError, OSError."""
    axes = {name: axis.values for name, axis in wanted.axes().items()}
    if not path.exists():
        with contextlib.ExitStack() as held:
            with new_store(path) as scratch:
                store = held.enter_context(Ledger.created(scratch, wanted.header()))
                store.put(AXES, axes)
                store.commit()
            held.pop_all()
        store.path = path
        return store
    if not ledger.is_ledger(path):
        raise StoreError(f"`{path}` must not exist yet, but does.")
    files.refuse_links(path)
    store, header = Ledger.opened(path), json.loads(json.dumps(wanted.header()))
    try:
        unsound, state = store.unsound(), store.state
        if any(state.header["attributes"].get(key) != header["attributes"][key] for key in SAME):
            raise StoreError(f"`{path}` must be the same surface, but is another: remove it.")
        known = AXES in state.chunks and AXES not in unsound
        for file in state.files(AXES) if known else ():
            place = file.rpartition("/")[0]
            stored = zarr3.decode(store.folder.read(file), header["members"][place])
            if not np.array_equal(stored, axes[place.rpartition("/")[2]]):
                raise StoreError(f"`{path}` must be the same surface, but is another: remove it.")
        # one of other versions is begun again, but for a finished one
        if not known or (state.header != header and not state.seal):
            store.restart(header, [])
        elif unsound:
            store.forget(unsound)
        if AXES not in store.state.chunks:
            store.put(AXES, axes)
            store.commit()
    except BaseException:
        store.release()
        raise
    return store


def _values(
    wanted: Surface, rows: Any, columns: Any, *, threads: int | None
) -> dict[str, np.ndarray]:
    """F, z and status at some rows and columns, in the order in which they are written."""
    F, q, status = surface.minima(wanted.top, wanted.x[rows], wanted.y[columns], threads)
    return {"F": F, "z": surface.argmin(q, status, wanted.top.upright)[0], "status": status}
