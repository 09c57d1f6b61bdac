"""Every law for every system, form and friction law, at random states."""

from collections.abc import Callable

import heyoka as hy
import laws
import numpy as np
import pytest
from limits import assert_near
from nightly import at_night

from tippetop.engine.expressions import equations_of_motion, formulas_of
from tippetop.mechanics.friction import Frictionless
from tippetop.mechanics.operand import leaves, refill
from tippetop.mechanics.systems import SYSTEMS
from tippetop.mechanics.variables import Variables


ASKED = [
    pytest.param(*names, law, id=f"{'-'.join(names)}-{law.__name__}")
    for *names, law in laws.asked(SYSTEMS)
]


@pytest.mark.parametrize(("system", "form", "friction", "law"), ASKED)
def test_law(
    system: str, form: str, friction: str, law: Callable, rng: np.random.Generator
) -> None:
    laws.assert_holds(law, laws.case(SYSTEMS[system], form, friction, rng))


def test_every_law_is_asked_of_every_system_unless_it_says_why_not() -> None:
    """Laws without `only` are asked everywhere; each of the others somewhere, and not
    everywhere.
    """
    everywhere = len(list(laws.cases(SYSTEMS)))
    for law in laws.LAWS:
        asked = sum(param.values[-1] is law for param in ASKED)
        assert 0 < asked < everywhere if hasattr(law, "where") else asked == everywhere, (
            law.__name__
        )


EVERY_FORM = [(name, form) for name, system in SYSTEMS.items() for form in system.forms]


def simplest(system: str) -> str:
    """A friction law for tests that need only one."""
    return "viscous" if SYSTEMS[system].frictional else "none"


def compiled(system: str, form: str, friction: str, rng: np.random.Generator) -> tuple:
    """A case, and heyoka's variables for its state and parameters for its body."""
    case = laws.case(SYSTEMS[system], form, friction, rng)
    q = refill(case.state, iter(hy.make_vars(*(f"q{i}" for i in range(len(case.state))))))
    b = refill(case.body, (hy.par[i] for i in range(len(leaves(case.body)))))
    return case, q, b


def evaluated(expressions: list, q: tuple, case: laws.Case) -> np.ndarray:
    """heyoka's compiled expressions at the states and bodies of a case."""
    lanes = np.array([np.broadcast_to(x, (laws.STATES,)) for x in leaves(case.state)], dtype=float)
    bodies = np.array([np.broadcast_to(x, (laws.STATES,)) for x in leaves(case.body)], dtype=float)
    function = hy.cfunc([e + 0.0 * q[0] for e in expressions], vars=list(q), opt_level=0)
    return function(lanes, pars=bodies[: function.nparams])


@pytest.mark.parametrize(("system", "form", "friction"), list(laws.cases(SYSTEMS)))
def test_formulas_mean_the_same_to_heyoka(
    system: str, form: str, friction: str, rng: np.random.Generator
) -> None:
    """Rates and quantities compiled by heyoka are those of numpy."""
    case, q, b = compiled(system, form, friction, rng)
    used = SYSTEMS[system]
    scalars, numbers = case.form.scalars(q, b), case.form.scalars(case.state, case.body)
    symbolic = [*case.rates(q, b), *(k.formula(scalars, b) for k in used.quantities)]
    numeric = [*case.rates(case.state), *(k.formula(numbers, case.body) for k in used.quantities)]
    found = evaluated(symbolic, q, case)
    for mine, theirs in zip(found, numeric, strict=True):
        theirs = np.broadcast_to(theirs, mine.shape)
        assert_near(mine, theirs, 1e-13 * (1 + np.max(np.abs(theirs))))


@pytest.mark.parametrize(
    ("system", "form"),
    [  # numba takes seconds for each
        at_night(s, f)
        for s, f in EVERY_FORM
        if not s.endswith(("oid", "disc"))  # numba compiles potentials, which they lack
    ],
)
def test_formulas_mean_the_same_inside_numba(
    system: str, form: str, rng: np.random.Generator
) -> None:
    """Rates and the first quantity, called from a compiled function, have the bits of numpy."""
    import numba

    case = laws.case(SYSTEMS[system], form, simplest(system), rng)
    rates, scalars = case.form.rates, case.form.scalars
    quantity = SYSTEMS[system].quantities[0].formula

    @numba.njit(error_model="numpy")
    def inside(q, b):
        return rates(q, b), quantity(scalars(q, b), b)

    for i in range(5):
        q, b = laws.lane(case.state, i), laws.lane(case.body, i)
        found, value = inside(q, b)
        assert tuple(found) == tuple(rates(q, b))
        assert value == quantity(scalars(q, b), b)


DECOMPOSITION = {
    ("tippe-top", "vector"): 101,
    ("tippe-top", "euler"): 138,
    ("rolling-tippe-top", "contact"): 96,
    ("rolling-tippe-top", "vector"): 129,
    ("rolling-tippe-top", "reduced"): 89,
    ("rolling-tippe-top", "euler"): 99,
    ("gliding-heavy-top", "vector"): 86,
    ("gliding-heavy-top", "euler"): 127,
    ("heavy-top", "vector"): 50,
    ("heavy-top", "euler"): 63,
    ("gliding-cylinder", "angle"): 60,
    ("rolling-cylinder", "angle"): 46,
    ("spheroid", "vector"): 134,
    ("spheroid", "euler"): 178,
    ("rolling-spheroid", "vector"): 176,
    ("rolling-spheroid", "euler"): 143,
    ("disc", "vector"): 125,
    ("disc", "euler"): 169,
    ("rolling-disc", "vector"): 167,
    ("rolling-disc", "euler"): 134,
    ("ellipsoid", "vector"): 322,
    ("rolling-ellipsoid", "vector"): 261,
}


@pytest.mark.parametrize(("system", "form"), EVERY_FORM)
def test_taylor_decomposition_has_not_grown(system: str, form: str) -> None:
    """The sizes that were reached: a slowdown shows here without a clock."""
    used = SYSTEMS[system]
    law = used.laws["viscous"] if used.frictional else Frictionless
    equations = equations_of_motion(
        formulas_of(used, form, law), Variables(used.forms[form], orientation=False)
    ).rates
    integrator = hy.taylor_adaptive(
        equations, np.ones(len(equations)), tol=1e-3, compact_mode=True, opt_level=0
    )
    assert len(integrator.decomposition) == DECOMPOSITION[system, form]
