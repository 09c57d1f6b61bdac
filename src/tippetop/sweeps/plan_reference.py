"""The keys of a plan as tables, for `tippetop help plan` and the manual."""

from ..scenario.scenario_reference import KEYS, Section, keys_of
from .design import Axis, Sample
from .plan import PlanTable


def plan() -> list[Section]:
    """Return the keys of the plan of a sweep."""
    return [
        Section(
            "A plan",
            "A TOML file that lists how the tops of a sweep differ.",
            KEYS,
            keys_of(PlanTable),
        ),
        Section("[[axis]]", "", KEYS, keys_of(Axis)),
        Section("[sample]", "", KEYS, keys_of(Sample)),
    ]
