"""Records of one's own that say something wrong, or less than those of the package: a sentence, or
they work.
"""

import dataclasses
from collections import namedtuple
from typing import Any, NamedTuple

import numpy as np
import pytest

import tippetop as tt
from tippetop.mechanics.operand import Vector, atan2, formula, sqrt
from tippetop.mechanics.units import (
    METRE_PER_SECOND,
    ONE,
    SECOND_PER_METRE,
)


BASE = tt.extending.SYSTEMS["tippe-top"]


def registered(**changes: Any) -> str:
    """The name of a tippe top with other fields."""
    tt.extending.register(BASE.replace(name="own-top", **changes))
    return "own-top"


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"I1": 1.0}, "must hold.*`I1` is"),
        ({"mass": 1.0}, r"must name numbers of its body \(m, R, [^f]*\), but has `mass`"),
        ({"m": np.nan}, "must hold finite numbers, but `m` is nan"),
    ],
)
def test_what_is_folded_must_hold(wrong: dict, sentence: str) -> None:
    """Another body was integrated, and every check of the run passed."""
    with pytest.raises(tt.InputError, match=f"`normalised_to` of `own-top` {sentence}"):
        tt.run("inverting", system=registered(normalised_to=BASE.normalised_to | wrong), until=0.1)


def test_a_field_that_is_none_is_named() -> None:
    with pytest.raises(TypeError, match=r"has no argument `outlok`\. Did you mean `outlook`"):
        BASE.replace(outlok=None)


def law(name: str, coefficient: Any) -> Any:
    """A law that is registered."""
    mu = tt.extending.number(SECOND_PER_METRE, "a number", least=0)
    v = tt.extending.number(METRE_PER_SECOND, "a speed", above=0, default=1.0)
    body = {"mu": mu, "v": v, "coefficient": formula(coefficient)}
    return tt.extending.register(
        type(tt.extending.FrictionLaw)(name, (tt.extending.FrictionLaw,), body)
    )


@pytest.mark.parametrize(
    ("coefficient", "sentence"),
    [
        (lambda v2, z, law: law.mu / (1 + sqrt(v2) / law.v), "must be smooth in v2"),
        (lambda v2, z, law: law.mu * (1 + (v2 * v2) ** 0.25 / law.v), "its slope is infinite"),
        (
            lambda v2, z, law: (
                law.mu / (1 + (1 + z) / 2 * v2 + (1 - z) / 2 * (v2 / law.v**2) ** 0.99)
            ),
            r"its slope is infinite there, at cos\(theta\) = 0",
        ),
        (lambda v2, z, law: law.mu / (1 + sqrt(v2 / law.v**2 + 1e-24)), None),
        (lambda v2, z, law: law.mu * sqrt(v2 + law.v**2) / sqrt(v2 + law.v**2), None),
        (lambda v2, z, law: law.mu * atan2(0.1, 1 + v2 / law.v**2), None),  # not of complex numbers
    ],
)
def test_a_law_must_have_a_slope_at_rest(coefficient: Any, sentence: str | None) -> None:
    """Whether the run began was up to rounding: |v_A| at the start."""
    record = law("Mine", coefficient)(mu=0.3)
    if sentence is None:
        assert tt.run("inverting", record, until=0.1).summary.status == "finished"
    else:
        with pytest.raises(tt.InputError, match=sentence):
            tt.run("inverting", record, until=0.1)


def test_numbers_with_a_unit_are_parameters_of_a_law() -> None:
    """Another law was integrated: a number in it is one in the units of the integration."""
    for name, k in (
        ("Fixed", lambda v2, z, law: law.mu / (1 + v2 / 0.01)),
        ("Bare", lambda v2, z, law: 0.3 + 0 * v2),
    ):
        with pytest.raises(
            tt.InputError,
            match=f"`{name.lower()}` must be the same in all units, but at .* parameter",
        ):
            tt.run("inverting", law(name, k)(mu=0.3), until=0.1)
    kept = law("Kept", lambda v2, z, law: law.mu * law.v / sqrt(v2 + 1e-16))  # keeps a root from 0
    assert tt.run("inverting", kept(mu=0.3, v=1e-4), until=0.1).summary.status == "finished"


def test_a_cell_of_a_notebook_may_run_again() -> None:
    """What it defines takes the place of what it defined; the same record with another law would
    keep the old one.
    """
    ends = []
    for share in (1.0, 0.5):
        again = law("Again", lambda v2, z, law, share=share: share * law.mu + 0 * v2)
        name = registered(title=f"{share}")
        ends.append(
            [
                tt.run("inverting", again(mu=mu), system=name, until=1.0).summary.theta_end
                for mu in (0.3, 0.15)
            ]
        )
    assert ends[0][1] == ends[1][0] != ends[0][0]
    assert tt.extending.LAWS["again"] is again
    assert tt.extending.SYSTEMS["own-top"].title == "0.5"
    with pytest.raises(tt.InputError, match="must be new"):
        tt.extending.register(BASE.replace(title="another"))


@pytest.mark.parametrize("name", ["phase", "ball"])
def test_a_column_of_ones_own_is_not_where_the_contact_is(name: str) -> None:
    column = tt.extending.Quantity(name, "p", ONE, "mine", formula(lambda s, b: s.z))
    with pytest.raises(tt.InputError, match=f"where the contact is, but is `{name}`"):
        tt.run("inverting", until=0.1, columns=[column])


class Spin(NamedTuple):
    """A state that is written with a vector."""

    u: Any


PHASE = BASE.phase
VECTORIAL = dataclasses.replace(PHASE.forms["vector"], units=Spin(Vector(ONE, ONE, ONE)))
WITHOUT_POLES = dataclasses.replace(PHASE.forms["vector"], scalars=lambda q, b: Spin(q.uz))
LIFTOFF = next(event for event in BASE.events if event.name == "liftoff")
WITHOUT_WORK = namedtuple("WithoutWork", [n for n in BASE.angles._fields if n != "work"])
WITHOUT_RATE = namedtuple("WithoutRate", [n for n in BASE.angles._fields if n != "theta_dot"])


def without(record: Any) -> Any:
    """`angles` with the fields of another record."""
    return record._make(getattr(BASE.angles, name) for name in record._fields)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"laws": tt.extending.LAWS},
            "`laws` of `own-top` must be a dict of laws by name, but is viscous",
        ),
        (
            {"forms": {"vector": VECTORIAL}, "vectors": {}},
            "of the form `vector` .* must be numbers, .* `u` is Vector",
        ),
        ({"long_names": {}}, "`long_names` of `own-top` must describe each .* but lacks axis, L"),
        (
            {"angles": without(WITHOUT_RATE)},
            "`angles` of `own-top` must have the field `theta_dot`",
        ),
        (
            {"angles": without(WITHOUT_WORK)},
            "the field `work`, .* for the form `vector` integrates it",
        ),
        ({"quantities": (), "integrals": ()}, "`quantities` of `own-top` must have `energy`"),
        ({"vectors": {"axis": ("kx", "ky")}}, "`vectors` .* it lacks kx, ky"),
        (
            {"events": (dataclasses.replace(LIFTOFF, kept=()),)},
            "`kept` of the event `liftoff` .* `lifted_at`",
        ),
        ({"contact": ()}, r"`contact` of `own-top` must be None, but is \(\)"),
        (
            {"vectors": None},
            "`vectors` of `own-top` must be names of variables by name, but is None",
        ),
        (
            {"on_request": None},
            "`on_request` of `own-top` must be a tuple of Quantity records, but is None",
        ),
        ({"undefined_at_poles": ("phi", "twist")}, "must name fields of `angles`, but has `twist`"),
        ({"forms": {"vector": WITHOUT_POLES}}, "need, but lack `s2` and `axis_speed2`"),
        ({"motion": ()}, r"`motion` of `own-top` must be a function or None, but is \(\)"),
    ],
)
def test_what_a_run_would_stumble_over_is_refused_when_it_is_registered(
    changes: dict, message: str
) -> None:
    with pytest.raises(tt.InputError, match=message):
        registered(**changes)
    assert "viscous" in tt.extending.LAWS
    assert "own-top" not in tt.extending.SYSTEMS
