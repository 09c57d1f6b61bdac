"""Changes of phase that the loop makes by itself have the bits of those that Python makes."""

import pytest
import xarray as xr
from touching import BOUNCE

import tippetop as tt
from tippetop.engine import changes, hybrid


VISCOUS = {"law": "viscous", "mu": 0.3}
RUNS = {
    "hops": (("flying",), {"until": 6.0}),
    "bounces": (({**BOUNCE, "friction": VISCOUS, "contact": {"e_n": 0.7}},), {"until": 1.0}),
    "parts": (({**BOUNCE, "friction": {**VISCOUS, "mu_r": 1e-4, "mu_d": 1e-4}},), {"until": 1.0}),
}


@pytest.mark.parametrize("case", RUNS)
def test_the_loop_and_python_change_phases_alike(monkeypatch, case: str) -> None:
    jumps, jump = [], hybrid.HybridDriver._jump
    monkeypatch.setattr(hybrid.HybridDriver, "_jump", lambda *a: jumps.append(a) or jump(*a))
    arguments, options = RUNS[case]
    with monkeypatch.context() as no_program:
        no_program.setattr(changes.Changes, "teach", lambda *_: None)
        by_python, of_all = tt.run(*arguments, **options).datasets(), len(jumps)
    monkeypatch.setattr(changes, "PATIENCE", 1)
    by_loop = tt.run(*arguments, **options).datasets()
    assert len(jumps) - of_all < of_all / 2
    for name, table in by_python.items():
        xr.testing.assert_identical(table.drop_attrs(), by_loop[name].drop_attrs())
