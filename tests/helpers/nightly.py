"""Parameters of tests that are tried at night only: what they cost is more than what they add to
their siblings.
"""

import os
from typing import Any

import pytest


TONIGHT = int(os.environ.get("ATTACKS_SEED", "0"))
"""The seed of the attacks of this night; 0 by day."""


def at_night(*values: Any) -> Any:
    """The values of one case, which `-m slow` selects."""
    return pytest.param(*values, marks=pytest.mark.slow)
