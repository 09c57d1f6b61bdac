"""Finite-time Lyapunov exponents of many tops: a column of ensembles and sweeps that is left out
unless asked for.
"""

import numpy as np
from plans import plan_of

import tippetop as tt
from tippetop.sweeps import chunk


SPINS = [120.0, -1.0, 330.0]
AXES = [
    {"of": "initial.omega3", "values": [100.0, 150.0]},
    {"of": "friction.mu", "values": [0.1, 0.2, 0.3]},
]


def test_each_top_has_the_exponent_of_its_run() -> None:
    """The second is no top, the third lifts off before its time."""
    numbers = {"omega3": SPINS, "mu": [0.3, -1.0, 0.3]}
    rows = tt.ensemble("inverting", numbers, until=0.1, lyapunov=True)
    assert rows.lyapunov.attrs["units"] == "s-1"
    assert np.isnan(rows.lyapunov[1])
    for top in (0, 2):
        end = float(rows.t_end[top])
        alone = tt.derivatives.lyapunov(
            "inverting", {"mu": 0.3}, start={"omega3": SPINS[top]}, until=end, rows=2
        )
        assert rows.lyapunov[top] == float(alone.exponent[-1])
    assert "lyapunov" not in tt.ensemble("inverting", numbers, until=0.01)


def test_a_sweep_keeps_it_where_it_is_named() -> None:
    plan = plan_of(*AXES, keep=["lyapunov"], set={"run": {"until": 0.1}})
    table = chunk.columns(
        chunk.measure(plan.base, plan.columns(np.arange(1)), plan.keep), plan.keep
    )
    assert list(table) == ["status", "lyapunov"]
    assert np.isfinite(table["lyapunov"].values).all()
    assert list(chunk.column_schema(plan.base, plan.keep)) == ["status", "lyapunov"]
    assert "lyapunov" not in chunk.column_schema(plan.base, None)


def test_a_top_whose_contact_opens_has_one_too() -> None:
    rows = tt.ensemble("flying", {"mu": [0.1, 0.3]}, until=0.05, lyapunov=True)
    alone = tt.derivatives.lyapunov("flying", {"mu": 0.3}, until=0.05, rows=2)
    assert float(rows.lyapunov[1]) == float(alone.exponent[-1])
    plan = plan_of(*AXES, scenario="flying", keep=["lyapunov"])
    assert list(chunk.column_schema(plan.base, plan.keep)) == ["status", "lyapunov"]
