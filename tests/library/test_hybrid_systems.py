"""Systems of several phases that users write: the page about them, against closed forms."""

import dataclasses
import json
import re
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from limits import assert_below, assert_near
from pages import stick_slip
from refusals import refusal
from test_contact_runs import times

import tippetop as tt
from tippetop.columns import flag_words
from tippetop.mechanics.form import CLOCK, Exit, Form, Integral, Next, Phase, Quantity
from tippetop.mechanics.systems import SYSTEMS
from tippetop.mechanics.units import METRE, METRE_PER_SECOND, ONE
from tippetop.runs.certificate import certificate_violations


pytestmark = pytest.mark.usefixtures("page")


class Candle(NamedTuple):
    h: Any


POINT = {"system": "bouncing-point", "parameters": {"g": 9.81, "e": 0.5}, "initial": {"h": 1.0}}


def bounces(until: float = 3.0, **run: Any) -> Any:
    return tt.run(POINT, until=until, **run)


@pytest.mark.parametrize(
    ("precision", "bound"), [("double", 1e-13), ("longdouble", 1e-15), ("quad", 1e-15)]
)
def test_a_point_bounces_when_it_must(precision: str, bound: float) -> None:
    found = times(bounces(precision=precision), "bounce")
    hops = 2 * np.sqrt(2 / 9.81) * 0.5 ** np.arange(1, len(found))
    expected = np.sqrt(2 / 9.81) + np.concatenate([[0.0], np.cumsum(hops)])
    assert len(found) >= 9
    assert_near(found, expected, bound)


def test_nothing_is_said_of_an_inclination_that_is_not_there() -> None:
    run = bounces()
    assert set(run.trajectory) == {"h", "v"}
    assert "theta" not in str(run)
    assert "turning" not in str(run)


def test_a_certificate_compares_columns_and_phases_where_there_is_no_theta() -> None:
    run = bounces()
    found = run.certify()
    assert "theta" not in found
    assert found.same_end
    assert_below(1e-12, found.columns, "difference")
    assert found.phases.compared == len(run.phases.interval)
    assert found.phases.start < 1e-12
    assert "columns differ by at most" in str(run)
    assert certificate_violations(found) == []


@pytest.mark.parametrize("kind", ["theta", "energy", "drift", "states"])
def test_a_figure_of_what_is_not_there_is_refused(kind: str) -> None:
    with refusal(f"`{kind}` is drawn for .* only; this is `bouncing-point`"):
        bounces().plot(kind)


def test_no_balance_is_reported_where_jumps_may_take_energy() -> None:
    assert bounces().summary.drift == {}


def test_an_exit_at_the_very_end_of_a_run_is_not_logged_by_itself() -> None:
    strike = times(bounces(), "bounce")[0]
    for end in (np.nextafter(strike, 0), strike, np.nextafter(strike, 9)):
        assert set(bounces(until=end).summary.event_counts) <= {"bounce"}


@pytest.mark.parametrize("exits", [("ground",), ("ground", "also"), ("also", "ground")])
def test_events_at_one_instant_end_a_phase_once(exits: tuple[str, ...], page: dict) -> None:
    also = dataclasses.replace(page["ground"], name="also", formula=lambda s, b: 2 * s.h)
    ends = tuple(Exit(name, ("fall", "rest"), page["bounce"]) for name in exits)
    fall = dataclasses.replace(page["fall"], events=(*page["fall"].events, also), exits=ends)
    numbers = {name: page[name] for name in ("g", "e")}
    own = () if "also" in exits else (also,)
    rest = dataclasses.replace(page["rest"], events=(*page["words"], *own))  # all that is logged
    tt.extending.register(
        tt.extending.System(
            "double-point",
            numbers,
            {"rest": rest, "fall": fall},
            begin=lambda x, world: Next("fall", x),
        )
    )
    run, point = tt.run(POINT | {"system": "double-point"}, until=3.0), bounces()
    for name in ("bounce", "rests"):
        np.testing.assert_array_equal(times(run, name), times(point, name))
    assert {*run.summary.event_counts} - {"also"} == {"bounce", "rests"}


def test_phases_of_known_length_are_joined(page: dict, tmp_path: Path) -> None:
    """A clock that strikes every 3/8 of the unit of time, 1/4 s, and a run that ends then."""

    def strike(x: Any, world: Any) -> Next:
        return Next("fall", x, lasts=0.375, logged=("bounce",))

    fall = left(CLOCK, ("fall",), strike)
    numbers = {name: page[name] for name in ("g", "e")}
    tt.extending.register(tt.extending.System("clock-point", numbers, fall, begin=strike))
    clock = POINT | {"system": "clock-point"}
    first = tt.run(clock, until=0.375, out=tmp_path / "run.zarr")
    rest = tt.run({**clock, "initial": {}}, start=first.path, until=0.5)
    np.testing.assert_array_equal(
        [*times(first, "bounce"), *(0.375 + times(rest, "bounce"))], 0.09375 * np.arange(10)
    )


def test_the_phases_of_a_run_are_a_table(tmp_path: Path) -> None:
    run = bounces(out=tmp_path / "run.zarr")
    for table in (run.phases, tt.open(tmp_path / "run.zarr").phases):
        assert [*flag_words(table.phase)] == ["fall"] * 11 + ["rest"]
        np.testing.assert_array_equal(table.start.values[1:11], times(run, "bounce"))
        np.testing.assert_array_equal(table.start.values[1:], table.end.values[:-1])
    assert "`fall` 11 times, `rest` once" in str(run)
    with pytest.raises(AttributeError, match="impacts"):
        _ = run.impacts


def test_each_step_of_each_phase_has_a_row() -> None:
    run = bounces(output="steps")
    np.testing.assert_array_equal(np.isin(times(run, "bounce"), run.trajectory.time.values), True)
    assert run.trajectory.sizes["time"] == run.summary.steps + 1


def test_a_block_sticks_and_slips_with_its_period(page: dict) -> None:
    for name, known in zip(("slips", "sticks"), stick_slip(page["belt"], 99), strict=True):
        found = times(page["run"], name)
        assert len(found) > 1
        np.testing.assert_allclose(found, known[: len(found)], rtol=1e-14)


def test_an_ensemble_without_an_axis_is_refused() -> None:
    with refusal(r"`form` must integrate .*which no form of this system does"):
        tt.ensemble(POINT, {"parameters.e": [0.3, 0.6]}, until=1.0)


class Stick(NamedTuple):
    h: Any
    v: Any
    ux: Any
    uy: Any
    uz: Any


def test_a_jump_that_fails_in_one_member_does_not_end_an_ensemble(page: dict) -> None:
    def bounce(x: Any, world: Any) -> Next:
        if world.body.e > 0.5:
            raise ValueError("too elastic")
        fallen = Stick(0, -world.body.e * x.v, *x[2:])
        return Next("fall", fallen, zeros={"ground": 1}, logged=("bounce",))

    units = Stick(METRE, METRE_PER_SECOND, ONE, ONE, ONE)
    fall = dataclasses.replace(
        SYSTEMS["bouncing-point"].phases["fall"],
        forms=Form("vector", units, lambda q, b: Stick(q.v, -b.g, 0, 0, 0)),
        exits=(Exit("ground", ("fall",), bounce),),
    )
    numbers = {name: page[name] for name in ("g", "e")}
    words = {name: name for name in (*Stick._fields, "axis")}
    axis = {"axis": ("ux", "uy", "uz")}
    tt.extending.register(
        tt.extending.System("stick", numbers, {"fall": fall}, vectors=axis, long_names=words)
    )
    stick = POINT | {"system": "stick", "initial": {"h": 1, "uz": 1}}
    tops = tt.ensemble(stick, {"parameters.e": [0.3, 0.6, 0.4]}, until=0.6)
    assert [*flag_words(tops.status)] == ["finished", "invalid", "finished"]
    assert json.loads(tops.attrs["faults"]) == [
        "top 1: the jump by `ground` from phase `fall` of `stick` fails: ValueError: too elastic"
    ]


def changed(name: str, **fields: Any) -> dict[str, Phase]:
    """A phase of the point with other fields, by name."""
    return {name: dataclasses.replace(SYSTEMS["bouncing-point"].phases[name], **fields)}


def left(event: str, to: Any, jump: Any = None) -> dict[str, Phase]:
    """The phase `fall`, left by another exit."""
    return changed("fall", exits=(Exit(event, to, jump),))


def register(name: str, phases: Any, **fields: Any) -> None:
    """Register the point with other phases."""
    point = SYSTEMS["bouncing-point"]
    phases = point.phases | phases
    tt.extending.register(dataclasses.replace(point, name=name, phases=phases, **fields))


def broken(jump: Any) -> Any:
    """Run the point with another jump."""
    register("broken-point", left("ground", ("fall",), jump))
    return tt.run(POINT | {"system": "broken-point"}, until=2)


@pytest.mark.parametrize(
    ("returned", "words"),
    [
        (None, "return a Next, but returns None"),
        (("rest",), "lead to fall, as its Exit declares, but leads to 'rest'"),
        (("fall", (0.0, 1.0)), "return a state as it takes"),
        (("fall", {"v": "fast"}), "return a number in `v` of the state, but returns 'fast'"),
        (("fall", {}, {"cause": "weird"}), "have start or ground in `cause`, but has 'weird'"),
        (("fall", {}, {"rows": {"tab": (1, 2)}}), "have nothing in `rows`, but has 'tab'"),
        (("fall", {}, {"ends": "running"}), "or stalled in `ends`, but has 'running'"),
        (("fall", {}, {"sides": {"ground": 7}}), "in `sides`, -1 or 1, but has {'ground': 7}"),
        (("fall", {}, {"series": lambda t: ((t,), ())}), "return numbers h, v at the given time"),
        (("fall", {}, {"logged": ("rests",) * 1025}), "log at most 1024 events, but logs 1025"),
        (("fall", {}, {"lasts": -1}), "have a time of at least 0 in `lasts`, but has -1"),
        (lambda x, world: {}["fall"], "fails: KeyError: 'fall'"),
        (lambda x, world: world.phases.clear(), "fails: TypeError: a record cannot be changed"),
        (("fall", {}, {"logged": ("bonce",)}), "`logged`, but has 'bonce'"),
        (("fall", {}, {"zeros": {"ground": 2}}), "no root of multiplicity 2"),
        (("fall", {"h": 0.1}, {"zeros": {"ground": 1}}), "no root of multiplicity 1"),
    ],
)
def test_a_jump_that_cannot_be_followed_is_refused_with_its_place(
    returned: Any, words: str
) -> None:
    def jump(x: Any, world: Any) -> Any:
        if returned is None or callable(returned):
            return returned and returned(x, world)
        phase, changed, more = (*returned, {}, {})[:3]
        return Next(phase, changed if isinstance(changed, tuple) else x._replace(**changed), **more)

    place = "the jump by `ground` from phase `fall` of `broken-point`"
    with refusal(f"{place}.*{re.escape(words)}"):
        broken(jump)


@pytest.mark.parametrize(
    ("jump", "status", "words"),
    [
        (
            lambda x, world: Next("fall", x._replace(v=np.nan)),
            "non-finite",
            "must lead to a finite state",
        ),
        (lambda x, world: Next("fall", x), "stalled", "at last from `fall` to `fall` by `ground`"),
        (lambda x, world: Next("fall", x, ends="ended"), "ended", "by `ground` from phase `fall`"),
    ],
)
def test_a_run_ends_with_the_place_of_a_jump_without_an_end(
    jump: Any, status: str, words: str
) -> None:
    summary = broken(jump).summary
    assert summary.status == status
    assert words in summary.reason


def test_a_phase_may_last_no_time_after_a_jump_that_takes_some() -> None:
    """Each bounce waits on the ground, in a phase that its clock ends immediately."""
    rest, phases = 0.1, SYSTEMS["bouncing-point"].phases

    def lands(x: Any, world: Any) -> Next:
        still = lambda t: (type(x)(0, x.v), ())  # noqa: E731
        return Next("rest", x, delay=rest, series=still, lasts=0)

    def leaves(x: Any, world: Any) -> Next:
        x = x._replace(h=0, v=-0.5 * x.v)
        return Next("fall", x, "ground", zeros={"ground": 1})

    fall = phases["fall"]
    waits = dataclasses.replace(fall, exits=(Exit("clock", ("fall",), leaves),))
    left = dataclasses.replace(fall, exits=(Exit("ground", ("rest",), lands),))
    register("broken-point", {"fall": left, "rest": waits})
    run = tt.run(POINT | {"system": "broken-point"}, until=2, output_times=[0.46])
    starts, first = run.phases.start.values, np.sqrt(2 / 9.81)
    np.testing.assert_allclose(np.diff(starts)[[0, 2]], first, rtol=1e-14)  # half the speed, twice
    np.testing.assert_allclose(np.diff(starts)[[1, 3]], rest / 4, rtol=1e-14)  # internal units
    assert run.trajectory.h[0] == 0


def test_bounces_that_double_precision_cannot_shorten_stall() -> None:
    """Each takes 1 % of the speed; past some time, rounding gives more than that back."""

    def jump(x: Any, world: Any) -> Next:
        return Next("fall", x._replace(h=0, v=-0.99 * x.v), zeros={"ground": 1})

    register("broken-point", left("ground", ("fall",), jump))
    run = tt.run(POINT | {"system": "broken-point"}, until=200)
    fall = float(run.phases.start[1])
    assert run.summary.status == "stalled"
    assert run.summary.t_end == pytest.approx(
        199 * fall, rel=1e-9
    )  # fall (1 + 2 (0.99 + 0.99^2 + ...))


def test_what_no_jump_could_mend_is_not_registered(page: dict) -> None:
    State, state = page["State"], page["state"]
    other = dataclasses.replace(page["ground"], direction=1)

    text = (dataclasses.replace(page["ground"], formula="h"), *page["words"])
    height = Quantity("h", "h", METRE, "height", lambda s, b: 3 * s.h)
    fallen = (Integral("fallen", METRE, "", lambda q, carried, b: q.v),)
    phases = {
        "a function as `formula` and a `direction` of -1, 0 or 1, but has ground": changed(
            "fall", events=text
        ),
        "`a\nb` of `broken` must have names of one word, but has 'a\\\\nb'": {
            "a\nb": SYSTEMS["bouncing-point"].phases["rest"]
        },
        "quantities with other names than the variables, but has h": changed(
            "fall", quantities=(height,)
        ),
        "phases of the system by a tuple of names, but leads to \\('nowhere',\\)": left(
            "ground", ("nowhere",)
        ),
        "must have the variables and units of the first phase.*, but has h \\[m\\]\\.": {
            "rest": Phase(Form("plain", Candle(METRE), lambda q, b: Candle(0)))
        },
        "`direction` of the event `bounce` must be -1 or 1, for it is `lasting`": changed(
            "rest", events=(dataclasses.replace(page["words"][0], lasting=True),)
        ),
        "sky": left("sky", ("rest",)),
        "must keep the common state": changed(
            "rest", enter=lambda x, b: x, leave=lambda q, b: State(q.h + 1, q.v)
        ),
        "must take arrays": changed("rest", enter=lambda x, b: x, leave=scalar),
        "must end in its events that have a formula": left("rests", ("rest",)),
        "must end in each event that the system does not log, but has no exit by sky": changed(
            "rest", events=(dataclasses.replace(other, name="sky"),)
        ),
        "the directions of the phases before, but has ground": changed("rest", events=(other,)),
        "no jump logs them, but has bounce, rests": changed("fall", exits=()),
        "`rest` of `broken` must integrate what .* does, but integrates fallen": changed(
            "rest", forms=Form("plain", state, lambda q, b: State(0, 0), integrals=fallen)
        ),
        "of phase `rest` of `broken` must give its 2 rates.*no attribute 'w'": changed(
            "rest", forms=Form("plain", state, lambda q, b: State(q.w, 0))
        ),
        "must give its 2 rates as a State, but gives Candle": changed(
            "rest", forms=Form("plain", state, lambda q, b: Candle(0))
        ),
    }
    for words, those in phases.items():
        with refusal(words):
            register("broken", those)


def test_fields_of_a_system_that_no_run_can_use_are_not_registered() -> None:
    numbers = SYSTEMS["bouncing-point"].parameters
    for words, fields in {
        "other names than the law of friction, but have friction": {
            "parameters": {**numbers, "friction": numbers["e"]}
        },
        "must have `phases` if they are given, but have t": {"tables": {"t": {}}},
        "a dict of columns for each name, but have none for t": {"tables": {"phases": {}, "t": 3}},
    }.items():
        with refusal(words):
            register("broken", {}, **fields)


def scalar(q: Any, b: Any) -> Any:
    """Return a state, of numbers alone."""
    return q._replace(v=float(q.v))
