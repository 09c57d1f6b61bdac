"""What may stand in a plan, as tables made from its model: for `tippetop help plan` and
the manual.
"""

from ..scenario.reference import KEYS, Section, keys_of
from .plan import _Axis, _Plan, _Sample


def plan() -> list[Section]:
    """The keys of the plan of a sweep."""
    return [
        Section(
            "A plan",
            "A TOML file that says how the tops of a sweep differ.",
            KEYS,
            keys_of(_Plan),
        ),
        Section("[[axis]]", "", KEYS, keys_of(_Axis)),
        Section("[sample]", "", KEYS, keys_of(_Sample)),
    ]
