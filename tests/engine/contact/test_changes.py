"""Changes of phase that the loop makes by itself have the bits of those that Python makes."""

import functools

import pytest
import xarray as xr
from nightly import at_night
from touching import BOUNCE, DRILLING, TOSSED

import tippetop as tt
from tippetop.engine import hybrid, jump_programs


VISCOUS, COULOMB = {"law": "viscous", "mu": 0.3}, {"law": "coulomb", "mu": 0.3}
RUNS = {
    "hops": (("flying",), {"until": 6.0}),
    "bounces": (({**BOUNCE, "friction": VISCOUS, "contact": {"e_n": 0.7}},), {"until": 1.0}),
    "parts": (({**BOUNCE, "friction": {**VISCOUS, "mu_r": 1e-4, "mu_d": 1e-4}},), {"until": 1.0}),
    "coulomb": (({**BOUNCE, "friction": COULOMB, "initial": TOSSED},), {"until": 0.3}),
    "drilling": (({**BOUNCE, "friction": DRILLING, "initial": TOSSED},), {"until": 0.1}),
    "sticks": (("cohen-coulomb",), {"until": 0.5}),
    "toy": (("wooden-toy",), {"until": 1.5}),
}


@pytest.mark.parametrize("case", [at_night(case) if case == "bounces" else case for case in RUNS])
def test_the_loop_and_python_change_phases_alike(monkeypatch, case: str) -> None:
    """Also where a jump has branches, takes time, or crosses a turning."""
    # what other tests have made often is rarely learned
    monkeypatch.setattr(hybrid, "jump_of", functools.cache(hybrid.Jump))
    jumps, learn = [], jump_programs.JumpPrograms.learn
    arguments, options = RUNS[case]
    with monkeypatch.context() as no_program:
        no_program.setattr(jump_programs.JumpPrograms, "register", lambda *_: None)
        no_program.setattr(jump_programs.JumpPrograms, "learn", lambda *a: jumps.append(a))
        by_python, of_all = tt.run(*arguments, **options).datasets(), len(jumps)
    monkeypatch.setattr(
        jump_programs.JumpPrograms, "learn", lambda *a: jumps.append(a) or learn(*a)
    )
    monkeypatch.setattr(jump_programs.JumpPrograms, "patience", 1)
    for _ in range(3):
        jumps.clear()
        by_loop = tt.run(*arguments, **options).datasets()  # by known programs
    assert len(jumps) < of_all / 2
    for name, table in by_python.items():
        xr.testing.assert_identical(table.drop_attrs(), by_loop[name].drop_attrs())
