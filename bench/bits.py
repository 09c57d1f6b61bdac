"""Print one SHA-256 per table of many runs: two versions of the engine give the same numbers if all
lines are equal.

Usage: ``python bench/bits.py [WORD ...]``, from any checkout; with words, only the cases whose
names contain one. Compare versions on one machine and with the same environment only: processors
round special functions differently.
"""

import hashlib
import json
import sys
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

import tippetop as tt


WIDE = ("inverting", "rolling", "heavy-top")
GRID = np.linspace(-1e-4, 1e-4, 33)


def digest(table: Any) -> str:
    """Return the SHA-256 of the names, types and bytes of the arrays of a Dataset."""
    found = hashlib.sha256()
    for name, values in sorted(table.variables.items()):
        array = np.ascontiguousarray(values.values)
        found.update(f"{name} {array.dtype} {array.shape}".encode())
        found.update(array.tobytes())
    return found.hexdigest()


def of_run(*arguments: Any, **options: Any) -> dict[str, str]:
    """Return the digests of the tables of a run and of its report."""
    run = tt.run(*arguments, **options)
    report = {key: run.attributes[key] for key in ("status", "final_state", "report")}
    tables = {name: digest(table) for name, table in run.datasets().items()}
    return tables | {
        "report": hashlib.sha256(json.dumps(report, sort_keys=True).encode()).hexdigest()
    }


def of_ensemble(**options: Any) -> dict[str, str]:
    """Return the digest of 64 tops, of which some lift off, settle or are invalid."""
    spins = np.linspace(60.0, 190.0, 64)
    spins[7] = np.nan
    return {"tops": digest(tt.ensemble("inverting", {"omega3": spins}, until=8.0, **options))}


def of_surface(*arguments: Any, **options: Any) -> dict[str, str]:
    """Return the digest of a minimal surface."""
    return {"surface": digest(tt.landscapes.minimal_surface(*arguments, **options))}


def cases() -> Iterator[tuple[str, Callable[[], dict[str, str]]]]:
    """Yield the name and the computation of each case."""
    seen = set()
    for name in tt.presets():
        problem = tt.run(name, until=1e-3).problem
        for output in ("steps", "times"):
            yield f"{name} {output}", partial(of_run, name, output=output)
        system = problem.system
        if system.name not in seen and problem.contact is None:
            seen.add(system.name)
            options = {"output": "steps", "until": 1.0, "on_liftoff": "continue"}
            for form in system.forms:
                yield f"{name} {form}", partial(of_run, name, form=form, **options)
    for name in WIDE:
        yield (
            f"{name} longdouble",
            partial(of_run, name, output="steps", precision="longdouble", until=2.0),
        )
    yield (
        "inverting quad",
        partial(of_run, "inverting", output="steps", precision="quad", until=0.1),
    )
    yield (
        "inverting liftoff",
        partial(of_run, "inverting", start={"omega3": 170.0}, output="steps"),
    )
    yield (
        "inverting settled",
        partial(of_run, "inverting", stop_when="settled", until=30.0, output="events"),
    )
    yield "ensemble", of_ensemble
    yield "ensemble settled", partial(of_ensemble, stop_when="settled", orientation=True)
    yield "surface inverting", partial(of_surface, "inverting", D=GRID, lam=np.abs(GRID[16:]))
    yield "surface heavy-top", partial(of_surface, "heavy-top", L3=30 * GRID, Lz=30 * GRID)


def main() -> None:
    """Print the digests of all cases, or of those whose names contain one of the words."""
    words = sys.argv[1:]
    for name, compute in cases():
        if not words or any(word in name for word in words):
            for table, found in compute().items():
                print(f"{name:32} {table:16} {found}", flush=True)


if __name__ == "__main__":
    main()
