"""Record what a version of the package stores, prints and refuses, one sorted line per fact:
compare two with diff.

Usage: ``python bench/frozen.py stores|texts [WORD ...]``; with words, only the cases whose names
contain one. The version on PYTHONPATH is recorded. Stores are written by the command line and read
through xarray. Messages come from the test suite: ``PYTHONPATH=...:bench pytest -p frozen
--messages FILE tests/scenario``. ``bits.py`` records runs.
"""

import hashlib
import json
import os
import re
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any


SOURCE = f"{os.sep}tippetop{os.sep}"
RECORDED = ("InputError", "StoreError", "TypeError")
VARYING = re.compile(
    r"/[^\s`'\"]*(?:pytest-of|/tmp)[^\s`'\"]*/|0x[0-9a-f]+|\bprocess \d+|\b\d+\.\d+ s\b"
)
PLAN = """
scenario = "inverting"
set.run.until = 0.5
chunk = 3
runs = [2]
[[axis]]
of = "initial.omega3"
linspace = [100.0, 175.0]
n = 4
[[axis]]
of = "friction.mu"
values = [0.3, 0.1]
"""
SHORT = ("--until", "0.5")
RUNS = {
    "inverting": ("inverting", *SHORT),
    "steps": ("inverting", *SHORT, "--set", "run.output=steps"),
    "events": ("inverting", "--until", "8", "--set", "run.output=events"),
    "keyframes": (
        "inverting",
        *SHORT,
        "--set",
        "run.output=keyframes",
        "--set",
        "run.keyframe_steps=16",
    ),
    "times": ("inverting", *SHORT, "--set", "run.output_times=[0.1, 0.25]"),
    "columns": ("inverting", *SHORT, "--columns", "theta,normal_force"),
    "settled": ("inverting", "--until", "30", "--set", "run.stop_when=settled"),
    "longdouble": ("heavy-top", *SHORT, "--set", "run.precision=longdouble"),
    "euler": ("rolling", *SHORT, "--set", "form=euler", "--set", "run.orientation=false"),
    "cylinder": ("cylinder", *SHORT),
    "fly": ("cohen-coulomb", *SHORT),
    "liftoff": ("inverting", "--set", "initial.omega3=170"),
    "sensitivities": ("inverting", *SHORT, "--set", 'run.sensitivities=["friction.mu"]'),
}
STORES = {
    **{f"run {name}": ("run", *words) for name, words in RUNS.items()},
    "sweep": ("sweep", "PLAN.toml", "--workers", "1"),
    "sweep settled": ("sweep", "SETTLED.toml", "--workers", "1"),
    "surface tippe": ("surface", "inverting", "--D", "0:1e-4:5", "--lambda", "0:2e-4:7"),
    "surface rolling": ("surface", "rolling", "--D", "0:1e-4:5", "--lambda", "0:2e-4:7"),
    "potential": ("potential", "inverting", "--D", "1e-5", "--lambda", "1e-4", "--n", "11"),
}
PRINTED = (
    "presets",
    "systems",
    "help",
    "check inverting --json",
    "run inverting --until 0.01 --json",
)


def command(*words: str, folder: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run a command of the version on PYTHONPATH."""
    environment = os.environ | {"COLUMNS": "100", "NO_COLOR": "1"}
    line = [sys.executable, "-m", "tippetop", *words]
    return subprocess.run(
        line, cwd=folder, env=environment, capture_output=True, text=True, check=False
    )


def digest(array: Any) -> str:
    """Return the first digits of the SHA-256 of an array's bytes."""
    import numpy as np

    values = np.ascontiguousarray(array)
    data = (
        "\n".join(map(str, values.ravel())).encode()
        if values.dtype.kind in "OUT"
        else values.tobytes()
    )
    return hashlib.sha256(data).hexdigest()[:16]


def contents(store: Path) -> Iterator[tuple[str, str]]:
    """Yield every attribute and every array of the groups of a store, as xarray reads them."""
    import xarray as xr

    documents = {
        path.parent: json.loads(path.read_text()) for path in sorted(store.rglob("zarr.json"))
    }
    for folder, document in documents.items():
        if document["node_type"] != "group":
            continue
        name = str(folder.relative_to(store))
        for key, value in sorted(document.get("attributes", {}).items()):
            yield f"{name} @{key}", json.dumps(value, sort_keys=True)
        with xr.open_zarr(folder, consolidated=False) as table:
            for key, variable in sorted(table.variables.items()):
                array = variable.values
                about = json.dumps(variable.attrs, sort_keys=True, default=str)
                yield (
                    f"{name} {key}",
                    f"{variable.dims} {array.dtype} {array.shape} {digest(array)} {about}",
                )


def stores(words: list[str]) -> Iterator[tuple[str, str]]:
    """Yield the contents of the stores of runs, sweeps, surfaces and a potential."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        (folder / "PLAN.toml").write_text(PLAN)
        (folder / "SETTLED.toml").write_text(
            PLAN.replace("0.5", '8.0\nset.run.stop_when = "settled"')
        )
        for name, line in STORES.items():
            if words and not any(word in name for word in words):
                continue
            out = folder / f"{name.replace(' ', '-')}.zarr"
            done = command(*line, "--out", str(out), folder=folder)
            yield f"{name} exit", f"{done.returncode} {VARYING.sub('...', done.stderr)}"
            if out.exists():
                for key, value in contents(out):
                    yield f"{name} {key}", value


def texts(words: list[str]) -> Iterator[tuple[str, str]]:
    """Yield what the commands print: help of each, topics, templates, lists, a check
    and a summary.
    """
    overview = command("--help").stdout
    yield "--help", overview
    lines = [f"{name} --help" for name in re.findall(r"^  ([a-z]+)  ", overview, re.MULTILINE)]
    topics = re.search(r"of (.*?);", command("help").stdout)
    lines += [f"help {name}" for name in topics[1].split(", ")] if topics else []
    lines += [f"help {name} --markdown" for name in topics[1].split(", ")] if topics else []
    names = re.findall(r"^([a-z][a-z-]+) ", command("presets").stdout, re.MULTILINE)
    lines += [f"new {name}" for name in names]
    for line in [*lines, *PRINTED]:
        if not words or any(word in line for word in words):
            done = command(*line.split())
            yield line, f"{done.returncode} {done.stdout}{done.stderr}"


def main() -> None:
    """Print what the arguments name."""
    kinds = {"stores": stores, "texts": texts}
    if len(sys.argv) < 2 or sys.argv[1] not in kinds:
        sys.exit(__doc__)
    for key, value in kinds[sys.argv[1]](sys.argv[2:]):
        for line in value.splitlines() or [""]:
            print(f"{key}: {line}".rstrip(), flush=True)


# --- a plugin of pytest: every error that the package raises in a session -----------------------

messages: set[str] = set()


def _watch(frame: Any, event: str, argument: Any) -> Any:
    """Trace the exceptions of frames of the package, and nothing else."""
    if event == "call":
        if SOURCE not in frame.f_code.co_filename:
            return None
        frame.f_trace_lines = False
    elif event == "exception" and argument[0].__name__ in RECORDED:
        text = VARYING.sub("...", " ".join(str(argument[1]).split()))
        messages.add(f"{argument[0].__name__}: {text}")
    return _watch


def pytest_addoption(parser: Any) -> None:
    """Add the option."""
    parser.addoption(
        "--messages", help="write type and text of every error of the package to this file"
    )


def pytest_sessionstart(session: Any) -> None:
    """Begin to trace."""
    if session.config.getoption("--messages"):
        sys.settrace(_watch)
        threading.settrace(_watch)


def pytest_sessionfinish(session: Any) -> None:
    """Write the messages, sorted."""
    path = session.config.getoption("--messages")
    if path:
        sys.settrace(None)
        Path(path).write_text("".join(f"{line}\n" for line in sorted(messages)), encoding="utf-8")


if __name__ == "__main__":
    main()
