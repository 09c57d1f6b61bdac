"""The key reference and the scenario to begin with: made from the records, and true of what a
scenario takes.
"""

import tomllib

import pytest
from refusals import refusal

import tippetop as tt
from tippetop.mechanics.friction import LAWS, PARTS
from tippetop.mechanics.systems import SYSTEMS
from tippetop.scenario import build, reading
from tippetop.scenario.scenario_reference import TOPICS, columns, friction, scenario
from tippetop.scenario.schema import RunTable
from tippetop.scenario.template import template


@pytest.mark.parametrize("name", [*SYSTEMS, *reading.presets()])
def test_a_new_scenario_is_what_its_preset_is(name: str) -> None:
    text = template(name)
    preset = text.split("\n")[0].split(",")[0].rpartition(" ")[2]
    made, known = (
        build.resolved(build.problem(t)) for t in (tomllib.loads(text), reading.read(preset))
    )
    assert made == known


@pytest.mark.parametrize("key", ["form", *(f"run.{key}" for key in RunTable.model_fields)])
def test_a_new_scenario_has_every_key(key: str) -> None:
    name = key.rpartition(".")[2]
    assert f"\n{name} = " in template("tippe-top") or f"\n# {name} = " in template("tippe-top")


@pytest.mark.parametrize(
    "name",
    ["phi", "centre_at_rest", "stop_when", "tolerance", "columns", "precision"],
)
def test_a_key_in_a_comment_is_taken_when_it_is_uncommented(name: str) -> None:
    build.problem(tomllib.loads(template("tippe-top").replace(f"\n# {name} = ", f"\n{name} = ")))


def test_what_is_no_system_is_a_sentence() -> None:
    with refusal("Did you mean `heavy-top`"):
        template("heavytop")


def test_every_key_that_a_scenario_takes_is_in_the_reference() -> None:
    listed = {row[0] for section in scenario() for row in section.rows}
    for system in SYSTEMS.values():
        assert {*system.parameters, *system.initial} <= listed
    assert set(RunTable.model_fields) <= listed
    assert {"r", "h", "e_n", "restitution", "gap", "nu_z"} <= listed
    laws = {section.title: {row[0] for row in section.rows} for section in friction()}
    assert all(laws[name] == {*law.parameters, *PARTS} for name, law in LAWS.items())


@pytest.mark.parametrize(
    ("preset", "system"), [("inverting", "tippe-top"), ("gliding-cylinder", "gliding-cylinder")]
)
def test_the_columns_of_the_reference_are_those_of_runs(preset: str, system: str) -> None:
    (rows,) = (section.rows for section in columns() if section.title == f"Columns of {system}")
    trajectory = tt.run(preset, until=0.01).trajectory
    on_request = {quantity.name for quantity in SYSTEMS[system].on_request}
    assert {row[0] for row in rows} == set(trajectory.data_vars) | on_request
    for name, unit, *_ in rows:
        assert not unit or name in on_request or trajectory[name].attrs["units"] == unit


@pytest.mark.parametrize("topic", TOPICS)
def test_no_cell_of_the_reference_is_empty_where_it_should_say_what_it_is(topic: str) -> None:
    for section in TOPICS[topic]():
        assert section.rows or topic == "friction"
        assert all(len(row) == len(section.head) and row[0] and row[-1] for row in section.rows)
