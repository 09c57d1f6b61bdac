"""Registries of systems and laws."""

from collections.abc import Iterator

import pytest

from tippetop.mechanics import friction, systems


@pytest.fixture(autouse=True)
def forgotten(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Forget after a test what it registers."""
    monkeypatch.setattr(friction, "LAWS", friction.LAWS)  # which a registration replaces
    registries = systems.SYSTEMS, friction.LAWS
    before = [dict(registry) for registry in registries]
    yield
    for registry, known in zip(registries, before, strict=True):
        registry.clear()
        registry.update(known)
