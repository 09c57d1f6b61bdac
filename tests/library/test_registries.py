"""Registries of laws and systems: who may change them, and where they are listed."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest
from refusals import refusal

import tippetop as tt
from tippetop.mechanics import systems
from tippetop.mechanics.operand import formula
from tippetop.mechanics.units import ONE, SECOND_PER_METRE
from tippetop.scenario import scenario_reference


BASE = tt.extending.SYSTEMS["tippe-top"]


def law(name: str, coefficient: Callable) -> Any:
    """A registered law with one number, mu."""
    body = {
        "mu": tt.extending.number(SECOND_PER_METRE, "a number"),
        "coefficient": formula(coefficient),
    }
    return tt.extending.register(
        type(tt.extending.FrictionLaw)(name, (tt.extending.FrictionLaw,), body)
    )


def test_of_many_tops_those_whose_law_feeds_energy_are_invalid() -> None:
    mine = law("mine", lambda v2, z, law: law.mu)
    base = tt.load("inverting", ["friction.law=mine", "friction.mu=0.3"])
    from tippetop.problem import Problems

    valid, faults = Problems.vary(base, {"friction.mu": np.array([0.3, -0.3])}).checked
    assert mine is type(base.friction)
    assert valid.tolist() == [True, False]
    assert "must be at least 0" in faults[0][1]


def test_what_is_known_by_name_is_changed_by_register_alone() -> None:
    """A law that was put in by hand broke every later run."""
    for registry in (tt.extending.LAWS, tt.extending.SYSTEMS):
        with pytest.raises(TypeError):
            registry["x"] = 3  # type: ignore[index]
    law("mine", lambda v2, z, law: law.mu)
    assert "mine" in tt.extending.LAWS


class Entry(NamedTuple):
    """An entry point of a package."""

    group: str
    name: str
    record: Any

    def load(self) -> Any:
        return self.record


def test_entry_points_that_cannot_be_taken_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each entry point whose name is taken or whose object is not a record has a sentence of its
    own. The name is that of the record, not of the entry point.
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
        "`wrong` of tippetop.friction is left out: it must be a FrictionLaw, but is 3.",
        "`wrong` of tippetop.systems is left out: it must be a System, but is 3.",
    ]
    assert "my-top" in tt.extending.SYSTEMS
    assert "mine" in tt.extending.LAWS


def test_every_list_of_laws_is_the_same() -> None:
    """What a run takes, tt.extending.LAWS, the manual and a sentence; each says of which systems a
    law is.
    """
    named = {section.title: section.text for section in scenario_reference.friction()}
    del named["coulomb (without eps)"]
    assert named.keys() == tt.extending.LAWS.keys() >= {"viscous", "none", "modified", "contensou"}
    assert named["contensou"].endswith("For tippe-top, spheroid, disc.")
    assert named["modified"].endswith("For gliding-cylinder.")
    for name, absent in (("tippe-top", "modified"), ("gliding-cylinder", "contensou")):
        laws = [law for law in named if law != absent]
        with pytest.raises(tt.InputError) as refused:
            tt.run("inverting", system=name, friction={"law": "nosuch"})
        sentence = next(s for s in refused.value.sentences if "`friction.law`" in s)
        assert sorted(
            sentence.partition(" one of ")[2].partition(", but")[0].split(", ")
        ) == sorted(laws)


def test_a_cell_of_a_notebook_may_run_again() -> None:
    """What it defines takes the place of what it defined; the same record with another law would
    keep the old one.
    """
    ends = []
    for share in (1.0, 0.5):
        again = law("Again", lambda v2, z, law, share=share: share * law.mu + 0 * v2)
        tt.extending.register(BASE.replace(name="own-top", title=f"{share}"))
        ends.append(
            [
                tt.run("inverting", again(mu=mu), system="own-top", until=1.0).summary.theta_end
                for mu in (0.3, 0.15)
            ]
        )
    assert ends[0][1] == ends[1][0] != ends[0][0]
    assert tt.extending.LAWS["again"] is again
    assert tt.extending.SYSTEMS["own-top"].title == "0.5"
    with refusal("must be new"):
        tt.extending.register(BASE.replace(title="another"))
