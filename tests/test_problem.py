"""One run is the case n = 1 of many, bit by bit; units scale what is computed; a number is
validated in one way.
"""

import dataclasses

import numpy as np
import pytest
from examples import PRESETS
from pydantic import ValidationError
from refusals import refusal

from tippetop.engine.observables import Observables, values_of
from tippetop.errors import InputError
from tippetop.mechanics.operand import leaves
from tippetop.mechanics.systems import SYSTEMS
from tippetop.mechanics.units import KILOGRAM, METRE, SECOND, Scales
from tippetop.problem import Problem, Problems
from tippetop.runs import starting
from tippetop.scenario.schema import scenario_model


N = 12


def columns(base: Problem, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Random numbers for every key that may vary, in sizes from a coin to a table."""
    size = np.geomspace(0.1, 20, N)
    found = {"run.until": rng.uniform(0.5, 5, N)}
    for name, value in base.parameters.items():
        unit = base.system.parameters[name].unit
        found[f"parameters.{name}"] = value * rng.uniform(0.95, 1.05, N) * size ** unit.powers[1]
    for name in base.system.initial:
        if name not in ("psi_dot", "x", "y"):
            found[f"initial.{name}"] = rng.uniform(0.1, 1.5, N)
    for name, value in base.friction._asdict().items():
        found[f"friction.{name}"] = value * rng.uniform(0.5, 2, N)
    return found


def alone(base: Problem, numbers: dict[str, np.ndarray], i: int) -> Problem:
    """The run number i as a problem of its own."""
    plain: dict = {"parameters": {}, "friction": {}, "initial": {}, "run": {}}
    for key, column in numbers.items():
        table, _, name = key.partition(".")
        plain[table][name] = float(column[i])
    return dataclasses.replace(
        base,
        parameters={**base.parameters, **plain["parameters"]},
        friction=base.friction._replace(**plain["friction"]),
        initial=base.system.replaced(base.initial, plain["initial"]),
        until=plain["run"].get("until", base.until),
    )


@pytest.mark.parametrize("system", SYSTEMS)
@pytest.mark.parametrize("precision", ["double", "longdouble", "quad"])
def test_one_run_is_the_case_n_1_of_many(
    system: str, precision: str, rng: np.random.Generator
) -> None:
    """Starts, bodies, units and ends are the same to the bit, whatever stands beside a run: in
    every form.
    """
    preset = starting.load(PRESETS[system])
    for form in preset.system.forms.values():
        base = dataclasses.replace(preset, form=form, precision=precision)
        numbers = columns(base, rng)
        many = Problems(base, numbers, orientation=True)
        for i in range(0, N, 3):
            one = alone(base, numbers, i)
            same = Problems(
                base, {key: column[[i]] for key, column in numbers.items()}, orientation=True
            )
            for whole, single, name in (
                (many.start[:, i], one.start(), "start"),
                (many.pars[:, i], np.array(leaves(one.internal_body), dtype=base.number), "body"),
                (np.array([w[i] for w in many.weights]), np.array(one.weights()), "weights"),
                (np.array([s[i] for s in many.scales]), np.array(list(one.scales)), "scales"),
                (many.start[:, i], same.start[:, 0], "start, n = 1"),
                (many.pars[:, i], same.pars[:, 0], "body, n = 1"),
            ):
                assert np.array_equal(whole, single), (form.name, name, i)
            assert many.end[i] == one.until / float(one.scales.of(SECOND))


@pytest.mark.parametrize(
    "system", ["tippe-top", "rolling-tippe-top", "gliding-heavy-top", "heavy-top"]
)
def test_compiled_values_of_many_are_those_of_one(system: str, rng: np.random.Generator) -> None:
    """What states say is the same for one run and for many, whatever stands beside a run."""
    base = dataclasses.replace(starting.load(PRESETS[system]), orientation=False)
    numbers = columns(base, rng)
    many = Problems(base, numbers)
    found = values_of(many, many.start, np.arange(N))
    for i in range(N):
        one = Observables(alone(base, numbers, i)).evaluate(many.start[:, [i]].T)
        for name, value in one.items():
            assert value[0] == found[name][i], (name, i)


@pytest.mark.parametrize("system", SYSTEMS)
def test_internal_numbers_do_not_depend_on_the_units(system: str) -> None:
    """A body of other mass, size and pace that is the same body in other units has the same
    internal numbers.

    The factors are powers of two, so that this holds to the bit.
    """
    base = starting.load(PRESETS[system])
    mass, length, time = 8.0, 0.25, 2.0

    def scaled(values: dict, rules: dict) -> dict:
        units = {name: rules[name].unit for name in values}
        return {k: v * Scales(mass, length, time).of(units[k]) for k, v in values.items()}

    friction = base.friction._asdict()
    other = dataclasses.replace(
        base,
        parameters=scaled(base.parameters, base.system.parameters),
        friction=type(base.friction)(**scaled(friction, base.law.parameters)),
        initial=scaled(base.initial, base.system.initial),
        until=base.until * time,
    )
    assert np.array_equal(other.start(), base.start())
    assert leaves(other.internal_body) == leaves(base.internal_body)
    for unit, factor in ((KILOGRAM, mass), (METRE, length), (SECOND, time)):
        assert other.scales.of(unit) == factor * base.scales.of(unit)


def test_a_check_changes_nothing_and_says_what_is_wrong() -> None:
    spins = np.array([155.0, np.nan, 160.0, 1e300, 155.0])
    mu = np.array([0.3, 0.3, -1.0, 0.3, 0.3])
    moments = np.array([3.2e-6, 3.2e-6, 3.2e-6, 3.2e-6, 7e-6])
    tops = Problems.vary(
        starting.load("inverting"),
        {"initial.omega3": spins, "friction.mu": mu, "parameters.I3": moments},
    )
    valid, faults = tops.checked
    assert valid.tolist() == [True, False, False, False, False]
    assert [i for i, _ in faults] == [1, 2, 3, 4]
    for (_, sentence), words in zip(
        faults,
        (
            "`initial.omega3` must be finite, but is nan.",
            "`friction.mu` must be finite, at least 0, but is -1.",
            "must stay finite together, but they overflow.",
            "`parameters.I3` must be at most 2*I1",
        ),
        strict=True,
    ):
        assert words in sentence
    assert tops.checked == (valid, faults)


@pytest.mark.parametrize("name", ["x", "y"])
def test_a_start_so_far_away_that_it_would_set_the_steps_is_refused(name: str) -> None:
    """Integrals are scaled by 2^-32, so that they have no say: a start at 1e300 m was one step, 4 %
    wrong.
    """
    base = starting.load("inverting")
    far = Problems.vary(base, {f"initial.{name}": np.array([0.0, 1e6, -1e6, 1e300, -1e12])})
    valid, faults = far.checked
    assert valid.tolist() == [True, True, True, False, False]
    assert all(f"must keep {name} within 4.3e+09 of its unit" in sentence for _, sentence in faults)


def test_a_run_and_a_top_are_refused_in_the_same_words() -> None:
    """Where the contact jams at the start, and where numbers overflow together."""
    for key, good, value in (("initial.nu_x", 0.0, 100.0), ("initial.omega3", 155.0, 1e200)):
        base = starting.load("inverting", ["initial.theta=1.5", "friction.mu=3.0"])
        with pytest.raises(InputError) as caught:
            starting.load("inverting", ["initial.theta=1.5", "friction.mu=3.0", f"{key}={value}"])
        (fault,) = Problems.vary(base, {key: [good, value]}).checked[1]
        assert fault == (1, str(caught.value))
        assert ("jams the contact" in fault[1]) == (key == "initial.nu_x")


@pytest.mark.parametrize("system", SYSTEMS)
def test_every_way_in_refuses_the_same_numbers(system: str) -> None:
    """TOML, arrays, and the system's record: for every number of every system, at its ends and
    beside them.
    """
    base = starting.load(PRESETS[system])
    for key, rule in base.rules.items():
        table, _, name = key.partition(".")
        ends = [e for e in (rule.above, rule.least, rule.below, rule.most) if e is not None]
        values = [
            v for e in (*ends, 0.5) for v in (np.nextafter(e, -1e9), e, np.nextafter(e, 1e9))
        ] + [np.nan, np.inf]
        tops = Problems(base, {key: np.array(values)})
        by_array = {i for i, sentence in tops.checked[1] if sentence.startswith(f"`{key}`")}
        for i, value in enumerate(values):
            wrong = bool(rule.broken(value))
            assert (i in by_array) >= wrong
            tables = {**base.tables, "run": {"until": base.until}, "system": system}
            if base.system.frictional:
                tables["friction"] = {"law": base.law.key, **tables["friction"]}
            tables[table] = {**tables[table], name: float(value)}
            try:
                scenario_model(base.system, base.law).model_validate(tables)
                refused = False
            except ValidationError as error:
                refused = any(e["loc"][-1] == name for e in error.errors())
            assert refused == wrong, (key, value)
            if table == "parameters":
                faults = base.system.faults({**base.parameters, name: value})
                assert any(fault.startswith(f"`{key}` must be finite") for fault in faults) == wrong


def test_what_varies_takes_the_place_of_its_rival() -> None:
    """psi_dot varies over a base that has omega3, and the other way round."""
    by_omega3 = dataclasses.replace(starting.load("inverting"), orientation=False)
    tops = Problems.vary(by_omega3, {"initial.psi_dot": [100.0]})
    assert set(tops.given("initial")) == {"theta", "psi_dot"}
    theta = by_omega3.initial["theta"]
    by_psi_dot = dataclasses.replace(by_omega3, initial={"theta": theta, "psi_dot": 100.0})
    assert np.array_equal(tops.start[:, 0], by_psi_dot.start())
    back = Problems.vary(by_psi_dot, {"initial.omega3": [155.0]})
    assert np.array_equal(
        back.start[:, 0],
        dataclasses.replace(by_omega3, initial={"theta": theta, "omega3": 155.0}).start(),
    )


def test_a_torque_varies_where_the_scenario_has_it() -> None:
    varied = {"friction.mu_r": [1e-5, 1e-4]}
    with refusal(r"Give the scenario a `friction.mu_r`, 0 at least"):
        Problems.vary(starting.load("inverting", []), varied)
    assert Problems.vary(starting.load("inverting", ["friction.mu_r=0"]), varied).n == 2
