"""Changes of phase that the loop makes by itself have the bits of those that Python makes."""

import math

import pytest
import xarray as xr
from touching import BOUNCE

import tippetop as tt
from tippetop.engine import changes, hybrid


LAWS = {
    "viscous": {"law": "viscous", "mu": 0.3},
    "parts": {"law": "viscous", "mu": 0.3, "mu_r": 1e-4, "mu_d": 1e-4},
}


def run(monkeypatch: pytest.MonkeyPatch, patience: float, e_n: float, law: str) -> tuple:
    """The tables of a run of bounces, and the number of jumps that Python makes."""
    jumps, jump = [], hybrid.HybridDriver._jump
    monkeypatch.setattr(changes, "PATIENCE", patience)
    monkeypatch.setattr(hybrid.HybridDriver, "_jump", lambda *a: jumps.append(a) or jump(*a))
    done = tt.run({**BOUNCE, "contact": {"e_n": e_n}, "friction": LAWS[law]}, until=1.0)
    monkeypatch.undo()
    return done.datasets(), len(jumps)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("e_n", [0.0, 0.7])
def test_the_loop_and_python_change_phases_alike(monkeypatch, e_n: float, law: str) -> None:
    by_python, all_jumps = run(monkeypatch, math.inf, e_n, law)
    by_loop, jumps = run(monkeypatch, 1, e_n, law)
    assert jumps < all_jumps / 2
    for name, table in by_python.items():
        xr.testing.assert_identical(table.drop_attrs(), by_loop[name].drop_attrs())
