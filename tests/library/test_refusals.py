"""What cannot be used is refused with one sentence that names it: laws, events, columns, systems,
arguments.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest

import tippetop as tt
from tippetop.mechanics import systems
from tippetop.mechanics.operand import formula
from tippetop.mechanics.units import JOULE, ONE, SECOND_PER_METRE
from tippetop.scenario import reference


BODY: dict[str, Any] = {"m": 0.02, "R": 0.02, "alpha": 0.3, "I1": 2.994e-6, "I3": 3.2e-6, "g": 9.82}


def law(name: str, coefficient: Callable) -> Any:
    """A registered law with one number, mu."""
    body = {
        "mu": tt.extending.number(SECOND_PER_METRE, "a number"),
        "coefficient": formula(coefficient),
    }
    return tt.extending.register(
        type(tt.extending.FrictionLaw)(name, (tt.extending.FrictionLaw,), body)
    )


@pytest.mark.parametrize(
    ("coefficient", "sentence"),
    [
        (
            lambda v2, z, law: -law.mu,
            r"k of the friction law `mine` must be at least 0, .* feeds energy, but is -0.3 s/m",
        ),
        (
            lambda v2, z, law: law.mu * float("nan"),
            "k of the friction law `mine` must be finite, but is nan",
        ),
        (lambda v2, z, law: law.nu, "the formula of the friction law `mine` fails"),
        (
            lambda v2, z, law: None,
            "the formula of the friction law `mine` must return one number, but returns None",
        ),
    ],
)
def test_a_law_that_feeds_energy_or_is_no_number_is_refused(
    coefficient: Callable, sentence: str
) -> None:
    """Before anything is said of the top: no fate, no run.

    Many tops, too: each that is so is invalid.
    """
    mine = law("mine", coefficient)
    with pytest.raises(tt.InputError, match=sentence) as caught:
        tt.run("inverting", mine(0.3), until=0.1)
    assert len(caught.value.sentences) == 1


def test_of_many_tops_those_whose_law_feeds_energy_are_invalid() -> None:
    mine = law("mine", lambda v2, z, law: law.mu)
    base = tt.load("inverting", ["friction.law=mine", "friction.mu=0.3"])
    from tippetop.problem import Problems

    valid, faults = Problems.vary(base, {"friction.mu": np.array([0.3, -0.3])}).check()
    assert mine is type(base.friction)
    assert valid.tolist() == [True, False]
    assert "must be at least 0" in faults[0][1]


@pytest.mark.parametrize(
    ("value", "sentence"),
    [
        (
            lambda s, b: s.z * float("nan"),
            "the formula of the {} must be finite at the start, but is nan",
        ),
        (lambda s, b: None, "the formula of the {} must return one number, but returns None"),
        (lambda s, b: s.nothing, "the formula of the {} fails: AttributeError"),
        (lambda s, b: s.z if s.z < 2 else s.s2, "the formula of the {} fails: "),  # no symbols
        (
            lambda s, b: np.array([s.z]),
            r"the formula of the {} must return one number, but returns array\(",
        ),
    ],
)
def test_a_formula_that_is_no_number_is_named(value: Callable, sentence: str) -> None:
    """It was said that the parameters overflow, or that the equations are too stiff."""
    with pytest.raises(tt.InputError, match=sentence.format("column `mine`")):
        tt.run(
            "inverting",
            until=0.1,
            columns=[tt.extending.Quantity("mine", "q", JOULE, "mine", formula(value))],
        )
    with pytest.raises(tt.InputError, match=sentence.format("event `mine`")):
        tt.run("inverting", until=0.1, events=[tt.extending.Event("mine", "mine", formula(value))])


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"body": 3}, "`body` of `mine` must be a function"),
        ({"angles": 3}, "the records of `mine` must be of the kinds that `System` has"),
        ({"initial": {"theta": 3}}, "but: 'int' object has no attribute"),
        ({"parameters": {}}, r"must take its parameters \(none\), but fail: KeyError"),
        ({"body": lambda parameters, law: 1.0}, "fail: |must give NamedTuples"),
        (
            {"scales": lambda b: (1.0,)},
            r"`scales` of `mine` must give a mass and a length, .* but gives \(1.0,\)",
        ),
        ({"scales": lambda b: (1.0, 0.0)}, "finite and greater than 0, but gives"),
        (
            {"checks": lambda p: None},
            "`checks` of `mine` must give a list of sentences, but gives None",
        ),
        (
            {"checks": lambda p: 1 / 0},
            "`checks` of `mine` must give .*, but fails: ZeroDivisionError",
        ),
        (
            {"start": lambda *a: None},
            "`start` of `mine` must give a record as `angles` is, but gives None",
        ),
        ({"events": (3,)}, "but: 'int' object has no attribute"),
        ({"quantities": (3,)}, "but: 'int' object has no attribute"),
        ({"outlook": 3}, "`outlook` of `mine` must be a function or None, but is 3"),
        ({"phases": {}}, "`phases` of `mine` must have a Phase, but has none"),
    ],
)
def test_a_system_that_has_no_body_is_refused(changes: dict[str, Any], sentence: str) -> None:
    """Where it is registered, and where it is run."""
    system = tt.extending.SYSTEMS["tippe-top"].replace(name="mine", **changes)
    with pytest.raises(tt.InputError, match=sentence):
        tt.extending.register(system)
    with pytest.raises(tt.InputError, match=sentence):
        tt.run(system, tt.friction.Viscous(0.3), parameters=BODY, until=0.1)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"unit": "kg"}, "`unit` of the number `x` must be a Unit, but is 'kg'"),
        (
            {"above": 0, "default": -1},
            "`default` of the number `x` must be finite, greater than 0, but is -1",
        ),
    ],
)
def test_a_number_that_nothing_can_be_is_refused(given: dict[str, Any], sentence: str) -> None:
    with pytest.raises(tt.InputError, match=sentence):
        tt.extending.number(**{"unit": ONE, "long_name": "x", **given})
    assert tt.extending.number(ONE, "x", least=1, most=1).broken(2)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: tt.TippeTop(**{**BODY, "m": 10**400}), "`parameters.m` must be a"),
        (
            lambda: tt.run("inverting", until=1e308, output_step=1e307),
            r"`until` must be at most 1e\+16",
        ),
        (
            lambda: tt.run("inverting", tt.friction.Viscous),
            r"a record such as Viscous\(...\), but is the class",
        ),
        (lambda: tt.run("inverting", 0.3), r"a record such as Viscous\(mu=0.3\), but is 0.3"),
        (lambda: tt.run("inverting", stop=True), "`stop` must be a threading.Event, but is True"),  # type: ignore[arg-type]
        (lambda: tt.run("inverting", progress="x"), "`progress` must be True or False"),  # type: ignore[arg-type]
        (
            lambda: tt.landscapes.minimal_surface("inverting", D=[1e-4, 1e-4], lam=4e-6),
            "`D` must ascend",
        ),
        (
            lambda: tt.landscapes.minimal_surface("inverting", D=[], lam=4e-6),
            "`D` must be a number or",
        ),
        (lambda: tt.derivatives.sensitivities("inverting", ["nu"]), "`nu` must be one of"),
        (
            lambda: tt.extending.Unit("kg furlong"),
            "`symbol` of a Unit must be powers of 1, rad, kg",
        ),
        (lambda: tt.extending.Unit(3), 'such as "kg m2 s-1", but is 3'),  # type: ignore[arg-type]
        (
            lambda: tt.run(
                "inverting",
                until=0.1,
                columns=[tt.extending.Quantity("q", 3, ONE, None, lambda s, b: s.z)],
            ),  # type: ignore[arg-type]
            "`symbol` of the column `q` must be a valid string, but is 3.\n`long_name` of the "
            "column `q` must be a valid string",
        ),
        (
            lambda: tt.run(
                "inverting", until=0.1, events=[tt.extending.Event("e", 3, lambda s, b: s.z)]
            ),  # type: ignore[arg-type]
            "`long_name` of the event `e` must be a valid string, but is 3",
        ),
        (
            lambda: tt.theory.asymptotic_states("inverting", 1e300),
            r"`lam` must give energies .*, but 1e\+300 does not",
        ),
        (
            lambda: tt.compare(3, "inverting"),
            "`others` must be a path or a list of paths, but is 3",
        ),  # type: ignore[arg-type]
        (
            lambda: tt.run("inverting", until=0.01).plot("theta", others=3),
            "`others` must be a list of Runs, but is 3",
        ),  # type: ignore[arg-type]
        (
            lambda: tt.theory.linear_modes(tt.TippeTop(**BODY), tt.friction.Coulomb(0.3), omega3=1),
            "must be finite as v_A goes to 0",
        ),
        (
            lambda: tt.theory.linear_modes("inverting", omega3=1e300),
            r"`omega3` must give rates .*, but 1e\+300 rad/s does",
        ),
    ],
)
def test_an_argument_that_cannot_be_used_is_named(call: Callable, sentence: str) -> None:
    with pytest.raises(tt.InputError, match=sentence):
        call()


def test_what_is_known_by_name_is_changed_by_register_alone() -> None:
    """A law that was put in by hand broke every later run."""
    for registry in (tt.extending.LAWS, tt.extending.SYSTEMS):
        with pytest.raises(TypeError):
            registry["x"] = 3  # type: ignore[index]
    law("mine", lambda v2, z, law: law.mu)
    assert "mine" in tt.extending.LAWS


def test_a_page_says_which_columns_it_lacks() -> None:
    """`run.orientation = true` is no remedy where the run keeps other columns."""
    run = tt.run("inverting", until=0.05, columns=["theta", "orientation"])
    with pytest.raises(
        tt.InputError,
        match=r"a page needs the columns `axis`, `L`, .* but the run has not kept them",
    ):
        run.view()
    needed = "theta orientation axis L omega3 phi nu_x nu_y x y routh jellett"
    assert tt.run("inverting", until=0.05, columns=needed.split()).view()


def test_too_few_rows_are_refused_and_not_pondered() -> None:
    """A reconstruction from two rows in each swing took for ever."""
    with pytest.raises(
        tt.InputError, match=r"some hundred in each nutation, but has [12] between two turnings"
    ):
        tt.theory.reconstruct(tt.run("inverting", until=0.2, output_step=0.01))


class Entry(NamedTuple):
    """An entry point of a package."""

    group: str
    name: str
    record: Any

    def load(self) -> Any:
        return self.record


def test_entry_points_that_cannot_be_taken_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """A name that is taken, another name than that of the record, and what is no record: a sentence
    each.
    """
    body = {"mu": tt.extending.number(ONE, "mu"), "coefficient": lambda v2, z, law: law.mu}
    taken, mine = (
        type(tt.extending.FrictionLaw)(name, (tt.extending.FrictionLaw,), body)
        for name in ("Viscous", "Mine")
    )
    top = tt.extending.SYSTEMS["tippe-top"].replace(name="my-top")
    entries = [
        Entry("tippetop.friction", "viscous", taken),
        Entry("tippetop.friction", "other-name", mine),
        Entry("tippetop.friction", "wrong", 3),
        Entry("tippetop.systems", "other-name", top),
        Entry("tippetop.systems", "wrong", 3),
    ]
    monkeypatch.setattr(
        "importlib.metadata.entry_points", lambda group: [e for e in entries if e.group == group]
    )
    with pytest.warns(UserWarning, match="of tippetop") as warned:
        systems.load_entry_points.__wrapped__()
    assert [str(each.message) for each in warned] == [
        "`viscous` of tippetop.friction is left out: the name of a law must be new, but "
        "`viscous` is that of Viscous.",
        "`other-name` of tippetop.friction is known as `mine`, the key of its class, and by no "
        "other.",
        "`wrong` of tippetop.friction is left out: it must be a FrictionLaw, but is 3.",
        "`other-name` of tippetop.systems is known as `my-top`, the name of its System, and by "
        "no other.",
        "`wrong` of tippetop.systems is left out: it must be a System, but is 3.",
    ]
    assert "my-top" in tt.extending.SYSTEMS


def test_every_list_of_laws_is_the_same() -> None:
    """What a run takes, tt.extending.LAWS, the manual and a sentence; each says of which systems a
    law is.
    """
    named = {section.title: section.text for section in reference.friction()}
    del named["coulomb (without eps)"]
    assert named.keys() == tt.extending.LAWS.keys() >= {"viscous", "none", "modified", "contensou"}
    assert named["contensou"].endswith("Of tippe-top.")
    assert named["modified"].endswith("Of gliding-cylinder.")
    assert len(tt.extending.LAWS) == len(repr(tt.extending.LAWS).splitlines())
    for name, absent in (("tippe-top", "modified"), ("gliding-cylinder", "contensou")):
        laws = [law for law in named if law != absent]
        with pytest.raises(tt.InputError) as refused:
            tt.run("inverting", system=name, friction={"law": "nosuch"})
        sentence = next(s for s in refused.value.sentences if "`friction.law`" in s)
        assert sorted(
            sentence.partition(" one of ")[2].partition(", but")[0].split(", ")
        ) == sorted(laws)


def test_a_start_of_none_is_no_number() -> None:
    """It was a top that stood upright."""
    with pytest.raises(tt.InputError, match=r"`initial\.theta` must be a number, but is None"):
        tt.run("inverting", start={"theta": None}, until=0.1)
