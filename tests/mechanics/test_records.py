"""Bodies and laws are the records that formulas take: plain numbers are checked, operands pass."""

import copy
import pickle
from typing import Any

import heyoka as hy
import numpy as np
import pytest
from refusals import refusal

import tippetop as tt
from tippetop.friction import Contensou, Coulomb, Viscous
from tippetop.mechanics.friction import LAWS
from tippetop.mechanics.units import ONE


@pytest.mark.parametrize(
    "operand", [np.array([-1.0, 2.0]), hy.expression("x"), np.longdouble(-1), 1j]
)
def test_operands_of_formulas_pass_unchecked(operand: object) -> None:
    kept = Viscous(mu=operand).mu  # type: ignore[arg-type]
    assert type(kept) is type(operand)


@pytest.mark.parametrize("given", [-1, "-1", float("nan"), None, True, [0.1], "2 kg", 10**400])
def test_a_plain_number_is_checked(given: object) -> None:
    with refusal(r"`friction\.mu` must be"):
        Viscous(mu=given)  # type: ignore[arg-type]


def test_scalars_and_texts_become_floats() -> None:
    for given in ("0.3 s/m", np.float32(0.5), np.array(1), 2):
        assert type(Viscous(mu=given).mu) is float  # type: ignore[arg-type]


def test_every_record_is_pickled_with_its_bits() -> None:
    """Unchecked: internal numbers need not lie in the intervals."""
    for law in LAWS.values():
        for kind in (law, law.given(()), law.with_parts, law.given(()).with_parts):
            record = kind._make(-1.5 for _ in kind._fields)
            again = pickle.loads(pickle.dumps(record))
            assert again == record
            assert type(again) is kind


def height(s: Any, b: Any) -> Any:
    """Return a number of a state."""
    return s.z


def test_a_column_of_the_user_is_pickled_and_compiled_once() -> None:
    column, again = (tt.extending.Quantity("mine", "q", ONE, "a number", height) for _ in range(2))
    assert column == again == pickle.loads(pickle.dumps(column)) == copy.deepcopy(column)


def test_records_of_different_classes_differ() -> None:
    """Though they are tuples of the same numbers."""
    assert Viscous(0.3) != Coulomb(0.3)
    assert Viscous(0.3) == Viscous("0.3 s/m")
    assert len({Viscous(0.3), Coulomb(0.3), Viscous("0.3 s/m")}) == 2


def test_a_keyword_that_is_unknown_names_the_nearest() -> None:
    with pytest.raises(
        TypeError, match=r"Contensou\(\) has no argument `pach`\. Did you mean `patch`"
    ):
        Contensou(0.3, pach=1e-3)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match=r"TippeTop\(.*\) lacks `R`"):
        tt.TippeTop(m=1.0)  # type: ignore[call-arg]


def test_help_lists_the_numbers_with_units_and_intervals() -> None:
    assert "eps : float, optional\n    Regularisation speed eps [m s-1], greater than 0." in (
        Coulomb.__doc__ or ""
    )
