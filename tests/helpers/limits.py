"""Comparisons whose failures name what is too large."""

from collections.abc import Mapping
from typing import Any

import numpy as np


def assert_below(bound: float, sizes: Mapping[str, Any], of: str = "drift") -> None:
    """Check that each of these sizes, or the largest of its elements, is below a bound."""
    found = {name: float(np.max(size)) for name, size in sizes.items()}
    large = [f"{name}: {size:.3g}" for name, size in found.items() if not size < bound]
    assert not large, f"each {of} must be below {bound:.3g}, but is not for {', '.join(large)}"


def assert_near(
    found: Any, expected: Any, bound: Any, what: str = "", relative: bool = False
) -> None:
    """Check that numbers differ by at most `bound`, or by this part of the largest expected one."""
    size = np.max(np.abs(expected)) if relative else 1.0
    np.testing.assert_allclose(found, expected, rtol=0, atol=bound * size, err_msg=what)
