"""Fixtures that every test may use."""

from pathlib import Path

import numpy as np
import pytest
from plans import PLAN


@pytest.fixture
def rng() -> np.random.Generator:
    """A seeded generator: the same numbers in every session and order."""
    return np.random.default_rng(20101452)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """The plan of a small sweep."""
    path = tmp_path / "PLAN.toml"
    path.write_text(PLAN)
    return path


@pytest.fixture(scope="session")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Its store, which nothing has disturbed."""
    from tippetop.sweeps import sweep

    folder = tmp_path_factory.mktemp("whole")
    (folder / "PLAN.toml").write_text(PLAN)
    sweep.sweep(folder / "PLAN.toml", folder / "S.zarr", workers=1)
    return folder / "S.zarr"
