"""Small sweeps for tests."""

from typing import Any

import numpy as np


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


def plan_of(*axes: dict[str, Any], scenario: Any = "inverting", **more: Any) -> Any:
    """Return a plan with these axes."""
    from tippetop.sweeps.plan import Plan  # later than the settings of `conftest.py`

    return Plan.from_tables({"scenario": scenario, "axis": list(axes), **more})


def all_numbers(plan: Any) -> dict[str, np.ndarray]:
    """Return the numbers of all tops of a plan."""
    return plan.design.numbers(np.arange(plan.n))
