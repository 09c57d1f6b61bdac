"""Fixtures that every test may use."""

import numpy as np
import pytest


@pytest.fixture
def rng() -> np.random.Generator:
    """A seeded generator: the same numbers in every session and order."""
    return np.random.default_rng(20101452)
