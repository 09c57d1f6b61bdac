"""Machine code on disk: found again, never stale, never another's, and never in the way."""

import importlib
import inspect
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any, NamedTuple

import numpy as np
import pytest
from forked import Forked

from tippetop_kernels import compiling, disk, grid, jit, origin, words
from tippetop_kernels.jit import entry, inlined


TOY = {
    "rules.py": "from .numbers import SHIFT\n\ndef rule(x):\n    return 2.0 * x + SHIFT\n",
    "numbers.py": "SHIFT = 1.0\n",
    "loops.py": "from .numbers import SHIFT\n\ndef total(f, x, out):\n    out[0] = f(x) + SHIFT\n",
    "__init__.py": "",
}


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("TIPPETOP_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture
def toy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A package of two formulas, the only one whose sources are in digests."""
    folder = tmp_path / "toy"
    folder.mkdir()
    for name, text in TOY.items():
        (folder / name).write_text(text)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    monkeypatch.setattr(origin, "PACKAGES", ("toy",))
    monkeypatch.setattr(origin, "BEGAN", np.inf)
    yield folder
    again()
    origin.files.cache_clear()


def again() -> None:
    """As a new process would be: nothing of the toy package is loaded."""
    for name in [name for name in sys.modules if name.partition(".")[0] == "toy"]:
        del sys.modules[name]
    importlib.invalidate_caches()
    origin.files.cache_clear()


def run(x: float = 3.0) -> tuple[float, bool]:
    """What the kernel gives, and whether it was found on disk, as in a new process."""
    again()
    loops, rules = importlib.import_module("toy.loops"), importlib.import_module("toy.rules")
    total = entry(loops.total)
    return value(total, inlined(rules.rule), x), bool(total.found)


def value(total: Any, formula: Any, x: Any) -> float:
    """What the kernel of the toy package gives."""
    out = np.zeros(1)
    total(formula, x, out)
    return float(out[0])


def stored(cache: Path) -> list[Path]:
    return sorted(cache.iterdir()) if cache.exists() else []


def test_the_next_process_does_not_compile(cache: Path, toy: Path) -> None:
    assert run() == (8.0, False)
    assert len(stored(cache)) == 1
    assert run() == (8.0, True)
    assert cache.stat().st_mode & 0o777 == 0o700
    assert stored(cache)[0].stat().st_mode & 0o777 == 0o600


@pytest.mark.parametrize(
    ("name", "old", "new", "result"),
    [("rules.py", "2.0", "3.0", 11.0), ("numbers.py", "1.0", "2.0", 10.0), ("loops.py", "f(x) +", "f(x) -", 6.0)],
)
def test_an_edit_anywhere_compiles_anew(cache: Path, toy: Path, name: str, old: str, new: str, result: float) -> None:
    """The formula, a constant in another file, the loop; and the first text finds its own machine code again."""
    assert run() == (8.0, False)
    text = (toy / name).read_text()
    (toy / name).write_text(text.replace(old, new))
    assert run() == (result, False)
    assert run() == (result, True)
    (toy / name).write_text(text)
    assert run() == (8.0, True)


def test_what_is_loaded_counts_beside_the_files(cache: Path, toy: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A name bound anew, or byte code older than its file: the files are as they were."""
    assert run() == (8.0, False)
    again()
    loops, rules = importlib.import_module("toy.loops"), importlib.import_module("toy.rules")
    rules.SHIFT = 5.0
    total = entry(loops.total)
    assert value(total, inlined(rules.rule), 3.0) == 12.0
    assert not total.found
    assert run() == (8.0, True)


def test_a_file_that_was_edited_after_the_start_of_the_process_keeps_nothing(
    cache: Path, toy: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(origin, "BEGAN", (toy / "rules.py").stat().st_ctime)
    assert run() == (8.0, False)
    assert not stored(cache)


def test_this_process_began_before_its_tests_and_after_the_machine() -> None:
    assert Path("/proc/self/cmdline").stat().st_ctime + 1 > origin.BEGAN
    assert origin.BEGAN > 1.6e9


class Pair(NamedTuple):
    """A record that the toy package does not know."""

    x: float


def outside(x):
    """A formula that the toy package does not know."""
    return 2.0 * x + 1


def test_an_environment_upon_another_finds_its_machine_code(monkeypatch: pytest.MonkeyPatch) -> None:
    """Before, a package that both of them have was another software than one that only one has."""
    alone = origin._installed()
    monkeypatch.setattr(sys, "path", [*sys.path, *sys.path])
    assert origin._installed() == alone
    assert any(name.startswith("numba-") for name in alone)


def test_formulas_and_records_from_elsewhere_are_never_kept(cache: Path, toy: Path) -> None:
    """A formula of another package, a closure, a record, a name bound to a function from elsewhere."""
    loops, rules = importlib.import_module("toy.loops"), importlib.import_module("toy.rules")
    slope = 2.0

    def closure(x):
        return slope * x + 1

    for formula in (outside, closure, lambda x: 2.0 * x + 1):
        assert value(entry(loops.total), inlined(formula), 3.0) == 8.0
    assert value(entry(loops.total), inlined(lambda p: 2.0 * p.x + 1), Pair(3.0)) == 8.0
    rules.outside = outside
    assert value(entry(loops.total), inlined(rules.rule), 3.0) == 8.0
    assert not stored(cache)


@pytest.mark.parametrize("damage", [b"", b"short", None])
def test_a_damaged_file_is_a_missing_one(cache: Path, toy: Path, damage: bytes | None) -> None:
    run()
    (path,) = stored(cache)
    text = bytearray(path.read_bytes())
    text[len(text) // 2] ^= 1
    path.write_bytes(bytes(text) if damage is None else damage)
    assert run() == (8.0, False)
    assert run() == (8.0, True)


def test_a_right_file_under_a_wrong_name_is_not_taken(cache: Path, toy: Path) -> None:
    run()
    (path,) = stored(cache)
    (toy / "rules.py").write_text(TOY["rules.py"].replace("2.0", "3.0"))
    run()
    (other,) = set(stored(cache)) - {path}
    other.write_bytes(path.read_bytes())
    assert run() == (11.0, False)


def test_what_others_can_write_is_refused(cache: Path, toy: Path, tmp_path: Path) -> None:
    run()
    (path,) = stored(cache)
    for place, mode in ((path, 0o620), (path, 0o602), (cache, 0o770), (cache, 0o707)):
        before = place.stat().st_mode
        place.chmod(mode)
        assert run() == (8.0, False), oct(mode)
        if place is cache:
            place.chmod(before)
    assert run() == (8.0, True)
    real = path.rename(tmp_path / "elsewhere")
    path.symlink_to(real)
    assert run() == (8.0, False)
    (moved := tmp_path / "moved").mkdir(mode=0o700)
    path.replace(moved / path.name)
    cache.rmdir()
    cache.symlink_to(moved)
    assert run() == (8.0, False)


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give files away")
def test_what_belongs_to_another_is_refused(cache: Path, toy: Path) -> None:
    run()
    for place in (stored(cache)[0], cache):
        os.chown(place, 65534, -1)
        assert run() == (8.0, False)


def test_without_a_place_it_compiles(toy: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").touch()
    for place in ("", str(tmp_path / "file"), str(tmp_path / "file" / "below")):
        monkeypatch.setenv("TIPPETOP_CACHE_DIR", place)
        assert run() == (8.0, False)
        assert run() == (8.0, False)


def test_the_place_follows_the_users_caches(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("TIPPETOP_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert disk.folder() == tmp_path / "tippetop" / "kernels"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert disk.folder() == tmp_path / ".cache" / "tippetop" / "kernels"


def test_the_files_used_least_recently_go_first(cache: Path, toy: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run()
    (first,) = stored(cache)
    (cache / "older").write_bytes(bytes(5000))
    os.utime(first, (2, 2))
    os.utime(cache / "older", (1, 1))
    monkeypatch.setattr(disk, "LARGEST", 2 * first.stat().st_size + 4999)
    (toy / "rules.py").write_text(TOY["rules.py"].replace("2.0", "3.0"))
    run()
    assert len(stored(cache)) == 2
    assert first in stored(cache)
    monkeypatch.setattr(disk, "LARGEST", 0)
    (toy / "rules.py").write_text(TOY["rules.py"].replace("2.0", "4.0"))
    run()
    assert not stored(cache)


def functions(code: CodeType) -> Iterator[CodeType]:
    """The functions in a module's code, nested ones too."""
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            if constant.co_flags & 2:  # a new namespace of locals: not the body of a class
                yield constant
            yield from functions(constant)


def test_every_function_of_the_modules_behind_the_kernels_is_in_the_digest() -> None:
    from tippetop.landscape import formulas

    parts = list(origin.loaded({grid.__name__, formulas.__name__}))
    modules = [part for part in parts if " = " not in part]
    assert {"tippetop.mechanics.doubledouble", "tippetop.mechanics.operand", "tippetop_kernels.staging"} <= set(modules)
    whole = "\0".join(parts)
    for name in modules:
        module: ModuleType = sys.modules[name]
        path = Path(str(module.__file__))
        missing = [
            f.co_qualname for f in functions(compile(path.read_text(), path, "exec")) if origin._code(f) not in whole
        ]
        assert not missing, (name, missing)


PROCESS = """
from tippetop_kernels import grid
from tippetop.landscape import kernels, body
import numpy as np
k, x, one = kernels.kernels(), np.array([3e-4]), np.ones((1, 1))
top = body.top({"m": 0.02, "R": 0.02, "alpha": 0.3, "I1": 3e-6, "I3": 3.2e-6, "g": 9.82})
D, lam = np.empty((1, 1)), np.empty((1, 1))
grid.gradients(k.formulas["at_momenta"], k.formulas["gradient"], x, x, top.coefficients, one, D, lam)
print(float(D[0, 0]).hex(), grid.gradients.found)
"""


@pytest.mark.slow
def test_two_processes_at_once_and_one_after_them(cache: Path) -> None:
    """The real kernels, by the real sources: both compile, neither is in the way of the other."""

    results = [process.communicate()[0].split() for process in [Forked(prelude=PROCESS), Forked(prelude=PROCESS)]]
    results.append(Forked(prelude=PROCESS).communicate()[0].split())
    assert len({value for value, _ in results}) == 1
    assert results[2][1] == "1"
    assert [path.name.partition("-")[0] for path in stored(cache)] == ["gradients"]


def test_a_flag_that_differs_between_processes_is_not_in_the_digest() -> None:
    """Else a process in which it differs finds nothing of what another one kept, and compiles again."""
    code = grid.minima.py_func.__code__
    other = code.replace(co_flags=code.co_flags ^ inspect.CO_OPTIMIZED)
    assert other.co_flags != code.co_flags
    assert origin._code(other) == origin._code(code)


def test_a_numba_that_is_made_otherwise_compiles_as_it_always_did(
    cache: Path, toy: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What `compiling` uses of numba's private parts may be gone."""

    def gone(*_: Any) -> Any:
        raise AttributeError("no such part")

    monkeypatch.setattr(compiling, "object_code", gone)
    monkeypatch.setattr(jit.Kernel, "plainly", False)
    assert run() == (8.0, False)
    assert jit.Kernel.plainly
    assert not stored(cache)


def test_machine_code_that_cannot_be_loaded_is_made_anew(
    cache: Path, toy: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run()
    (path,) = stored(cache)
    disk.write(*path.name.split("-")[:1], bytes.fromhex(path.name.split("-")[1]), b"no object")
    assert run() == (8.0, False)
    assert run() == (8.0, True)


def test_an_array_of_one_row_is_of_the_kind_of_many() -> None:
    """It is contiguous in both orders; numba compiles the same for both. Before, a run of one lane compiled anew."""
    kinds = {words.of((np.zeros(shape),))[0] for shape in ((3, 4), (1, 4), (3, 1), (1, 1))}
    assert len(kinds) == 1
    assert words.of((np.zeros((3, 4), order="F"),))[0] not in kinds
