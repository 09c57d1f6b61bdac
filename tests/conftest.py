"""Fixtures that every test may use."""

import contextlib
import functools
import os
import signal
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from plans import PLAN


os.environ.setdefault("TIPPETOP_OPT_LEVEL", "0")  # ten times faster to compile; .ci/nightly runs all with 3
MANY = 300  # tests of a session, of which some are bound to need each kernel
PATIENCE = 180.0  # [s] that a worker waits for the others


def _minima() -> None:
    from tippetop.landscape import surface
    from tippetop.scenario import build

    top = dict(build.load("inverting").parameters)
    surface.minimal_surface(top, np.linspace(-1e-4, 1e-4, 3), np.linspace(0.0, 1e-4, 3))


def _turnings() -> None:
    from tippetop.landscape import turning
    from tippetop.scenario import build

    turning.turning_angles(dict(build.load("inverting").parameters), 1e-4, 1e-5, 0.1)


@pytest.fixture(scope="session", autouse=True)
def kernels(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> None:
    """Kernels that many tests need are compiled once, shared out among the workers, which wait for one another and find
    on disk what others compiled. A session of few tests compiles what it needs."""
    worker = os.environ.get("PYTEST_XDIST_WORKER", "")
    if not worker or request.session.testscollected < MANY:
        return
    place = tmp_path_factory.getbasetemp().parent
    for compile_some in (_minima, _turnings):  # 10 and 3 s
        with contextlib.suppress(FileExistsError):
            (place / f"kernels{compile_some.__name__}").mkdir()  # whoever makes it does it
            compile_some()
    (place / f"compiled-{worker}").touch()
    workers, deadline = int(os.environ["PYTEST_XDIST_WORKER_COUNT"]), time.monotonic() + PATIENCE
    while len(list(place.glob("compiled-*"))) < workers and time.monotonic() < deadline:
        time.sleep(0.05)


@pytest.fixture(scope="session", autouse=True)
def all_compiled_is_kept() -> None:
    """A process keeps the 32 integrators that it used lately; a session of tests uses hundreds, again and again."""
    from tippetop.engine import compiled, expressions

    for cached in (compiled.compiled_from, expressions.compile_observables, expressions.compile_orientation):
        kept = functools.lru_cache(maxsize=None)(cached.__wrapped__)
        for module in list(sys.modules.values()):
            for name, value in list(getattr(module, "__dict__", {}).items()):
                if value is cached:
                    setattr(module, name, kept)


@pytest.fixture(autouse=True)
def handlers() -> Iterator[None]:
    """A test leaves Ctrl-C and SIGTERM to the next one as it found them: `main` ends by ignoring them."""
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
    from tippetop.sweeps import sweep

    folder = tmp_path_factory.mktemp("whole")
    (folder / "PLAN.toml").write_text(PLAN)
    sweep.sweep(folder / "PLAN.toml", folder / "S.zarr", workers=1)
    return folder / "S.zarr"
