"""What `--set` writes is what TOML would say there, and nothing else changes; what it removes is
gone.
"""

import copy
import json
import math
import string
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from refusals import refusal

import tippetop as tt
from tippetop.scenario.reading import override, presets


TABLES: dict[str, Any] = {
    "system": "tippe-top",
    "initial": {"theta": 0.1, "omega3": 155.0},
    "run": {"until": 8.0},
}
LETTERS = st.characters(max_codepoint=0x17F, exclude_categories=["Cs"])
KEYS = st.builds(  # from_regex takes two seconds to begin with
    str.__add__,
    st.sampled_from(string.ascii_lowercase),
    st.text(string.ascii_lowercase + "0123456789_-", max_size=8),
)
FINITE = st.floats(allow_nan=False, allow_infinity=False)
VALUES = st.one_of(
    st.integers(-(2**60), 2**60), FINITE, st.booleans(), st.text(LETTERS, max_size=9)
)


def toml(value: Any) -> str:
    """A value as TOML writes it; JSON writes texts, numbers and lists alike, but for the sign of
    deletion.
    """
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


@settings(max_examples=50, deadline=None)
@given(
    st.sampled_from(["initial", "run", "friction"]),
    KEYS,
    st.one_of(VALUES, st.lists(VALUES, max_size=3)),
)
def test_an_assignment_sets_one_key_to_its_value(table: str, key: str, value: Any) -> None:
    before = copy.deepcopy(TABLES)
    changed = override(TABLES, [f"{table}.{key}={toml(value)}"])
    assert changed[table][key] == value
    assert type(changed[table][key]) is type(value)
    assert before == TABLES, "what was given stays as it was"
    del changed[table][key]
    expected = copy.deepcopy(TABLES) | {
        table: {k: v for k, v in TABLES.get(table, {}).items() if k != key}
    }
    assert changed == expected


@settings(max_examples=50, deadline=None)
@given(KEYS, st.one_of(KEYS, st.sampled_from(["true", "false", "nan", "inf"])))
def test_a_bare_word_is_a_text_unless_toml_has_a_meaning_for_it(key: str, word: str) -> None:
    (found,) = override({}, [f"{key}={word}"]).values()
    if word in ("true", "false"):
        assert found is (word == "true")
    elif word in ("nan", "inf"):
        assert isinstance(found, float)
        assert math.isnan(found) or found == math.inf
    else:
        assert found == word


@settings(max_examples=50, deadline=None)
@given(KEYS, VALUES)
def test_to_remove_undoes_to_set(key: str, value: Any) -> None:
    name = f"friction.{key}"
    assert override(override(TABLES, [f"{name}={toml(value)}"]), [f"{name}="]) == TABLES | {
        "friction": {}
    }


def test_the_last_assignment_counts() -> None:
    assert override(TABLES, ["run.until=1", "run.until=2"])["run"] == {"until": 2}
    assert override(TABLES, ["initial=", "initial.theta=1.0"])["initial"] == {"theta": 1.0}


@pytest.mark.parametrize(
    ("assignment", "sentence"),
    [
        ("run.until", "must be table.key=value, but is `run.until`"),
        ("a.b.c=3", "must be table.key=value"),
        ("run.until=[3", "must be given a TOML value"),
        ("system.name=3", "`system` is not a table"),
        ("friction=", "`friction` is not: the keys are system, initial, run"),
        ("friction.mu=", "the keys are none"),
    ],
)
def test_what_cannot_be_set_is_a_sentence(assignment: str, sentence: str) -> None:
    with refusal("--set") as found:
        override(TABLES, [assignment])
    assert sentence in str(found.value)
    assert len(found.value.sentences) == 1


def test_what_asks_for_rows_takes_the_place_of_what_did() -> None:
    """As arguments of the library do; "times" says nothing that a step contradicts."""
    tables = {"run": {"until": 8.0, "output_step": 0.01}}
    assert override(tables, ["run.output=keyframes"])["run"] == {
        "until": 8.0,
        "output": "keyframes",
    }
    assert override(tables, ["run.output_times=[0, 1]"])["run"] == {
        "until": 8.0,
        "output_times": [0, 1],
    }
    assert override(tables, ['run.output="times"'])["run"] == {
        "until": 8.0,
        "output_step": 0.01,
        "output": "times",
    }
    assert override(tables, ["run.until=9.0"])["run"] == {"until": 9.0, "output_step": 0.01}
    kept = override(
        {"run": {"output": "keyframes", "keyframe_steps": 64}}, ["run.output_step=0.1"]
    )["run"]
    assert kept == {"output_step": 0.1}
    assert tables == {"run": {"until": 8.0, "output_step": 0.01}}


@pytest.mark.parametrize("times", [[math.nan], [3, 2], [1, math.nan], [0.005, 0.005], ["soon"]])
def test_times_that_are_none_are_refused_whatever_the_end(times: list) -> None:
    """They were dropped as times beyond the end, and no row was left."""
    with refusal("output_times"):
        tt.run("inverting", until=0.01, output_times=times)
    with refusal("output_times"):
        tt.load("inverting", [f"run.output_times={times}".replace("'", '"')], until=0.01)


def test_a_scenario_may_begin_with_a_byte_order_mark(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_text(presets()["inverting"], encoding="utf-8-sig")
    assert tt.load(path).initial == tt.load("inverting").initial
