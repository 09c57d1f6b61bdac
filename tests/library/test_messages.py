"""Every call that cannot be carried out raises one message that names what is wrong."""

import dataclasses
import math
import sys
from collections import namedtuple
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from examples import CANONICAL as BODY

import tippetop as tt
from tippetop.extending import Event, Kept, Quantity, Unit, number, register
from tippetop.landscapes import minimal_surface, potential
from tippetop.mechanics.operand import Vector, atan2, formula, sqrt
from tippetop.mechanics.units import JOULE, METRE_PER_SECOND, ONE, SECOND_PER_METRE
from tippetop.theory import least_energy, linear_modes, reconstruct, regime, thresholds


TOP, CYLINDER = tt.TippeTop(**BODY), tt.Cylinder(m=1.0, R=1.0, alpha=0.1, I=0.4, g=9.8)
VISCOUS, MODIFIED = tt.friction.Viscous(0.3), tt.friction.Modified(mu=0.1, v_k=0.1)
SPINS = {"omega3": [100.0, 120.0]}
MOMENTA = {"D": 3e-4, "lam": 4e-6}
SYSTEM = tt.extending.SYSTEMS["tippe-top"]
PHASE = SYSTEM.phase
LIFTOFF = next(event for event in SYSTEM.events if event.name == "liftoff")
BAD_TABLES = {"system": "tippe-top", "parameters": 3, "friction": {"law": "viscous", "mu": 0.3}}
run = partial(tt.run, "inverting", until=0.05)
Call = Callable[[], Any]


@cache
def made() -> tt.Run:
    """A run of 0.2 s with 21 rows."""
    return run(until=0.2, output_step=0.01)


def rising(s: Any, b: Any) -> Any:
    return s.z - 0.5


def event(**fields: Any) -> Call:
    """A run with an event that has these fields."""
    own = {"name": "e", "long_name": "e", "formula": rising}
    return lambda: run(events=[Event(**{**own, **fields})])


def column(**fields: Any) -> Call:
    """A run with a column that has these fields."""
    own = {"name": "q", "symbol": "q", "unit": JOULE, "long_name": "q", "formula": rising}
    return lambda: run(columns=[Quantity(**{**own, **fields})])


def system(**fields: Any) -> Call:
    """The registration of a tippe top with other fields."""
    return lambda: register(SYSTEM.replace(**{"name": "mine", **fields}))


def misplaced(key: str) -> dict[str, Any]:
    """The tables of a run, with `form` in the wrong one or `until` in none."""
    tables = {"system": "tippe-top", "parameters": BODY, "friction": {"law": "viscous", "mu": 0.3}}
    return {**tables, "run": {"until": 0.05}} | {key: {"until": 0.05, "form": "euler"}}


def law(coefficient: Any = lambda v2, z, law: law.mu, name: str = "Mine", **body: Any) -> Any:
    """A law with numbers mu and v, not registered."""
    body = {
        "mu": number(SECOND_PER_METRE, "a number"),
        "v": number(METRE_PER_SECOND, "a speed", above=0, default=1.0),
        "coefficient": formula(coefficient) if callable(coefficient) else coefficient,
        **body,
    }
    return type(tt.extending.FrictionLaw)(name, (tt.extending.FrictionLaw,), body)


def under(coefficient: Any, v: float = 1.0, **scenario: Any) -> Call:
    """A run under a law."""
    return lambda: run(register(law(coefficient))(mu=0.3, v=v), **scenario)


def folded(**numbers: float) -> Call:
    """A run of a tippe top whose equations are folded with other numbers."""
    changed = {"name": "mine", "normalised_to": SYSTEM.normalised_to | numbers}
    return lambda: run(system=register(SYSTEM.replace(**changed)).name)


def replaced(**fields: Any) -> Call:
    """A run of a problem with other fields."""
    return lambda: tt.run(dataclasses.replace(tt.load("inverting"), **fields))


class Spin(NamedTuple):
    """A state that is written with a vector."""

    u: Any


def without(name: str) -> Any:
    """Return `angles` without a field."""
    names = [field for field in SYSTEM.angles._fields if field != name]
    return namedtuple("Without", names)(*(getattr(SYSTEM.angles, field) for field in names))


VECTORIAL = dataclasses.replace(PHASE.forms["vector"], units=Spin(Vector(ONE, ONE, ONE)))
WITHOUT_POLES = dataclasses.replace(PHASE.forms["vector"], scalars=lambda q, b: Spin(q.uz))

CALLS: list[tuple[Call, str]] = [
    # the scenario and the options of a run
    (lambda: tt.run(TOP, until=1.0), "must have a friction law, such as Viscous"),
    (lambda: tt.run(3.0), "the first argument must be a body"),
    (lambda: tt.run("nothing"), "neither a TOML file nor a preset"),
    (lambda: run(0.3), r"a record such as Viscous\(mu=0.3\), but is 0.3"),
    (lambda: run(tt.friction.Viscous), r"a record such as Viscous\(...\), but is the class"),
    (lambda: run(until=1e308, output_step=1e307), r"`until` must be at most 1e\+16"),
    (lambda: run(mu=0.2), r"no argument `mu`. Numbers are given by table, .*friction=dict\(mu=0.3"),
    (lambda: run(untill=3), r"run\(\) has no argument `untill`. Did you mean `until`\?"),
    (lambda: run(events=5), "`events` must be"),
    (lambda: run(columns=[3]), "`columns` must be"),
    (lambda: run(output="keyframes"), "`out` must be given"),
    (lambda: run(start=0.1), "^`start` must be a mapping"),
    (lambda: tt.run(misplaced("run")), "key `run.form`; did you mean `form`"),
    (lambda: tt.run(misplaced("until")), "key `until`; did you mean `run.until`"),
    (lambda: run(start={"theta": None}), r"`initial\.theta` must be a number, but is None"),
    (lambda: tt.run(BAD_TABLES, parameters={"m": 0.2}, until=0.1), "`parameters`"),
    (lambda: run(output_step=0.1, output_times=[0.0]), "^`output_step` must be given alone"),
    (lambda: run(stop=True), "`stop` must be a threading.Event, but is True"),
    (lambda: run(progress="x"), "`progress` must be True or False"),
    (
        lambda: tt.run(tt.load("inverting"), until=1.0, output_step=0.1),
        "a Problem must be the only argument, but `until`, `output_step` is given too",
    ),
    (lambda: tt.load("inverting", "run.until=1"), "`assignments` must be a list of texts"),
    (lambda: run(output_times=[0.0, [1.0]]), "`output_times` must be a number or an array of"),
    # bodies and laws
    (lambda: tt.TippeTop(m=1, R=1), r"TippeTop\(m, R, .* g\) lacks `alpha`, `I1`, `I3`, `g`"),
    (lambda: tt.friction.Viscous(0.1, mu=0.2), r"Viscous\(mu\) was given too many arguments"),
    (lambda: tt.friction.Viscous(mu=True), "`friction.mu` must be a number, but"),
    (lambda: tt.TippeTop(m=1, R=1, alfa=0.3, I1=1, I3=1, g=9), "`alfa`. Did you mean `alpha`"),
    (lambda: tt.friction.Coulomb(mu=-1, eps=0), r"mu` must be at least 0.0.*\n.*eps` must be gr"),
    (lambda: TOP.body(3), "`law` must be the record of a friction law"),
    (lambda: linear_modes(TOP, "coulomb", omega3=3.0), r"such as Coulomb\(\.\.\.\), but is 'c"),
    (lambda: linear_modes(TOP, MODIFIED, omega3=10.0), "but has modified"),
    (lambda: linear_modes(TOP, tt.friction.Coulomb(0.3), omega3=1), "finite as v_A goes to 0"),
    # paths
    (lambda: tt.open(3), "must be a path"),
    (lambda: made().save(3), "must be a path"),
    (lambda: tt.sweep(3, "sweep.zarr"), "must be a path"),
    (lambda: run(out=3), "must be a path"),
    (lambda: tt.compare(3, "inverting"), "`others` must be a path or a list of paths, but is 3"),
    (lambda: tt.compare("film.csv", 3), "`reference` must be a scenario or a run, but is 3"),
    (lambda: tt.fit("film.csv", TOP, "friction.mu"), "`scenario` must be a scenario or a run, but"),
    (
        lambda: tt.fit("film.csv", "inverting", [1]),
        "`free` must be names such as friction.mu, parameters.I1, but is",
    ),
    (
        lambda: tt.fit("film.csv", "inverting", "friction.mu", noise=True),
        "`noise` must be a finite number, but is True",
    ),
    # numbers
    (lambda: regime(TOP, math.nan), "must be a (finite )?number"),
    (lambda: regime(TOP, 10**400), "must be a (finite )?number"),
    (lambda: linear_modes(TOP, omega3="3 kg"), "`omega3` must be in rad s-1 .*but is"),
    (lambda: linear_modes("inverting", omega3=1e300), r"`omega3` must give rates .*, but 1e\+300"),
    (lambda: reconstruct(made(), period=1e-300), "`period` must be longer than the 0.01 s"),
    (lambda: made().certify(0), "`window` must be greater than 0"),
    (lambda: least_energy(TOP, [0.1, 4], 1.0), r"`theta` must lie in \[0, pi\], but is 4"),
    (lambda: least_energy(TOP, 1.0, 1e300), r"`lam` must give energies .*, but 1e\+300"),
    (lambda: least_energy(TOP, [1, 2], [1, 2, 3]), r"shapes that broadcast.*\(2,\) and \(3,\)"),
    # what has no such theory or landscape
    (lambda: thresholds("rolling-cylinder"), "but is that of the system rolling-cylinder"),
    (lambda: thresholds(CYLINDER), "or a Spheroid or a Disc, but is Cylinder"),
    (lambda: regime(CYLINDER, 1.0), "must be a TippeTop"),
    (lambda: reconstruct(run(start={"theta_dot": 1.0})), "`initial.theta_dot` must be 0"),
    (lambda: reconstruct(3), "`run` must be a Run, but is 3"),
    (lambda: reconstruct(made()), r"some hundred in each nutation, but has [12] between two"),
    (lambda: reconstruct(tt.run("rolling-cylinder", until=0.1)), "must be one of a tippe top"),
    (lambda: minimal_surface(TOP, L3=1, lam=4e-6), r"`L3` is no .* D and lam.\n`D` must be given"),
    (lambda: minimal_surface(CYLINDER, **MOMENTA), "must be one of tippe-top|must be a TippeTop"),
    (lambda: potential(TOP, [0.1, 1.5], **MOMENTA), r"`z` must lie in \[-1, 1\], but is 1.5"),
    (lambda: potential(TOP, 0.5, D=math.nan, lam=4e-6), "`D` must be a finite number, but is nan"),
    (lambda: tt.derivatives.sensitivities("inverting", ["nu"]), "`nu` must be one of"),
    # ensembles
    (lambda: tt.ensemble("inverting", {"spin": [1.0]}), "`spin` must be one of"),
    (
        lambda: tt.ensemble("inverting", SPINS | {"initial.omega3": [155.0, 150.0]}),
        r"`initial\.omega3` must be given once, but is given as `omega3` and",
    ),
    (lambda: tt.ensemble("inverting", SPINS, threads="x"), "`threads` must be a whole number"),
    (lambda: tt.ensemble("inverting", SPINS, orientation=[1]), "`orientation` must be True or"),
    *(
        (
            lambda given=given: tt.ensemble("inverting", SPINS, **given),
            f"`{name}` must not be given in an ensemble: it keeps no",
        )
        for given in ({"output": "events"}, {"output_step": 0.1})
        for name in given
    ),
    (
        lambda: tt.ensemble("inverting", SPINS, columns=["theta"]),
        "`columns` must be Quantity records",
    ),
    # figures and files
    (lambda: made().plot(3), "the kind of figure must be one of .* but is `3`"),
    (lambda: made().plot("theta", "theta"), "must end with the format"),
    (lambda: made().plot("theta", others=3), "`others` must be a list of Runs, but is 3"),
    (lambda: made().plot(size=[1]), r"`size` must be two numbers, but is \[1\]"),
    (lambda: made().plot("theta", "t.png", overwrite=1), "`overwrite` must be True or False"),
    (
        lambda: run(columns=["theta", "orientation"]).view(),
        r"a page must have `L`, .*: add the missing columns",
    ),
    # user-defined events and columns
    *(
        (of(name=name), sentence)
        for of in (event, column)
        for name, sentence in {
            **dict.fromkeys(["turning", "ball"], "must be a new name"),
            "a/b": "must be letters, digits and _",
            "work_lo": "must not be one of",
        }.items()
    ),
    (
        column(symbol=3, long_name=None),
        "`symbol` of the column `q` must be a valid string, but is 3.\n`long_name` of the column",
    ),
    (lambda: run(events=[Event("q", "q", rising)], columns=[Quantity("q", "q", ONE, "q", rising)]),
     "given twice"),
    (event(kept=(Kept("a", "middle", "x"),)), "must be 'first', 'last' or 'count', but is 'mid"),
    (event(kept=(Kept("a", "first", "x"), Kept("a", "count", "x"))), "`a` is given twice"),
    (event(kept=(Kept("first_equator", "first", "x"),)), "new name"),
    (event(ends="finished"), "must be a word other than"),
    (event(direction=2), "must be -1, 0 or 1"),
    (event(formula=None), "must be a function"),
    (event(sense=1), "`sense` .* is given in `turning` and `e`"),
    *(
        (of(formula=formula(value)), f"the formula of the {name} {sentence}")
        for of, name in ((event, "event `e`"), (column, "column `q`"))
        for value, sentence in (
            (lambda s, b: s.z * math.nan, "must be finite at the start, but is nan"),
            (lambda s, b: None, "must return one number, but returns None"),
            (lambda s, b: np.array([s.z]), r"must return one number, but returns array\("),
            (lambda s, b: s.nothing, "fails: AttributeError"),
            (lambda s, b: s.z if s.z < 2 else s.s2, "fails: "),  # no symbols
        )
    ),
    # user-defined numbers and units
    (
        lambda: number(ONE, "x", above=0, default=-1),
        "`default` of the number `x` must be finite, greater than 0, but is -1",
    ),
    (lambda: Unit("kg furlong"), "`symbol` of a Unit must be powers of 1, rad, kg"),
    # user-defined laws
    *(
        (under(lambda v2, z, law: -law.mu, contact=contact), "at least 0, .* feeds energy, but is")
        for contact in (None, {"e_n": 0.5})
    ),
    (under(lambda v2, z, law: law.mu * math.nan), "k of the friction law `mine` must be finite"),
    (under(lambda v2, z, law: law.mu / (1 + sqrt(v2) / law.v)), "must be smooth in v2"),
    (under(lambda v2, z, law: law.mu * (1 + (v2 * v2) ** 0.25)), "slope is infinite|same in all"),
    (
        under(lambda v2, z, law: law.mu * (1 + (1 - z) * (v2 / law.v**2) ** 0.99)),
        r"its slope is infinite there, at cos\(theta\) = ",
    ),
    (under(lambda v2, z, law: law.mu / (1 + v2 / 0.01)), "must be the same in all units, but at"),
    (under(lambda v2, z, law: 0.3 + 0 * v2), "must be the same in all units, but at .* parameter"),
    *(
        (lambda record=record: (register(law()), register(record)), message)
        for record, message in (
            (law(name="Other", key="mixed"), "must be new, but `mixed` is that of Mixed"),
            (law(key=""), "must be letters"),
            (law(coefficient=3), r"must have a function `coefficient\(v2, z, law\)`, but has 3"),
            (law(law=number(ONE, "x", default=0)), "must not be named `law`"),
            (3, "`record` must be a System or a class of FrictionLaw"),
        )
    ),
    (lambda: run(law()(0.3)), "must be registered"),
    # user-defined systems
    (lambda: SYSTEM.replace(outlok=None), r"has no argument `outlok`\. Did you mean `outlook`"),
    (lambda: tt.run(SYSTEM.replace(name="mine", body=3), VISCOUS, parameters=BODY), "`body` of"),
    (system(body=3), "`body` of `mine` must take .*, but fails: TypeError"),
    (system(body=lambda parameters, law: 1.0), "must take .* a NamedTuple, but gives 1"),
    (system(angles=without("theta_dot")), "`angles` of `mine` must have .*, but lacks theta_dot"),
    (system(parameters={}), r"must take its parameters \(none\) .*, but fails: KeyError"),
    (system(scales=lambda b: (1.0, 0.0)), "finite and greater than 0, but gives"),
    (system(checks=lambda p: None), "`checks` .* must give a list of sentences, but gives None"),
    (system(start=lambda *a: None), "`start` .* must give a record as `angles` is, but gives None"),
    (system(events=(3,)), r"`events` of a Phase must be a tuple of Event, but is \(3,\)"),
    (system(events=(dataclasses.replace(LIFTOFF, kept=()),)), "`lifted_at` .* none in liftoff"),
    (system(forms=[VECTORIAL]), r"`forms` of a Phase must be a Form or a dict, but is \[Form"),
    (system(quantities=(), integrals=()), "`quantities` of `mine` must have `energy`"),
    (system(phases={}), "`phases` of `mine` must be a dict of Phase, but is {}"),
    (system(phases={"x": VECTORIAL}), "must be a dict of Phase, but is {'x': 'Form'}"),
    (system(angles=without("theta")), "must have the fields `theta` .* unless a phase has exits"),
    (system(long_names={}), "`long_names` of `mine` must describe each .* but lacks axis, L"),
    (system(vectors={"axis": ("kx", "ky")}), "`vectors` .* it lacks kx, ky"),
    (system(forms={"vector": VECTORIAL}, vectors={}), "be numbers, .* `u` .* is Vector"),
    (system(forms={"vector": WITHOUT_POLES}), "have `s2` and `axis_speed2`, .* gives Spin"),
    (folded(I1=1.0), "`normalised_to` of `mine` must hold.*`I1` is"),
    # problems whose fields were replaced
    (replaced(parameters={**BODY, "alpha": 5.0}), "`parameters.alpha` must be less than 1.0"),
    (replaced(times=np.array([0.3, 0.1])), "`output_times` must ascend strictly"),
    (replaced(form="nosuch"), "`form` of a Problem must be a Form, but is 'nosuch'"),
]  # fmt: skip


@pytest.mark.parametrize(("call", "message"), CALLS)
def test_a_call_that_cannot_be_carried_out_says_why(
    call: Call, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises((tt.InputError, TypeError), match=message) as raised:
        call()
    assert "--set" not in str(raised.value)
    assert str(raised.value).count("\n") < 3
    assert not list(tmp_path.iterdir())
    assert "mine" not in tt.extending.SYSTEMS or "normalised_to" in message


@pytest.mark.parametrize(
    "coefficient",
    [
        lambda v2, z, law: law.mu / (1 + sqrt(v2 / law.v**2 + 1e-24)),
        lambda v2, z, law: law.mu * sqrt(v2 + law.v**2) / sqrt(v2 + law.v**2),
        lambda v2, z, law: law.mu * atan2(0.1, 1 + v2 / law.v**2),  # not of complex numbers
        lambda v2, z, law: law.mu * law.v / sqrt(v2 + 1e-16),
    ],
)
def test_a_law_that_is_smooth_is_not_refused(coefficient: Any) -> None:
    assert under(coefficient, v=1e-4)().summary.status == "finished"


def test_a_figure_without_matplotlib_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    remedy = r"pip install 'tippetop\[figures\]', or in a checkout '\.\[figures\]'"
    with pytest.raises(ModuleNotFoundError, match=f"^matplotlib is required, .*: {remedy}"):
        made().plot("theta")
