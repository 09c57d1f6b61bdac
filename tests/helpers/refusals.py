"""Bad input is refused by one sentence."""

from typing import Any

import pytest

from tippetop.errors import InputError


def refusal(match: Any) -> Any:
    """Return a context whose block must raise an InputError with this message, a pattern."""
    return pytest.raises(InputError, match=match)
