"""The fields of a law tell what its contact does; a name with its numbers gives one law."""

import numpy as np
from refusals import refusal

import tippetop as tt
from tippetop.mechanics import friction
from tippetop.mechanics.friction import (
    LAWS,
    FrictionLaw,
    SetValued,
    is_frictionless,
    takes_nothing,
)
from tippetop.mechanics.number import Number, number
from tippetop.mechanics.operand import formula
from tippetop.mechanics.units import ONE, SECOND_PER_METRE


def test_the_numbers_that_are_given_decide_between_two_laws_of_one_name() -> None:
    exact, smooth = (LAWS["coulomb"].given(names) for names in (["mu"], ["mu", "eps"]))
    assert exact.set_valued
    assert not smooth.set_valued
    assert exact.parameters.keys() < smooth.parameters.keys()
    start = {"theta": 0.1, "omega3": 155.0, "nu_x": 0.0}
    for eps, law in ((None, exact), (1e-2, smooth)):
        run = tt.run("inverting", tt.friction.Coulomb(mu=0.3, eps=eps), start=start, until=1e-3)
        assert run.problem.law is law
        assert (run.problem.contact is not None) == law.set_valued


def test_a_record_of_the_package_is_taken_for_its_law() -> None:
    """Exact friction and that of a disc, too."""
    for law in LAWS.values():
        for kind in (law, law.given(())):
            numbers = {name: 1e-3 for name in kind.parameters}
            run = tt.run("inverting", kind(**numbers), start={"nu_x": 0.0}, until=1e-3)
            assert run.problem.law is kind


def test_friction_takes_nothing_where_every_force_and_torque_vanishes() -> None:
    assert is_frictionless(LAWS["coulomb"].given(())(0.0))
    assert not is_frictionless(LAWS["coulomb"].given(())(5e-324))
    disc = LAWS["contensou"](np.array([0.0, 0.0, 1e-300]), 1e-3, np.array([0.0, 1e-300, 0.0]))
    assert takes_nothing(disc).tolist() == [True, False, False]


def test_a_law_that_is_registered_late_lets_the_contact_open_too() -> None:
    """Before, the systems whose contact opens knew the laws of the first run alone."""

    class Late(FrictionLaw):
        mu: Number = number(SECOND_PER_METRE, "mu", least=0)
        coefficient = formula(lambda v2, z, law: law.mu)

    tt.run("flying", until=1e-3)
    try:
        tt.extending.register(Late)
        assert tt.run("flying", Late(0.3), until=1e-3).problem.law is Late
    finally:
        del friction.LAWS["late"]


def test_a_law_of_a_user_is_smooth() -> None:
    class Odd(FrictionLaw):
        mu: Number = number(ONE, "mu", least=0)
        coefficient = formula(lambda v2, z, law: law.mu)
        set_valued = True

    with refusal("`set_valued` of the law `odd` must be left out"):
        tt.extending.register(Odd)


def test_the_set_valued_law_pulls_with_mu_at_every_speed() -> None:
    """k |v| = mu: the law that regularised Coulomb friction tends to."""
    speeds = np.array([1e-6, 0.1, 3.0])
    k = SetValued.coefficient(speeds**2, 0.3, SetValued(0.4))
    np.testing.assert_allclose(k * speeds, 0.4, rtol=1e-15)
