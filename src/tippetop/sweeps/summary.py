"""What is in a sweep's store, finished or not: counts, worst drift, and what is wrong with tops and
chunks.
"""

from pathlib import Path
from typing import Any

import numpy as np

from ..engine.status import Status
from ..ensembles import ensemble, hybrid_tops
from ..errors import InputError, StoreError
from ..store import root
from .plan import Plan
from .store import GROUP, RUNS, chunk_counts


FAULTS = 5  # invalid tops whose faults are printed
LABELS = {"status": "ends"}  # of counts: `status` is that of the sweep


def open_sweep(path: str | Path) -> Any:
    """The table of a sweep, dimension `top`, read when needed; what varies is its coordinates.

    Raises StoreError.
    """
    table = root.open_group(path, GROUP)
    table.attrs["chunks"] = chunk_counts(Path(path), table.attrs)[0]
    return table.set_coords(table.attrs["coordinates"])[table.attrs["columns"]]


def gridded(table: Any) -> Any:
    """A table of a sweep with the axes of its plan as dimensions.

    Parameters
    ----------
    table : xarray.Dataset
        The table of a sweep, (top,), or some of its columns, as `open` gives it.

    Returns
    -------
    xarray.Dataset
        In memory; the names of the axes are its dimensions and coordinates.
    """
    import xarray as xr

    if not isinstance(table, xr.Dataset) or "plan" not in table.attrs:
        raise InputError(
            [
                "`table` must be the table of a sweep, as `open` gives it, but is "
                f"{type(table).__name__}."
            ]
        )
    names, shape = table.attrs["dimensions"], table.attrs["shape"]
    axes = Plan.from_tables(table.attrs["plan"]).design.grid
    grid = xr.Dataset(attrs=table.attrs)
    for name, values in table.variables.items():
        if name not in names:
            grid[name] = (names, np.asarray(values).reshape(shape), values.attrs)
    for axis in axes:
        grid = grid.assign_coords(
            {axis.key: (axis.key, np.array(axis.values), table[axis.key].attrs)}
        )
    return grid.set_coords([name for name in table.coords if name not in names])


def report(path: str | Path) -> dict[str, Any]:
    """What `info --json` says of a sweep."""
    table, attrs, folder = open_sweep(path), root.attributes(path), Path(path)
    status = column(path, table, "status")
    chunks, failed = chunk_counts(folder, attrs)
    done = status != Status.TODO.code
    runs = sorted(int(p.name) for p in (folder / RUNS).glob("*") if p.name.isdigit())
    for top in runs:
        root.attributes(folder / RUNS / str(top))  # raises StoreError: it is damaged
    return {
        **{key: attrs[key] for key in ("content", "title", "status", "reason", "tops")},
        "tops_done": int(done.sum()),
        "chunks": chunks,
        "counts": {
            name: _counts(column(path, table, name), table[name].attrs)
            for name in ("status", "class")
            if name in table
        },
        "drift": {
            str(name).removeprefix("drift_"): _worst(column(path, table, str(name)))
            for name in table
            if str(name).startswith("drift_")
        },
        "faults": _faults(attrs["plan"], np.flatnonzero(status == Status.INVALID.code)),
        "failed": failed,
        "runs": runs,
        **({"steps_by": attrs["steps_by"]} if "steps_by" in attrs else {}),
        **{key: attrs[key] for key in ("dimensions", "shape", "chunk", "plan", "versions", "cpu")},
    }


def lines(facts: dict[str, Any]) -> list[tuple[str, str]]:
    """Name and text of each line of a report."""
    chunks, sizes = facts["chunks"], dict(zip(facts["dimensions"], facts["shape"], strict=True))
    sampled = ", ".join(axis["of"] for axis in facts["plan"]["axis"] if "between" in axis)
    result = [
        (
            "status",
            f"{facts['status']}: {facts['tops_done']} of {facts['tops']} tops; {_text(chunks)} "
            "chunks",
        ),
        (
            "axes",
            " x ".join(
                f"{sampled if name == 'sample' else name} ({n})" for name, n in sizes.items()
            ),
        ),
    ]
    result += [(LABELS.get(name, name), _text(counts)) for name, counts in facts["counts"].items()]
    if any(facts["drift"].values()):  # of a top that has ended
        worst = (
            f"{k.replace('_', ' ')} {v['worst']:.1e} (top {v['top']})"
            for k, v in facts["drift"].items()
            if v
        )
        result.append(("drift", f"{', '.join(worst)}: relative, worst of all tops"))
    if facts["runs"]:
        result.append(("runs", ", ".join(f"{RUNS}/{top}" for top in facts["runs"])))
    if "steps_by" in facts:
        result.append(
            (
                "steps by",
                f"{facts['steps_by']}, where the machine code of a step could not be called",
            )
        )
    result += [("fault", fault) for fault in facts["faults"]]
    result += [("failed", f"chunk {k}: {sentence}") for k, sentence in facts["failed"].items()]
    base = facts["plan"]["scenario"]
    for name in ("parameters", "friction", "contact", "stem", "initial", "run"):
        if name in base:
            result.append((name, ", ".join(f"{k} = {v}" for k, v in base[name].items())))
    return [*result, ("versions", ", ".join(f"{k} = {v}" for k, v in facts["versions"].items()))]


def _text(counts: dict[str, int]) -> str:
    return ", ".join(f"{n} {name}" for name, n in counts.items() if n) or "none"


def column(path: str | Path, table: Any, name: str) -> np.ndarray:
    try:
        return table[name].values
    except Exception as error:  # codecs raise what they like
        raise StoreError(f"`{path}` must hold a readable column `{name}`, but: {error}.") from None


def _counts(values: np.ndarray, attrs: dict[str, Any]) -> dict[str, int]:
    counts = np.bincount(values, minlength=len(attrs["flag_values"]))
    return {
        name: int(n) for name, n in zip(attrs["flag_meanings"].split(), counts, strict=True) if n
    }


def _worst(values: np.ndarray) -> dict[str, Any] | None:
    if np.isnan(values).all():
        return None
    top = int(np.nanargmax(values))
    return {"worst": float(values[top]), "top": top}


def _faults(document: dict[str, Any], invalid: np.ndarray) -> list[str]:
    """Why the first invalid tops are invalid."""
    if not len(invalid):
        return []
    plan, some = Plan.from_tables(document), invalid[:FAULTS]
    tops = ensemble.vary(plan.base, plan.columns(some))
    _, faults = tops.check()
    if plan.base.system.is_hybrid:  # whose contact is asked of each top by itself
        faults += [
            (i, fault)
            for i in np.flatnonzero(tops.valid).tolist()
            for fault in hybrid_tops.faults_of(hybrid_tops.problem_of(tops, i))[:1]
        ]
    return [f"top {some[i]}: {sentence}" for i, sentence in faults]
