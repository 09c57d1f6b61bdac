"""Parameters of tests that are tried at night only: what they cost is more than what they add to
their siblings.
"""

from typing import Any

import pytest


def at_night(*values: Any) -> Any:
    """The values of one case, which `-m slow` selects."""
    return pytest.param(*values, marks=pytest.mark.slow)
