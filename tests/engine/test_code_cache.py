"""Machine code on disk: found again, never loaded when damaged or not private; heyoka's cache is
left alone.
"""

import os
import pickle
import zlib
from pathlib import Path

import heyoka as hy
import numpy as np
import pytest
from stores import exchange, give_away

from tippetop.engine import code_cache
from tippetop.engine.code_cache import compiled_once
from tippetop.runs import starting
from tippetop.runs.run import solve


X, V = hy.make_vars("x", "v")
PENDULUM = [(X, V), (V, -9.8125 * hy.sin(X))]


def swing() -> np.ndarray:
    pendulum = compiled_once(hy.taylor_adaptive, PENDULUM, np.zeros(2), opt_level=0, tol=1e-9)
    pendulum.state[:] = 0.3, 0.0
    pendulum.propagate_until(1.0)
    return pendulum.state.copy()


@pytest.mark.usefixtures("cache")
def test_the_second_integrator_comes_from_disk_and_has_the_same_bits(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    first = swing()
    monkeypatch.setattr(
        hy.llvm_state, "set_diskcache_enabled", None
    )  # compiling it again would fail
    assert swing().tobytes() == first.tobytes()


def test_no_flipped_bit_reaches_the_processor(cache: Path, rng: np.random.Generator) -> None:
    whole = swing()
    (file,) = cache.iterdir()
    kept = file.read_bytes()
    for place in rng.integers(0, 8 * len(kept), 30):
        damaged = bytearray(kept)
        damaged[place // 8] ^= 1 << place % 8
        file.write_bytes(damaged)
        assert swing().tobytes() == whole.tobytes()
        assert file.read_bytes() == kept


@pytest.mark.parametrize("way", ["group", "others", "owner", "exchanged", "earlier", "wrong"])
def test_a_file_that_is_not_private_and_whole_is_not_read(cache: Path, way: str) -> None:
    """Only its owner may have written it, and it contains what its name promises."""
    careful = os.umask(0)
    try:
        is_found(1.0)
        (file,) = cache.iterdir()
        is_found(2.0)
    finally:
        os.umask(careful)
    (other,) = set(cache.iterdir()) - {file}
    assert {path.stat().st_mode & 0o777 for path in (file, other)} == {0o600}
    if way == "exchanged":
        exchange(file, other)
    elif way == "earlier":  # as the last release wrote it
        file.write_bytes(zlib.compress(pickle.dumps(2.0)))
    elif way == "wrong":
        file.write_bytes(file.read_bytes()[:32] + zlib.compress(b"garbage"))
    elif way == "owner":
        give_away(file)
    else:
        file.chmod(0o620 if way == "group" else 0o602)
    assert not is_found(1.0)
    assert is_found(1.0)
    assert file.stat().st_uid == os.geteuid()
    assert file.stat().st_mode & 0o777 == 0o600


def is_found(number: float = 1.0) -> bool:
    """Return whether what a function made of a number is found on disk."""
    made = []

    def kind(number: float) -> float:
        made.append(number)
        return number

    assert compiled_once(kind, number) == number
    return not made


@pytest.mark.parametrize("way", ["group", "others", "owner", "link"])
def test_a_folder_that_is_not_private_is_not_used(cache: Path, way: str) -> None:
    is_found()
    if way == "link":
        cache.symlink_to(cache.rename(cache.with_name("elsewhere")))
    elif way == "owner":
        give_away(cache)
    else:
        cache.chmod(0o720 if way == "group" else 0o702)
    assert not is_found()


@pytest.mark.parametrize("place", ["", "file", "file/below"])
def test_without_a_folder_it_compiles(
    tmp_path: Path, place: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("TIPPETOP_CACHE_DIR", place and str(tmp_path / place))
    assert not is_found()
    assert not is_found()


def test_the_least_recently_used_files_are_removed(
    cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    is_found(1.0)
    is_found(2.0)
    for used, file in enumerate(cache.iterdir()):
        os.utime(file, (used, used))
    assert is_found(1.0)  # and is used now
    monkeypatch.setattr(code_cache, "KEPT", 2)
    is_found(3.0)
    assert len([*cache.iterdir()]) == 2
    assert is_found(1.0)
    assert is_found(3.0)
    assert not is_found(2.0)


@pytest.mark.parametrize("precision", ["double", "longdouble"])
def test_a_run_leaves_heyokas_cache_alone(
    precision: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    solve(
        starting.load("inverting", [f"run.precision={precision}"], until=0.02)
    )  # other machine code is loaded now
    monkeypatch.setenv("TIPPETOP_CACHE_DIR", "")
    before, heyoka = hy.llvm_state.get_diskcache_path(), tmp_path / "heyoka"
    hy.llvm_state.set_diskcache_path(heyoka)
    try:
        solve(
            starting.load(
                "inverting", [f"run.precision={precision}", "run.tolerance=3e-13"], until=0.03
            )
        )
        assert not heyoka.exists()
        hy.cfunc([hy.cos(X) * X + float(precision == "double")], vars=[X])
        assert heyoka.exists()
    finally:
        hy.llvm_state.set_diskcache_path(before)
