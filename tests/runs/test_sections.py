"""Events by azimuth, place and axis: the same in every form, and logged with the state."""

import numpy as np
import pytest
from limits import assert_near
from refusals import refusal

import tippetop as tt
from tippetop.columns import flagged
from tippetop.mechanics.operand import formula, sin


FORMS = tuple(tt.extending.SYSTEMS["rolling-tippe-top"].forms)
AZIMUTH = tt.extending.Event("azimuth", "phi = 0.3", formula(lambda s, b: sin(s.phi - 0.3)))
PLANE = tt.extending.Event(
    "plane", "y component of the axis is 0", formula(lambda s, b: s.uy), direction=+1
)
LINE = tt.extending.Event("line", "x = y", formula(lambda s, b: s.x - s.y))


@pytest.fixture(scope="module")
def runs() -> dict[str, tt.Run]:
    events = [AZIMUTH, PLANE, LINE]
    return {form: tt.run("rolling", form=form, events=events, until=2.0) for form in FORMS}


def rows(run: tt.Run, kind: str) -> tt.Run:
    return run.events.isel(event=flagged(run.events.kind, kind))


@pytest.mark.parametrize("form", FORMS)
def test_the_state_at_an_event_is_on_its_zero(runs: dict[str, tt.Run], form: str) -> None:
    azimuth, plane, line = (rows(runs[form], kind) for kind in ("azimuth", "plane", "line"))
    assert np.abs(np.sin(azimuth.phi - 0.3)).max() < 1e-9  # it passes a pole at 0.006 rad
    assert np.abs(plane.axis.sel(xyz="y")).max() < 1e-13
    assert np.abs(line.x - line.y).max() < 1e-14
    assert {len(azimuth.time), len(plane.time)} == {11, 7}


def test_a_section_is_passed_at_the_same_times_in_every_form(runs: dict[str, tt.Run]) -> None:
    first, *others = runs.values()
    for other in others:
        np.testing.assert_array_equal(other.events.kind, first.events.kind)
        assert_near(other.events.time, first.events.time, 1e-9)


def test_events_have_the_columns_of_the_rows_at_them() -> None:
    run = tt.run("rolling", events=[PLANE], output="events", until=1.0)
    inner = run.trajectory.isel(time=slice(1, -1))
    assert run.events.sizes["event"] == inner.sizes["time"] > 1
    for name in inner.data_vars:
        np.testing.assert_array_equal(run.events[name], inner[name], err_msg=name)


@pytest.mark.parametrize("missing", ["psi", "phi"])
def test_what_a_form_lacks_is_refused_with_what_it_has(missing: str) -> None:
    odd = tt.extending.Event("odd", "x", formula(lambda s, b: getattr(s, missing)))
    with refusal(f"event `odd` fails: .* has no `{missing}`; it has x, z, "):
        tt.run("rolling-cylinder", events=[odd], until=0.1)
