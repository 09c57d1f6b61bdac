"""Registries of systems and laws."""

from collections.abc import Iterator
from unittest import mock

import pytest

from tippetop.mechanics import friction, systems


@pytest.fixture(autouse=True)
def forgotten(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Forget after a test what it registers."""
    monkeypatch.setattr(friction, "LAWS", friction.LAWS)  # which a registration replaces
    with mock.patch.dict(systems.SYSTEMS), mock.patch.dict(friction.LAWS):
        yield
