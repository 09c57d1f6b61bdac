"""Machine code on disk: found again, never loaded when damaged, and heyoka's own cache is left to its owner."""

from pathlib import Path

import heyoka as hy
import numpy as np
import pytest

from tippetop.engine.code_cache import compiled_once
from tippetop.runs.run import solve
from tippetop.scenario import build


X, V = hy.make_vars("x", "v")
PENDULUM = [(X, V), (V, -9.8125 * hy.sin(X))]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("TIPPETOP_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"


def swing() -> np.ndarray:
    pendulum = compiled_once(hy.taylor_adaptive, PENDULUM, np.zeros(2), opt_level=0, tol=1e-9)
    pendulum.state[:] = 0.3, 0.0
    pendulum.propagate_until(1.0)
    return pendulum.state.copy()


@pytest.mark.usefixtures("folder")
def test_the_second_integrator_comes_from_disk_and_has_the_same_bits(monkeypatch: pytest.MonkeyPatch) -> None:
    first = swing()
    monkeypatch.setattr(hy.llvm_state, "set_diskcache_enabled", None)  # compiling it again would fail
    assert swing().tobytes() == first.tobytes()


def test_no_flipped_bit_reaches_the_processor(folder: Path, rng: np.random.Generator) -> None:
    whole = swing()
    (file,) = folder.iterdir()
    kept = file.read_bytes()
    for place in rng.integers(0, 8 * len(kept), 30):
        damaged = bytearray(kept)
        damaged[place // 8] ^= 1 << place % 8
        file.write_bytes(damaged)
        assert swing().tobytes() == whole.tobytes()
        assert file.read_bytes() == kept


@pytest.mark.parametrize("precision", ["double", "longdouble"])
def test_a_run_leaves_heyokas_cache_alone(precision: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    solve(build.load("inverting", [f"run.precision={precision}"], until=0.02))  # other machine code is loaded now
    monkeypatch.setenv("TIPPETOP_CACHE_DIR", "")
    before, heyoka = hy.llvm_state.get_diskcache_path(), tmp_path / "heyoka"
    hy.llvm_state.set_diskcache_path(heyoka)
    try:
        solve(build.load("inverting", [f"run.precision={precision}", "run.tolerance=3e-13"], until=0.03))
        assert not heyoka.exists()
        hy.cfunc([hy.cos(X) * X + float(precision == "double")], vars=[X])
        assert heyoka.exists()
    finally:
        hy.llvm_state.set_diskcache_path(before)
