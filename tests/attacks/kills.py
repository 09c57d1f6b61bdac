"""Killed at random moments and begun again, every command ends in the bits of one that was never
disturbed.

A process (a fork that has everything compiled; now and then a fresh interpreter) gets SIGKILL at a
random moment of its life, or right at one of its file operations: before the n-th file that is
opened to be written, renamed, linked, removed or synced, or some microseconds after. Up to three
kills in a row fall on one store; then the command is left alone, and every file is compared with
that of an undisturbed one. What was acknowledged before a kill must be there after it, and nothing
may be left beside the result. Attacked are run, resume, run --overwrite, a run whose contact
changes its phase (the phase of its last checkpoint is noted), sweep (the main process, alone and
with workers, and its workers), surface, potential, export to all three formats, and plot.

What it cannot see: power failures (a killed process leaves what it wrote to the kernel; fsync is
trusted), disks and network file systems that reorder or lose writes, kills inside a system call,
two processes killed at once, machines other than this one, and moments that need hours to come.
"""

import contextlib
import json
import os
import shutil
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import undisturbed
from forking import Done, command, forked
from moments import moment, operations, victim
from verdict import Verdict, difference, files


COUNT = 300


class Target(NamedTuple):
    """A command that is killed: its words in a folder, those that continue it, and how much is
    acknowledged there.
    """

    begin: Callable[[Path, Path], list[object]]  # (folder, where the prepared stores are)
    again: Callable[[Path, Path], list[object]] | None = None  # None: the same words
    acknowledged: Callable[[Path], float] = lambda _: -1.0
    setup: Callable[[Path, Path], object] = lambda *_: None
    workers: bool = False


# --- what is acknowledged -----------------------------------------------------------------------


def _rows(folder: Path) -> float:
    """Acknowledged rows of a run; all of them if it is finished."""
    store = folder / "R.zarr"
    if not store.exists():
        return -1.0
    state = _acknowledged(store)
    return float("inf") if state.closing else float(state.rows.get("trajectory", 0))


def _chunks(folder: Path) -> float:
    """Chunks of a sweep that are done."""
    store = folder / "S.zarr"
    return float(len(_acknowledged(store).chunks)) if store.exists() else -1.0


def _acknowledged(store: Path) -> Any:
    from tippetop.store import ledger

    return ledger.Acknowledged.of(ledger.records_of((store / ledger.LEDGER).read_bytes()))


def _blocks(folder: Path) -> float:
    """Chunks of a surface that are done."""
    return (
        float(len(_acknowledged(folder / "F.zarr").chunks))
        if (folder / "F.zarr").exists()
        else -1.0
    )


# --- what is killed -----------------------------------------------------------------------------


def _run(folder: Path, _: Path) -> list[object]:
    return [*undisturbed.RUN, "--until", 0.9, "--out", folder / "R.zarr"]


def _resume(folder: Path, stores: Path) -> list[object]:
    return ["resume", folder / "R.zarr"] if (folder / "R.zarr").exists() else _run(folder, stores)


def _copy(name: str, kind: str) -> Callable[[Path, Path], object]:
    return lambda folder, stores: shutil.copytree(stores / kind / name, folder / name)


def _overwrite(folder: Path, stores: Path) -> list[object]:
    """Until the old store is replaced; then as `resume`."""
    old = (folder / "R.zarr").exists() and _rows(folder) == float("inf") and _until(folder) != 0.9
    return [*_run(folder, stores), "--overwrite"] if old else _resume(folder, stores)


def _touching(kind: str) -> Callable[[Path, Path], list[object]]:
    def words(folder: Path, _: Path) -> list[object]:
        if (folder / "R.zarr").exists():
            return ["resume", folder / "R.zarr"]
        return [*undisturbed.touching(kind), "--out", folder / "R.zarr"]

    return words


def _phase(folder: Path) -> str:
    """The phase in which the checkpoint of a run left it; empty if there is none, or the contact
    has no phases.
    """
    with contextlib.suppress(OSError, KeyError):
        last = _acknowledged(folder / "R.zarr").attributes["report"]["contact_phases"]["last"]
        return f"{last['phase']} of the {last['ball']}" if last else "the first"
    return ""


def _until(folder: Path) -> float:
    return json.loads((folder / "R.zarr" / "zarr.json").read_text())["attributes"]["run"]["until"]


def _sweep(workers: int) -> Callable[[Path, Path], list[object]]:
    def words(folder: Path, stores: Path) -> list[object]:
        return [
            "sweep",
            stores / "sweep" / "PLAN.toml",
            "--out",
            folder / "S.zarr",
            "--workers",
            workers,
        ]

    return words


def _surface(folder: Path, _: Path) -> list[object]:
    return [*undisturbed.SURFACE, "--out", folder / "F.zarr"]


def _potential(folder: Path, _: Path) -> list[object]:
    return [*undisturbed.POTENTIAL, "--out", folder / "V.zarr"]


def _export(to: str) -> Callable[[Path, Path], list[object]]:
    return lambda folder, stores: [
        "export",
        stores / "run" / "R.zarr",
        "--to",
        to,
        "--out",
        folder / f"a.{to}",
        "--overwrite",
    ]


def _plot(kind: str) -> Callable[[Path, Path], list[object]]:
    return lambda folder, stores: [
        "plot",
        stores / "run" / "R.zarr",
        kind,
        "--out",
        folder / "a.png",
        "--overwrite",
    ]


TARGETS = {
    "run": Target(_run, _resume, _rows),
    "export csv": Target(_export("csv")),
    "resume": Target(_resume, _resume, _rows, _copy("R.zarr", "interrupted")),
    "plot": Target(_plot("theta")),
    "run --overwrite": Target(_overwrite, _overwrite, setup=_copy("R.zarr", "short")),
    "export netcdf": Target(_export("netcdf")),
    **{f"run, {kind}": Target(_touching(kind), None, _rows) for kind in undisturbed.TOUCHING},
    "sweep": Target(_sweep(1), None, _chunks),
    "surface": Target(_surface, None, _blocks),
    "sweep, again": Target(_sweep(1), None, _chunks, _copy("S.zarr", "half_a_sweep")),
    "surface, again": Target(_surface, None, _blocks, _copy("F.zarr", "half_a_surface")),
    "export parquet": Target(_export("parquet")),
    "plot sphere": Target(_plot("sphere")),
    "potential": Target(_potential),
    "sweep, main with workers": Target(_sweep(2), None, _chunks, workers=True),
    "sweep, its workers": Target(_sweep(2), None, _chunks, workers=True),
}
CHEAP = 6  # targets that compile nothing slow
NEEDS = {
    "sweep": ("sweep", "half_a_sweep"),
    "surface": ("surface", "half_a_surface"),
    "potential": ("potential",),
}
SELDOM = 10  # of so many rounds, sweeps with workers are in one: each takes many seconds


# --- the campaign -------------------------------------------------------------------------------


def prepare(folder: Path, count: int, first: int) -> dict[str, Any]:
    """The undisturbed results, how long they take, and how many file operations."""
    undisturbed.many_chunks()
    names = list(TARGETS) if count > 20 or first else list(TARGETS)[:CHEAP]
    stores, needed = folder / "stores", {"run", "interrupted", "short"}
    needed |= {
        kind
        for name in names
        for key, kinds in NEEDS.items()
        if name.startswith(key)
        for kind in kinds
    }
    for kind in sorted(needed):
        (stores / kind).mkdir(parents=True)
        if kind == "short":
            undisturbed.run(stores / kind, 0.3)
        else:
            getattr(undisturbed, kind)(stores / kind)
    facts: dict[str, Any] = {}
    for name in names:
        target, place = TARGETS[name], folder / "whole" / name
        place.mkdir(parents=True)
        target.setup(place, stores)
        if target.workers:
            facts[name] = (facts["sweep"][0], 0, 15.0)
            continue
        for warm in (True, False):  # the first call compiles what the others find
            shutil.rmtree(place)
            place.mkdir()
            target.setup(place, stores)
            clock = time.monotonic()
            if warm:
                undisturbed.must(*target.begin(place, stores))
            else:
                made = operations(target.begin(place, stores))
        facts[name] = (files(place), made, time.monotonic() - clock)
    return {"stores": stores, "names": names, "facts": facts}


def attack(
    number: int, rng: np.random.Generator, folder: Path, prepared: dict[str, Any]
) -> Verdict:
    """Kills one command up to three times, lets it end, and compares."""
    names = [
        n
        for n in prepared["names"]
        if not TARGETS[n].workers or number // len(prepared["names"]) % SELDOM == 0
    ]
    name = names[number % len(names)]
    target, stores = TARGETS[name], prepared["stores"]
    whole, count, seconds = prepared["facts"][name]
    target.setup(folder, stores)
    if target.workers:
        return _with_workers(name, target, rng, folder, stores, whole)
    kills, moments, phases = 0, [], []
    for _ in range(int(rng.integers(1, 4))):
        before = target.acknowledged(folder)
        words = (
            (target.again or target.begin)(folder, stores)
            if kills
            else target.begin(folder, stores)
        )
        moments.append(moment(rng, count, 1.1 * seconds))
        done = victim(words, moments[-1])
        phases.append(_phase(folder))
        repeat = {
            "target": name,
            "moments": moments,
            "phases": [phase for phase in phases if phase],
        }
        if done is not None:
            if fault := _ended_early(done):
                fault.repeat, fault.tries = repeat, kills
                return fault
            break
        kills += 1
        if not target.acknowledged(folder) >= before:
            what = f"{name}: {before} were acknowledged, {target.acknowledged(folder)} are there"
            return Verdict("lost", what, kills, repeat)
    verdict = _let_end(name, target, folder, stores, whole)
    verdict.tries, verdict.repeat = kills, repeat
    return verdict


def _ended_early(done: Done) -> Verdict | None:
    """What is wrong with a command that ended before it could be killed."""
    return done.fault(
        (0, 5) if "must be unfinished" in done.err or "must not exist yet" in done.err else (0,)
    )


def _let_end(
    name: str, target: Target, folder: Path, stores: Path, whole: dict[str, bytes]
) -> Verdict:
    """Lets a command end and compares everything in its folder with what an undisturbed
    one leaves.
    """
    again = (target.again or target.begin)(folder, stores)
    pid, result = forked(lambda: command(*again))
    try:
        done = result.recv()
    except EOFError:
        done = Done(-1, "", "the process died")
    finally:
        os.waitpid(pid, 0)
    if fault := _ended_early(done):
        fault.what = f"{name}: {fault.what}"
        return fault
    if not (differ := difference(files(folder), whole)):
        return Verdict("same")
    kind = "litter" if differ.startswith("too many") and ";" not in differ else "wrong"
    return Verdict(kind, f"{name}: {differ}; at last {[str(w) for w in again]}: {done.err[-300:]}")


def _descendants(pid: int) -> list[int]:
    """The processes below one, youngest last."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            parent = int((folder / "stat").read_text().rpartition(")")[2].split()[1])
        except (OSError, ValueError):
            continue
        if parent == pid:
            found += [int(folder.name), *_descendants(int(folder.name))]
    return found


def _with_workers(
    name: str,
    target: Target,
    rng: np.random.Generator,
    folder: Path,
    stores: Path,
    whole: dict[str, bytes],
) -> Verdict:
    """Kills the main process or one of its workers; whoever computes the rest, the bits are the
    same.
    """
    words, delay = target.begin(folder, stores), float(rng.uniform(1.0, 9.0))
    pid, result = forked(lambda: command(*words))
    result.poll(delay)
    below = _descendants(pid)
    workers = "workers" in name and "main" not in name
    killed = below[-1 - int(rng.integers(min(2, len(below))))] if workers and below else pid
    repeat, kills = {"target": name, "delay": delay}, 0
    if not result.poll(0):
        os.kill(killed, signal.SIGKILL)
        kills = 1
    done = None
    with contextlib.suppress(EOFError):
        done = result.recv()
    os.waitpid(pid, 0)
    for other in below:  # what outlives its main process has to end by itself
        if not _gone(other):
            return Verdict("litter", f"{name}: process {other} lives on", kills, repeat)
    if done is not None and (fault := done.fault((0, 6))):
        return Verdict(fault.kind, f"{name}: {fault.what}", kills, repeat)
    verdict = _let_end(name, target._replace(again=_sweep(1)), folder, stores, whole)
    verdict.tries, verdict.repeat = kills, repeat
    return verdict


def _gone(pid: int, within: float = 20.0) -> bool:
    until = time.monotonic() + within
    while time.monotonic() < until:
        try:
            if (Path("/proc") / str(pid) / "stat").read_text().rpartition(")")[2].split()[
                0
            ] in "ZX":
                return True
        except OSError:
            return True
        time.sleep(0.1)
    return False
