"""A run whose contact changes its phase continues bit by bit, in whichever phase it was
interrupted.
"""

import json
from pathlib import Path

import numpy as np
import pytest
from stores import assert_same
from touching import BOUNCE, ROCKING, STANDING, THROWN, TURNING

from tippetop.problem import Problem
from tippetop.runs import recording, resuming
from tippetop.runs.attributes import attributes
from tippetop.runs.integration import Integration
from tippetop.runs.run import solve
from tippetop.runs.sinks import Memory
from tippetop.scenario import build
from tippetop.store import root


def with_run(tables: dict, **run: object) -> Problem:
    return build.problem({**tables, "run": {**tables["run"], **run}})


def gathered(memory: Memory) -> list[np.ndarray]:
    """All that a sink has taken, as arrays."""
    table = memory.table()
    others = [
        np.concatenate([part[key] for part in parts])
        for parts in memory.others.values()
        for key in parts[0]
    ]
    return [
        np.concatenate(memory.times),
        np.concatenate(memory.states),
        table.time,
        table.kind,
        table.theta,
        *others,
    ]


IN_WIDER_NUMBERS = [
    *(
        pytest.param(tables, "longdouble", marks=pytest.mark.slow)
        for tables in (BOUNCE, THROWN, TURNING, STANDING, ROCKING)
    ),
]


@pytest.mark.parametrize(
    ("tables", "precision"),
    [
        pytest.param(BOUNCE, "double", id="bounce"),
        pytest.param(THROWN, "double", id="thrown"),
        pytest.param(TURNING, "double", id="turning"),
        pytest.param(ROCKING, "double", id="rocking"),
        pytest.param(
            STANDING, "double", id="standing", marks=pytest.mark.slow
        ),  # 7 s, most of it compiling
        *IN_WIDER_NUMBERS,
    ],
)
def test_a_snapshot_in_any_phase_continues_to_the_same_bits(tables: dict, precision: str) -> None:
    problem = with_run(tables, precision=precision)
    integration, whole = Integration(problem), Memory()
    integration.begin(whole)
    snapshots = []
    while integration.status is None:
        taken = [
            len(whole.times),
            len(whole.logs),
            {name: len(parts) for name, parts in whole.others.items()},
        ]
        if integration.t_end > 0:
            snapshots.append(
                (integration.driver.track.name, json.dumps(integration.snapshot()), taken)
            )
        integration.follow(integration.driver.advance(integration, 3))
    integration.fill()
    kinds = {kind for kind, *_ in snapshots}
    assert len(kinds) >= 2
    if tables is STANDING:
        assert {"both", "slip", "stem-slip", "flight"} <= kinds
    chosen = [next(s for s in snapshots if s[0] == kind) for kind in sorted(kinds)] + snapshots[-1:]
    for _, text, (times, logs, others) in chosen:
        again, memory = Integration(problem), Memory()
        again.restore(json.loads(text))
        memory.times, memory.states, memory.logs = (
            whole.times[:times],
            whole.states[:times],
            whole.logs[:logs],
        )
        memory.others = {name: whole.others[name][:count] for name, count in others.items()}
        again.run(memory)
        assert [
            np.array_equal(a, b) for a, b in zip(gathered(memory), gathered(whole), strict=True)
        ].count(False) == 0
        assert again.progress().phases == integration.progress().phases


@pytest.mark.slow
def test_a_longer_end_gives_the_run_that_would_have_been_made_at_once(tmp_path: Path) -> None:
    """The end of the first comes in flight: the landing after it is not forgotten."""
    short, long = (
        with_run(BOUNCE, until=0.02, output_step=1e-3),
        with_run(BOUNCE, until=0.3, output_step=1e-3),
    )
    recording.record(short, tmp_path / "a")
    assert solve(short).report["contact_phases"]["last"]["phase"] == "flight"
    resuming.resume(tmp_path / "a", until=0.3)
    recording.record(long, tmp_path / "b")
    assert_same(tmp_path / "a", tmp_path / "b")


def test_an_interrupted_store_is_resumed_bit_by_bit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem = with_run(BOUNCE, output_step=1e-3)
    recording.record(problem, tmp_path / "whole")
    monkeypatch.setattr("tippetop.runs.integration.STEPS_PER_SLICE", 16)
    monkeypatch.setattr(recording, "COMMIT_EVERY", 0.0)
    slices = 0

    def die(_: object) -> None:
        nonlocal slices
        slices += 1
        if slices % 4 == 0:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        recording.record(problem, tmp_path / "run", progress=die)
    for _ in range(100):
        try:
            resuming.resume(tmp_path / "run", die)
            break
        except KeyboardInterrupt:
            continue
    monkeypatch.setattr("tippetop.runs.integration.STEPS_PER_SLICE", 8192)
    one, other = (root.open_group(tmp_path / name, "phases").load() for name in ("run", "whole"))
    assert one.identical(other)
    for group in ("trajectory", "events", "impacts"):
        one, other = (
            root.open_group(tmp_path / name, group).drop_attrs() for name in ("run", "whole")
        )
        assert one.identical(other), group


def test_a_saved_run_is_the_recorded_one(tmp_path: Path) -> None:
    problem = with_run(BOUNCE, output_step=1e-3)
    recording.record(problem, tmp_path / "recorded")
    done = solve(problem)
    attrs = root.finite(attributes(done.progress))
    recording.save(done, attrs, tmp_path / "saved")
    assert_same(tmp_path / "saved", tmp_path / "recorded")
