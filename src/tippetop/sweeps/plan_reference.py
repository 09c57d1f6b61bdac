"""The keys of a plan as tables, for `tippetop help plan` and the manual."""

from ..scenario.scenario_reference import Section, keys_section
from .design import Axis, Sample
from .plan import PlanTable


def plan() -> list[Section]:
    """Return the keys of the plan of a sweep."""
    text = "A TOML file that lists how the tops of a sweep differ."
    return [
        keys_section("A plan", PlanTable, text),
        keys_section("[[axis]]", Axis),
        keys_section("[sample]", Sample),
    ]
