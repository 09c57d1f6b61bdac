"""The stores that are attacked: small ones of many chunks, finished and unfinished, which nothing
has disturbed.
"""

import contextlib
from pathlib import Path
from typing import Any

from forking import command


RUN = ["run", "inverting", "--set", "run.output_step=0.001"]
# words of runs whose contact changes its phase: on one store flight, slip, roll and the stem are
# left
TOUCHING = {
    "dropped": [
        "initial.theta=2.6",
        "initial.gap=0.02",
        "contact.e_n=0.5",
        "initial.omega3=60.0",
        "run.until=0.4",
    ],
    "sticking": ["run.until=0.15"],
    "onto its stem": ["friction.law=viscous", "friction.mu=3.93", "run.until=0.8"],
}
PLAN = """
scenario = "inverting"
set.run.until = 0.3
chunk = 4
runs = [5]
[[axis]]
of = "initial.omega3"
linspace = [100.0, 175.0]
n = 6
[[axis]]
of = "friction.mu"
values = [0.3, 0.1]
"""
SURFACE = ["surface", "inverting", "--D=-1e-4:1e-4:40", "--lambda=0:1e-5:30"]
POTENTIAL = ["potential", "inverting", "--D=3e-4", "--lambda=4e-6", "--n=400"]


class Enough(Exception):
    """Ends a writer in the middle."""


def many_chunks() -> None:
    """Slices and chunks as small, and commits as frequent, as if the runs were of hours; here and
    in forks.
    """
    from tippetop.landscape import recording as surfaces
    from tippetop.runs import integration
    from tippetop.runs import recording as runs

    integration.STEPS_PER_SLICE = 48
    runs.COMMIT_EVERY, runs.ROWS_PER_CHUNK, runs.EVENTS_PER_CHUNK = 0.0, 256, 16
    surfaces.CHUNK = 16
    surfaces.Surface.__init__.__kwdefaults__["chunk"] = 16


def must(*words: object) -> str:
    """The standard output of a command that succeeds."""
    done = command(*words)
    assert done.code == 0, done.err
    return done.out


def run(folder: Path, until: float = 0.9) -> Path:
    """A finished run."""
    must(*RUN, "--until", until, "--out", folder / "R.zarr")
    return folder / "R.zarr"


def touching(name: str) -> list[object]:
    """The words of a run whose contact changes its phase, without --out."""
    return [
        "run",
        "leine-glocker-stem",
        *(w for key in (*TOUCHING[name], "run.output_step=0.0005") for w in ("--set", key)),
    ]


def interrupted(folder: Path, until: float = 0.9) -> Path:
    """The same run, stopped after some commits."""
    from tippetop.runs import recording
    from tippetop.scenario import build

    slices = []

    def stop(integration: Any) -> None:
        slices.append(integration)
        if len(slices) == 2:
            raise Enough

    with contextlib.suppress(Enough):
        recording.record(
            build.load("inverting", ["run.output_step=0.001"], until),
            folder / "R.zarr",
            progress=stop,
        )
    return folder / "R.zarr"


def sweep(folder: Path) -> Path:
    """A finished sweep, and its plan."""
    (folder / "PLAN.toml").write_text(PLAN)
    must("sweep", folder / "PLAN.toml", "--out", folder / "S.zarr", "--workers", 1)
    return folder / "S.zarr"


def half_a_sweep(folder: Path) -> Path:
    """The same sweep, stopped after some chunks."""
    from tippetop.sweeps import sweep

    (folder / "PLAN.toml").write_text(PLAN)

    def stop(done: int, _: int) -> None:
        if done >= 8:
            raise Enough

    with contextlib.suppress(Enough):
        sweep.sweep(folder / "PLAN.toml", folder / "S.zarr", workers=1, progress=stop)
    return folder / "S.zarr"


def surface(folder: Path) -> Path:
    """A finished surface."""
    must(*SURFACE, "--out", folder / "F.zarr")
    return folder / "F.zarr"


def half_a_surface(folder: Path) -> Path:
    """The store of the same surface, stopped after some chunks."""
    import numpy as np

    from tippetop.landscape import recording
    from tippetop.scenario import build

    base = build.load("inverting")
    wanted = recording.Surface(
        base.parameters, np.linspace(-1e-4, 1e-4, 40), np.linspace(0, 1e-5, 30)
    )

    def stop(done: int, _: int) -> None:
        if done == 3:
            raise Enough

    with contextlib.suppress(Enough):
        recording.write(folder / "F.zarr", wanted, progress=stop)
    return folder / "F.zarr"


def potential(folder: Path) -> Path:
    """A potential."""
    must(*POTENTIAL, "--out", folder / "V.zarr")
    return folder / "V.zarr"
