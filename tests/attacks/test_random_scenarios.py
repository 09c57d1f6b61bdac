"""Random scenarios: `check` and `run` agree on what is refused, and a run that ends is sound.

Two in three are changed or garbled. It is not seen whether a motion is right beyond its invariants.
"""

import json
import math
import tempfile
from pathlib import Path
from typing import Any

import pytest
from damage import changed, garbled
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tops import openings, scenarios, spread
from typed import answered

from tippetop.mechanics.systems import SYSTEMS
from tippetop.runs.certificate import MAX_DRIFT, MAX_DRIFT_DEFAULT


pytestmark = pytest.mark.filterwarnings("ignore")
CHECKS = [HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much]
SECONDS, STEPS, ROWS = 20.0, 1e5, 1e5
"""Runs that would take more, by `check`, are not made."""


def toml(value: Any) -> str:
    """Write a value as TOML."""
    if isinstance(value, dict):
        return f"{{{', '.join(f'{toml(key)} = {toml(inner)}' for key, inner in value.items())}}}"
    if isinstance(value, list):
        return f"[{', '.join(map(toml, value))}]"
    return repr(value) if isinstance(value, float) else json.dumps(value, ensure_ascii=False)


def runs(until: float) -> st.SearchStrategy[dict[str, Any]]:
    """Tables [run] of some hundred steps."""
    end = st.floats(0.05 * until, until)
    rows = st.one_of(
        st.just({}),
        st.fixed_dictionaries({"output_step": spread(until / 400, until)}),
        st.fixed_dictionaries({"output": st.sampled_from(["events", "steps"])}),
        st.fixed_dictionaries(
            {"output_times": st.lists(st.floats(0, until), max_size=5, unique=True).map(sorted)}
        ),
    )
    others = {
        "on_liftoff": st.sampled_from(["fly", "stop", "continue"]),
        "orientation": st.booleans(),
        "stop_when": st.just("settled"),
        "tolerance": st.sampled_from([1e-12, 1e-9]),
    }
    tables = st.fixed_dictionaries({"until": end}, optional=others)
    return st.builds(lambda table, rows: table | rows, tables, rows)


@st.composite
def contents(draw: st.DrawFn, systems: list[str]) -> bytes:
    """Files of scenarios."""
    tables = draw(scenarios(draw(st.sampled_from(systems)), fastest=draw(spread(1.0, 2000.0))))
    if draw(st.booleans()):
        tables = draw(openings(tables))
    fastest = max(map(abs, tables["initial"].values()))
    tables["run"] = draw(runs(400 / max(fastest, 30.0)))
    way = draw(st.sampled_from(["whole", "changed", "garbled"]))
    if way == "changed":
        tables = draw(changed(tables))
    content = "\n".join(f"{toml(key)} = {toml(value)}" for key, value in tables.items()).encode()
    return draw(garbled(content)) if way == "garbled" else content


def judge(content: bytes) -> None:
    """Check and run a scenario."""
    with tempfile.TemporaryDirectory() as folder:
        place, store = Path(folder) / "scenario.toml", Path(folder) / "run.zarr"
        place.write_bytes(content)
        code, out, refused = answered("check", place, "--json", codes=(0, 2))
        checked = json.loads(out) if code == 0 else {}
        if too_long(checked):
            return
        words = ["run", place, "--json", "--out", store]
        ended, out, message = answered(*words, codes=(0, 2, 3, 4))
        if "is the plan of a sweep" in message:
            return
        assert (code, refused) == (ended, message) or {code, ended} <= {0, 3, 4}
        if ended not in (0, 4):
            return
        found = json.loads(out)
        assert_sound(found, checked, ended)
        _, shown, _ = answered("info", store, "--json")
        for key in {*found} - {"seconds", "store"}:
            assert json.loads(shown)[key] == found[key]


def too_long(checked: dict[str, Any]) -> bool:
    """Return whether a run takes more than seconds."""
    if not checked:
        return False
    run, expected = checked["run"], checked["expected"]
    rows = run["until"] / run.get("output_step", run["until"])
    wide = run["precision"] != "double" or run["tolerance"] not in (0.0, 1e-12, 1e-9)
    return wide or expected["steps"] > STEPS or rows > ROWS or expected["seconds"] > SECONDS


def assert_sound(found: dict[str, Any], checked: dict[str, Any], code: int) -> None:
    """Compare what a run reports with what is possible and promised."""
    assert found["status"] in {"finished", "liftoff", "fallen", "settled", "ended"}
    until = checked["run"]["until"]
    assert 0 <= found["t_end"] <= until
    assert found["t_end"] == until or found["status"] != "finished"
    assert math.isfinite(found["theta_end"])
    assert "cylinder" in checked["system"] or 0 <= found["theta_end"] <= math.pi
    if code == 0 and not checked["run"]["tolerance"]:
        for name, drift in found["drift"].items():
            assert drift <= MAX_DRIFT.get(name, MAX_DRIFT_DEFAULT)
    for table in ("parameters", "initial", "friction"):
        assert found.get(table) == checked.get(table)


@pytest.mark.slow
@settings(max_examples=200, deadline=None, suppress_health_check=CHECKS)
@given(contents(sorted(SYSTEMS)))
def test_random_scenarios_of_every_system(content: bytes) -> None:
    judge(content)
