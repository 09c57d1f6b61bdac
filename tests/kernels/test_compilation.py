"""Machine code of kernels on disk: found again, never stale, never another user's, and never in the
way.
"""

import importlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import numba
import numpy as np
import pytest
from stores import flip, give_away

from tippetop_kernels import compilation
from tippetop_kernels.compilation import kernel


TOY = {
    "__init__.py": "",
    "rules.py": "from tippetop_kernels.compilation import kernel\nfrom .numbers import SHIFT\n\n"
    "@kernel\ndef rule(x):\n    return 2.0 * x + SHIFT\n",
    "numbers.py": "SHIFT = 1.0\n",
    "loops.py": "from tippetop_kernels.compilation import entry\nfrom .numbers import SHIFT\n\n"
    "def total(f):\n    @entry\n    def total(x):\n        return f(x) + SHIFT\n\n    return "
    "total\n",
}
"""A package of a formula and a loop, which the tests declare ours."""


@pytest.fixture
def toy(cache: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    folder = cache.with_name("toy")
    folder.mkdir()
    for name, text in TOY.items():
        (folder / name).write_text(text)
    monkeypatch.syspath_prepend(str(folder.parent))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    monkeypatch.setattr(compilation, "PACKAGES", ("toy",))
    monkeypatch.setattr(compilation, "IMPORTED", np.inf)
    yield folder
    forget()


def forget() -> None:
    """Forget what this process has loaded of the toy package."""
    for name in [name for name in sys.modules if name.partition(".")[0] == "toy"]:
        del sys.modules[name]
    importlib.invalidate_caches()
    compilation.sources_digest.cache_clear()


def run(toy: Path, formula: Any = None, x: Any = 3.0) -> tuple[float, bool]:
    """Return the result of the loop as in a new process, and whether its machine code was found on
    disk.
    """
    forget()
    loop = importlib.import_module("toy.loops").total(
        formula or importlib.import_module("toy.rules").rule
    )
    return loop(x), bool(loop.compiled.stats.cache_hits)


def edit(toy: Path, name: str, old: str, new: str) -> None:
    times = (toy / name).stat()
    (toy / name).write_text((toy / name).read_text().replace(old, new))
    os.utime(toy / name, ns=(times.st_atime_ns, times.st_mtime_ns))  # as numba < 0.66 asks for it


def stored(cache: Path) -> list[Path]:
    return sorted(path for path in cache.rglob("*") if path.is_file())


@pytest.mark.parametrize(
    ("name", "old", "new", "result"),
    [
        ("rules.py", "2.0", "3.0", 11.0),
        ("numbers.py", "1.0", "2.0", 10.0),
        ("loops.py", "f(x) +", "f(x) -", 6.0),
    ],
)
def test_an_edit_anywhere_compiles_again(
    toy: Path, name: str, old: str, new: str, result: float
) -> None:
    """An edit of the formula, of a constant in another file, of the loop; the first text finds its
    code again.
    """
    assert run(toy) == (8.0, False)
    edit(toy, name, old, new)
    assert run(toy) == (result, False)
    edit(toy, name, new, old)
    assert run(toy) == (8.0, True)


def test_the_formula_of_a_user_is_not_stored(toy: Path, cache: Path) -> None:
    assert run(toy, kernel(lambda x: 2.0 * x + 1)) == (8.0, False)
    assert not stored(cache)


def test_the_cache_of_the_host_is_restored_and_left_alone(
    toy: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "host"))
    monkeypatch.setattr(numba.config, "CACHE_LOCATOR_CLASSES", "InTreeCacheLocator")
    assert [run(toy) for _ in range(2)] == [(8.0, False), (8.0, True)]
    settings = vars(numba.config)
    assert settings["CACHE_DIR"] == str(tmp_path / "host")
    assert settings["CACHE_LOCATOR_CLASSES"] == "InTreeCacheLocator"
    assert not (tmp_path / "host").exists()
    assert {path.suffix for path in toy.iterdir()} == {".py"}


@pytest.mark.parametrize("mode", [0o770, 0o707])
def test_a_folder_that_others_can_write_is_not_used(toy: Path, cache: Path, mode: int) -> None:
    run(toy)
    for place in (cache, *cache.iterdir()):
        place.chmod(mode)
        assert run(toy) == (8.0, False)
        place.chmod(0o700)
    assert run(toy) == (8.0, True)


@pytest.mark.parametrize(
    "damage", ["cut .nbi", "bit .nbi", "group .nbi", "empty .nbc", "bit .nbc", "owner .nbc"]
)
def test_a_damaged_or_foreign_file_is_compiled_again(toy: Path, cache: Path, damage: str) -> None:
    way, suffix = damage.split()
    careful = os.umask(0)
    try:
        run(toy)
    finally:
        os.umask(careful)
    (file,) = cache.rglob(f"*{suffix}")
    whole = file.read_bytes()
    if way == "group":
        file.chmod(0o620)
    elif way == "owner":
        give_away(file)
    elif way == "bit":
        flip(file, len(whole) // 2)
    else:
        file.write_bytes(whole[: len(whole) // 2 * (way == "cut")])
    assert run(toy) == (8.0, False)
    assert run(toy) == (8.0, True)


def test_code_that_cannot_be_stored_runs(toy: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("numba.core.caching.Cache.save_overload", Mock(side_effect=OSError))
    assert [run(toy) for _ in range(2)] == [(8.0, False)] * 2


def test_without_a_folder_kernels_are_compiled(
    toy: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    for place in ("", str(tmp_path / "file")):
        monkeypatch.setenv("TIPPETOP_CACHE_DIR", place)
        assert run(toy) == (8.0, False)


def test_folders_of_older_sources_are_removed(
    toy: Path, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(compilation, "KEPT", 8)
    for age in range(1, 10):
        old = cache / f"numba-{age}"
        old.mkdir(parents=True, mode=0o700)
        os.utime(old, (1e9 - age, 1e9 - age))
    run(toy)
    names = {path.name for path in cache.iterdir()}
    assert len(names) == 8
    assert names.isdisjoint({"numba-8", "numba-9"})


def test_the_folder_follows_the_users_caches(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.delenv("TIPPETOP_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert compilation.cache_folder() == tmp_path / "tippetop" / "kernels"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert compilation.cache_folder() == tmp_path / ".cache" / "tippetop" / "kernels"
