"""Fixtures that every test may use."""

import functools
import gc
import os
import shutil
import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pytest
from plans import PLAN


HELPERS = {file.stem for file in Path(__file__).with_name("helpers").glob("*.py")}
pytest.register_assert_rewrite(*HELPERS - {"plans"})  # their failures show values, too
gc.set_threshold(100_000)  # as the command line; collections would take 6 % of a session
os.environ.setdefault(
    "TIPPETOP_OPT_LEVEL", "0"
)  # ten times faster to compile; .ci/nightly runs all with 3
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # else each child compiles all that it imports
sys.dont_write_bytecode = False
MEMORY = Path("/dev/shm")
if MEMORY.is_dir() and shutil.disk_usage(MEMORY).free > 4 * 2**30:
    os.environ.setdefault("PYTEST_DEBUG_TEMPROOT", str(MEMORY))  # stores would wait for a disk


@pytest.fixture(scope="session", autouse=True)
def all_compiled_is_kept() -> None:
    """A process keeps the 32 integrators that it used lately; a session of tests uses hundreds,
    again and again.
    """
    from tippetop.engine import expressions, integrator

    for cached in (integrator.compiled_from, expressions.compile_observables):
        kept = functools.lru_cache(maxsize=None)(cached.__wrapped__)
        for module in list(sys.modules.values()):
            for name, value in list(getattr(module, "__dict__", {}).items()):
                if value is cached:
                    setattr(module, name, kept)


@pytest.fixture(autouse=True)
def handlers() -> Iterator[None]:
    """A test leaves Ctrl-C and SIGTERM to the next one as it found them: `main` ends by ignoring
    them.
    """
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in before.items():
        if signal.getsignal(number) is not handler:
            signal.signal(number, handler)


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
    import tippetop

    folder = tmp_path_factory.mktemp("whole")
    (folder / "PLAN.toml").write_text(PLAN)
    tippetop.sweep(folder / "PLAN.toml", folder / "S.zarr", workers=1)
    return folder / "S.zarr"


@pytest.fixture(scope="session")
def short_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The store of a run of 0.2 s; not to be changed."""
    import tippetop

    path = tmp_path_factory.mktemp("short") / "RUN.zarr"
    tippetop.run("inverting", until=0.2, out=path)
    return path


@pytest.fixture(scope="session")
def inversion(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The store of a run in which the top turns over, by the command; not to be changed."""
    from typed import typed

    path = tmp_path_factory.mktemp("inversion") / "run.zarr"
    assert typed(f"run inverting --until 7 --out {path}") == 0
    return path


@pytest.fixture(scope="module")
def stores(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder with finished and interrupted stores."""
    from kinds import every_kind

    with every_kind(tmp_path_factory.mktemp("stores")) as folder:
        yield folder


@pytest.fixture(scope="module")
def page() -> Iterator[dict[str, Any]]:
    """What the Python of the page on hybrid systems defines, whose systems are registered."""
    from pages import names_of

    from tippetop.mechanics.systems import SYSTEMS

    with mock.patch.dict(SYSTEMS):
        yield names_of("a-hybrid-system.md")


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Keep compiled code in a folder of the test."""
    monkeypatch.setenv("TIPPETOP_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"
