"""How hard LLVM tries: as an environment variable says; and which equations are compact code."""

from typing import Any

import pytest
from refusals import refusal

from tippetop.engine import integrator, taylor
from tippetop.engine.opt_level import OPT_LEVEL, opt_level
from tippetop.engine.taylor import driver_of, fingerprint
from tippetop.runs import starting


def test_it_is_that_of_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(OPT_LEVEL)
    assert opt_level() == 3
    monkeypatch.setenv(OPT_LEVEL, "1")
    assert opt_level() == 1


@pytest.mark.parametrize("text", ["", "4", "-1", "fast"])
def test_another_word_is_refused_in_a_sentence(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(OPT_LEVEL, text)
    with refusal("`TIPPETOP_OPT_LEVEL` must be 0, 1, 2 or 3, but is"):
        opt_level()


def test_a_run_is_not_resumed_under_another_level(monkeypatch: pytest.MonkeyPatch) -> None:
    driver = driver_of(starting.load("rolling-cylinder"))
    monkeypatch.setenv(OPT_LEVEL, "0")
    quick = fingerprint(driver)
    monkeypatch.setenv(OPT_LEVEL, "3")
    assert fingerprint(driver) != quick


class Reached(BaseException):
    """The integrator would be made now."""


@pytest.mark.parametrize(
    ("preset", "expected"),
    [("leine-glocker-drilling", True), ("leine-glocker-stem", False), ("rolling", False)],
)
def test_equations_so_long_that_llvm_would_take_a_minute_are_compiled_in_compact_mode(
    preset: str, expected: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = []

    def made(*_: Any, compact_mode: bool, **__: Any) -> None:
        found.append(compact_mode)
        raise Reached

    monkeypatch.setattr(integrator.hy, "taylor_adaptive", made)
    monkeypatch.setattr(taylor, "compiled_from", integrator.compiled_from.__wrapped__)
    with pytest.raises(Reached):
        driver_of(starting.load(preset))
    assert found == [expected]
