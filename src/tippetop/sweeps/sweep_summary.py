"""The content of a sweep's store, finished or not: counts, worst drift, and faults.

The path of a store goes in; plain data and lines come out, for `tippetop info`.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import PlainData
from ..columns import counted
from ..engine.status import Status
from ..ensembles import ensemble
from ..ensembles.hybrid_tops import checked_tops
from ..store import root
from ..store.root import column
from .plan import Plan
from .store import GROUP, RUNS, chunk_counts


FAULTS = 5  # invalid tops whose faults are printed


def open_sweep(path: str | Path) -> Any:
    """Return the lazy table of a sweep, (top,); its coordinates are the varied numbers.

    Raises StoreError.
    """
    return root.open_group(path, GROUP)


def plan_of(table: Any) -> Plan:
    """Return the plan of a table of a sweep, without `keep` and `runs`.

    They were checked when the sweep began; `keep` may name columns of the user, unknown here.
    """
    return Plan.from_tables(json.loads(table.attrs["plan"]) | {"keep": None, "runs": []})


def gridded(table: Any) -> Any:
    """Return a table of a sweep with the axes of its plan as dimensions.

    Parameters
    ----------
    table : xarray.Dataset
        The table of a sweep, (top,), or some of its columns, as `open` returns it.

    Returns
    -------
    xarray.Dataset
        In memory; the names of the axes are its dimensions and coordinates.
    """
    import xarray as xr

    design = plan_of(table).design
    names = [*design.sizes]
    shape = [*design.sizes.values()]
    axes = {
        axis.of: (axis.of, np.array(axis.numbers), table[axis.of].attrs) for axis in design.grid
    }
    columns = {
        name: (names, np.asarray(values).reshape(shape), values.attrs)
        for name, values in table.variables.items()
        if name not in names
    }
    others = [name for name in table.coords if name not in names]
    return xr.Dataset(columns, axes, table.attrs).set_coords(others)


def report(path: str | Path) -> PlainData:
    """Return the content of a sweep's store, as `info --json` prints it."""
    table = open_sweep(path)
    folder = Path(path)
    attrs = root.root_of(path)
    attrs["chunks"], failed = chunk_counts(folder, attrs)
    status = column(path, table, "status")
    invalid = np.flatnonzero(status == Status.INVALID.code)
    runs = sorted(int(p.name) for p in (folder / RUNS).glob("*") if p.name.isdigit())
    for number in runs:
        root.attributes(folder / RUNS / str(number))  # raises StoreError if it is damaged
    counts = {}
    drift = {}
    for name in map(str, table):
        if name in ("status", "class"):
            meanings = table[name].attrs["flag_meanings"].split()
            counts[name] = counted(column(path, table, name), meanings)
        elif name.startswith("drift_"):
            values = column(path, table, name)
            top = int(np.where(np.isnan(values), -1.0, values).argmax())
            worst = {"worst": float(values[top]), "top": top} if values[top] >= 0 else None
            drift[name.removeprefix("drift_")] = worst
    # root attributes, by the keys that `store._header` gives them
    names = "content title status reason tops chunks dimensions shape chunk plan versions cpu"
    return {
        **{name: attrs[name] for name in names.split()},
        "tops_done": int((status != Status.TODO.code).sum()),
        "counts": counts,
        "drift": drift,
        "faults": faults_of(plan_of(table), invalid) if len(invalid) else [],
        "failed": failed,
        "runs": runs,
    }


def lines(facts: PlainData) -> list[tuple[str, str]]:
    """Return name and text of each line of a report."""
    plan = facts["plan"]
    sizes = zip(facts["dimensions"], facts["shape"], strict=True)
    drawn = ", ".join(axis["of"] for axis in plan["axis"] if "between" in axis)
    axes = [f"{drawn if name == 'sample' else name} ({n})" for name, n in sizes]
    done = f"{facts['tops_done']} of {facts['tops']} tops; chunks: {_text(facts['chunks'])}"
    result = [("status", f"{facts['status']}: {done}"), ("axes", " x ".join(axes))]
    for name, counts in facts["counts"].items():  # `status` is also that of the sweep
        result.append(("ends" if name == "status" else name, _text(counts)))
    worst = [
        f"{name.replace('_', ' ')} {found['worst']:.1e} (top {found['top']})"
        for name, found in facts["drift"].items()
        if found
    ]
    if worst:
        result.append(("drift", f"{', '.join(worst)}: relative, worst of all tops"))
    if facts["runs"]:
        result.append(("runs", ", ".join(f"{RUNS}/{top}" for top in facts["runs"])))
    result += [("fault", fault) for fault in facts["faults"]]
    result += [("failed", f"chunk {k}: {sentence}") for k, sentence in facts["failed"].items()]
    tables = {**plan["scenario"], "versions": facts["versions"]}
    return result + [
        (name, ", ".join(f"{key} = {_plain(value)}" for key, value in values.items()))
        for name, values in tables.items()
        if isinstance(values, dict)
    ]


def _text(counts: dict[str, int]) -> str:
    """Return counts in words: "12 inverted, 3 under way"."""
    return ", ".join(f"{n} {name}" for name, n in counts.items() if n) or "none"


def _plain(value: Any) -> str:
    """Return a value as text; a list without brackets."""
    return ", ".join(map(str, value)) if isinstance(value, list) else str(value)


def faults_of(plan: Plan, invalid: np.ndarray) -> list[str]:
    """Return sentences on why the first of the tops `invalid`, numbers (k,), are invalid."""
    some = invalid[:FAULTS]
    tops = ensemble.vary(plan.base, plan.columns(some))
    faults = tops.checked[1]
    if plan.base.system.is_hybrid:
        faults = faults + checked_tops(tops)[1]  # those of the contact
    return [f"top {some[i]}: {sentence}" for i, sentence in faults]
