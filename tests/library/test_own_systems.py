"""Records of one's own that say something wrong, or less than those of the package: a sentence, or
they work.
"""

import dataclasses
from collections import namedtuple
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import pytest

import tippetop as tt
from tippetop.ensembles import outcomes
from tippetop.mechanics import friction, systems
from tippetop.mechanics.contact.body import Touch
from tippetop.mechanics.form import Integral
from tippetop.mechanics.operand import Vector, atan2, formula, sqrt
from tippetop.mechanics.units import (
    JOULE,
    METRE_PER_SECOND,
    NEWTON,
    ONE,
    PER_SECOND,
    SECOND_PER_METRE,
)


BASE = tt.extending.SYSTEMS["tippe-top"]


@pytest.fixture(autouse=True)
def _registered_here_only(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setattr(friction, "LAWS", friction.LAWS)
    known = dict(systems.SYSTEMS), dict(friction.LAWS), dict(friction.SLIP)
    yield
    for registry, before in zip(
        (systems.SYSTEMS, friction.LAWS, friction.SLIP), known, strict=True
    ):
        registry.clear()
        registry.update(before)


def registered(**changes: Any) -> str:
    """The name of a tippe top with other fields."""
    tt.extending.register(BASE.replace(name="own-top", **changes))
    return "own-top"


@pytest.mark.parametrize("formula", [lambda s, b: 1 / 0, lambda s, b: s.z if s.z < 2 else s.s2])
@pytest.mark.parametrize("field", ["quantities", "events"])
def test_a_formula_that_fails_is_named(field: str, formula: Any) -> None:
    """One raises with numbers, the other branches, which symbols cannot."""
    what = {
        "quantities": tt.extending.Quantity("mine", "q", ONE, "a number", formula),
        "events": tt.extending.Event("mine", "something happens", formula),
    }[field]
    name = registered(**{field: (*getattr(BASE, field), what)})
    with pytest.raises(tt.InputError, match=r"the formula of the .* `mine` fails: "):
        tt.run("inverting", system=name, until=0.1)


@pytest.mark.parametrize("wrong", [{"g": 1.0}, {"I1": 1.0}, {"c": 0.0}])
def test_what_is_folded_must_hold(wrong: dict) -> None:
    """Another body was integrated, and every check of the run passed."""
    name = registered(normalised_to={**BASE.normalised_to, **wrong})
    with pytest.raises(
        tt.InputError, match=f"`normalised_to` of `own-top` must hold.*`{next(iter(wrong))}` is"
    ):
        tt.run("inverting", system=name, until=0.1)


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"mass": 1.0}, r"must name numbers of its body \(m, R, [^f]*\), but has `mass`"),
        ({"friction": 1.0}, r"must name numbers of its body \(m, R, [^f]*\), but has `friction`"),
        ({"m": "1"}, "must hold finite numbers"),
        ({"m": np.nan}, "must hold finite numbers, but `m` is nan"),
    ],
)
def test_what_is_folded_must_be_numbers_of_the_body(wrong: dict, sentence: str) -> None:
    with pytest.raises(tt.InputError, match=f"`normalised_to` of `own-top` {sentence}"):
        tt.run(
            "inverting", system=registered(normalised_to={**BASE.normalised_to, **wrong}), until=0.1
        )


def test_a_turning_without_a_sense_is_an_event_as_any_other() -> None:
    turning = tt.extending.Event("turning", "theta' = 0", formula(lambda s, b: s.z_dot))
    run = tt.run("inverting", system=registered(events=(turning,)), until=0.5)
    assert run.summary.event_counts.turning > 10
    assert f"{run.summary.event_counts.turning} logged" in str(run)


def test_an_integral_without_a_start_begins_at_zero() -> None:
    vector = BASE.forms["vector"]
    rate = formula(lambda q, carried, b: 0 * q.uz + b.m)
    more = dataclasses.replace(
        vector, integrals=(*vector.integrals, Integral("passed", JOULE, "m t", rate))
    )
    name = registered(forms={**BASE.forms, "vector": more})
    run, plain = tt.run("inverting", system=name, until=0.5), tt.run("inverting", until=0.5)
    np.testing.assert_array_equal(run.trajectory.theta, plain.trajectory.theta)


def test_tops_without_a_spin_have_a_class(monkeypatch: pytest.MonkeyPatch) -> None:
    values = outcomes.values_of

    def without(*given: Any) -> dict[str, np.ndarray]:
        return {name: value for name, value in values(*given).items() if name != "omega3"}

    axes = {"initial.theta": [0.2, 0.3]}
    expected = tt.ensemble("heavy-top", axes, until=0.2)["class"].values
    monkeypatch.setattr(outcomes, "values_of", without)
    assert (tt.ensemble("heavy-top", axes, until=0.2)["class"].values == expected).all()


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


def test_a_law_must_have_a_slope_at_rest() -> None:
    """Whether the run began was up to rounding: |v_A| at the start."""
    rough = law("Rough", lambda v2, z, law: law.mu / (1 + sqrt(v2) / law.v))
    with pytest.raises(tt.InputError, match="k of the friction law `rough` must be smooth in v2"):
        tt.run("inverting", rough(mu=0.3), until=0.1)
    rooted = law("Rooted", lambda v2, z, law: law.mu * (1 + (v2 * v2) ** 0.25 / law.v))
    with pytest.raises(tt.InputError, match="its slope is infinite there"):
        tt.run("inverting", rooted(mu=0.3), until=0.1)
    upright = law(
        "Upright",
        lambda v2, z, law: law.mu / (1 + (1 + z) / 2 * v2 + (1 - z) / 2 * (v2 / law.v**2) ** 0.99),
    )
    with pytest.raises(tt.InputError, match=r"its slope is infinite there, at cos\(theta\) = 0"):
        tt.run("inverting", upright(mu=0.3), until=0.1)
    for name, tiny in (("Smooth", 1e-2), ("Sharp", 1e-12)):
        smooth = law(name, lambda v2, z, law, v_0=tiny: law.mu / (1 + sqrt(v2 / law.v**2 + v_0**2)))
        assert tt.run("inverting", smooth(mu=0.3), until=0.1).summary.status == "finished"
    # the slope of this one is 0 but for rounding
    even = law("Even", lambda v2, z, law: law.mu * sqrt(v2 + law.v**2) / sqrt(v2 + law.v**2))
    mus = np.linspace(0.01, 1.0, 100)
    assert (
        tt.ensemble("inverting", {"friction.mu": mus}, even(mu=0.3), until=1e-3).status == 1
    ).all()
    angle = law(
        "Angle", lambda v2, z, law: law.mu * atan2(0.1, 1 + v2 / law.v**2)
    )  # which has no imaginary numbers
    assert tt.run("inverting", angle(mu=0.3), until=0.1).summary.status == "finished"


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


def test_an_end_by_an_event_of_ones_own_is_named() -> None:
    for ends in ("fallen", "liftoff"):
        tilted = tt.extending.Event(
            "tilted", "theta = 30 deg", formula(lambda s, b: s.z - 0.75**0.5), ends=ends
        )
        run = tt.run("inverting", until=8.0, events=[tilted])
        assert run.summary.reason.startswith(f"`tilted` ended the run as {ends} at t = 4.872")
    lifted = tt.run(
        "inverting", start={"omega3": 300.0}, events=[tilted], until=2.0, output_step=0.01
    )
    assert ("tilted" in lifted.summary.reason) == (abs(lifted.summary.theta_end - np.pi / 6) < 1e-6)


def test_a_top_with_more_in_its_body_is_shown() -> None:
    Windy: Any = namedtuple("Windy", (*Touch._fields, "W"))  # type: ignore[misc]
    name = registered(
        parameters={**BASE.parameters, "W": tt.extending.number(NEWTON, "wind", default=0.0)},
        body=lambda p, f: Windy(*BASE.body({k: v for k, v in p.items() if k != "W"}, f), p["W"]),
        body_units=lambda f: Windy(*BASE.body_units(f), NEWTON),
    )
    run = tt.run("inverting", system=name, until=0.2, parameters={"W": 1e-3})
    assert "<html" in run.view().text


class Spin(NamedTuple):
    """A state that is written with a vector."""

    u: Any


PHASE = BASE.phase
UP = tt.extending.Event("up", "z = 1/2", formula(lambda s, b: s.z - 0.5))
VECTORIAL = dataclasses.replace(PHASE.forms["vector"], units=Spin(Vector(ONE, ONE, ONE)))
WITHOUT_POLES = dataclasses.replace(PHASE.forms["vector"], scalars=lambda q, b: Spin(q.uz))
LIFTOFF = next(event for event in BASE.events if event.name == "liftoff")
WITHOUT_WORK = namedtuple("WithoutWork", [n for n in BASE.angles._fields if n != "work"])
WITHOUT_RATE = namedtuple("WithoutRate", [n for n in BASE.angles._fields if n != "theta_dot"])


def test_quantities_of_a_top_are_columns_of_runs_whose_contact_changes() -> None:
    rate = tt.extending.Quantity(
        "z_rate", "z'", PER_SECOND, "rate of cos(theta)", lambda s, b: s.z_dot
    )
    name = registered(quantities=(*BASE.quantities, rate))
    rows = tt.run("inverting", {"law": "coulomb", "mu": 0.3}, system=name, until=0.05).trajectory
    np.testing.assert_allclose(
        rows.z_rate, -rows.theta_dot * np.sin(rows.theta), rtol=1e-9, atol=1e-12
    )


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


def test_a_heavy_top_may_end_by_an_event_called_liftoff() -> None:
    ending = dataclasses.replace(UP, name="above", ends="liftoff")
    run = tt.run(
        "heavy-top", start={"theta": 0.3}, events=[ending], on_liftoff="continue", until=0.3
    )
    assert run.summary.status == "finished"
