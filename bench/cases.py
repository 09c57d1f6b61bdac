"""The named cases: each gives a table of numbers, and writes it to results/NAME.json."""

import json
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from . import (
    case_ensemble,
    case_precision,
    case_startup,
    case_storing,
    case_surface,
)
from .case_precision import Comparison
from .measure import machine


COMPARISONS = {
    "inversion": Comparison("The canonical inversion", "inverting", 10.0, 10.0, "quad", True),
    "rolling": Comparison("A long rolling run", "rolling", 400.0, 50.0, "longdouble", False),
    "heavy-top": Comparison(
        "A heavy top with a fixed tip", "heavy-top", 100.0, 10.0, "longdouble", True
    ),
    "cylinder": Comparison(
        "An eccentric cylinder that glides", "gliding-cylinder", 4.0, 4.0, "longdouble", True
    ),
}
CASES: dict[str, Callable[[bool], dict[str, Any]]] = {
    **{
        name: partial(case_precision.compare, comparison)
        for name, comparison in COMPARISONS.items()
    },
    "ensemble": case_ensemble.compare,
    "surface": case_surface.compare,
    "storing": case_storing.compare,
    "startup": case_startup.compare,
}


def carry_out(name: str, quick: bool, folder: Path) -> None:
    """Runs a case, writes its JSON."""
    before, clock = machine(), time.perf_counter()
    found = CASES[name](quick)
    took = time.perf_counter() - clock
    whole = {"case": name, "quick": quick, "machine": before, "took": round(took, 1), **found}
    path = folder / f"{name}.json"
    path.write_text(json.dumps(whole, indent=1, default=float) + "\n", encoding="utf-8")
    print(f"{name:12}{took:6.0f} s  {path}", flush=True)
