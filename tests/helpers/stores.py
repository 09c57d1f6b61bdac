"""How stores are compared, and a command line in a process of its own that may be stopped at any moment."""

import json
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import zarr


def files(store: Path) -> dict[str, bytes]:
    """Every file of a store, by its path inside."""
    return {str(p.relative_to(store)): p.read_bytes() for p in sorted(store.rglob("*")) if p.is_file()}


def assert_same(store: Path, other: Path) -> None:
    """Two stores hold the same files with the same bytes, and there are some."""
    mine, yours = files(store), files(other)
    assert mine
    assert sorted(mine) == sorted(yours)
    assert [name for name in mine if mine[name] != yours[name]] == []


def acknowledged(store: Path) -> int:
    """How many rows the checkpoint of a run acknowledges; -1 if there is none."""
    try:
        return json.loads((store / "checkpoint.json").read_text())["rows"]
    except FileNotFoundError:
        return -1


def chunks(store: Path) -> list[int]:
    """The status of each chunk of a sweep."""
    return np.asarray(zarr.open_group(store=str(store), mode="r")["chunk_status"]).tolist()


def written(store: Path) -> int:
    """How many chunks of a sweep are done."""
    return chunks(store).count(1) if store.exists() else 0


def start_process(*arguments: str, prelude: str = "") -> subprocess.Popen:
    """The command line in a process of its own; `prelude` is Python that runs before it."""
    code = f"{prelude}\nfrom tippetop.cli import main; main({list(arguments)!r})"
    return subprocess.Popen([sys.executable, "-c", code], stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def ended(process: subprocess.Popen) -> tuple[int, str]:
    """Exit code and stderr of a process, once it ends."""
    _, err = process.communicate()
    return process.returncode, err


def wait_until(condition: Callable[[], bool], process: subprocess.Popen) -> None:
    """Waits for a condition, as long as the process runs."""
    while not condition():
        assert process.poll() is None, process.communicate()
        time.sleep(0.002)
