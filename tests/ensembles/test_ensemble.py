"""Many tops at once are the same tops one by one, whatever runs beside them."""

import dataclasses
import json
import time

import numpy as np
import pytest
import xarray as xr
from refusals import refusal

import tippetop
from tippetop.columns import flag_words
from tippetop.engine.opt_level import opt_level
from tippetop.engine.status import Status
from tippetop.ensembles import lanes, outcomes
from tippetop.ensembles.ensemble import measure, vary
from tippetop.mechanics.systems import SYSTEMS
from tippetop.runs import starting
from tippetop.runs.run import solve


def kinds(found: xr.Dataset, name: str = "class") -> np.ndarray:
    return flag_words(found[name])


def same(one: xr.Dataset, other: xr.Dataset) -> bool:
    return all(one[name].values.tobytes() == other[name].values.tobytes() for name in one)


@pytest.fixture(scope="module")
def mixed() -> dict[str, np.ndarray]:
    """40 tops of other spins, sizes, masses, frictions, tilts and lengths of run: inverting,
    upright, lifting off.
    """
    rng = np.random.default_rng(6)
    n = 40
    return {
        "initial.omega3": rng.uniform(60, 175, n),
        "initial.theta": rng.uniform(0.02, 0.5, n),
        "initial.theta_dot": rng.uniform(-1, 1, n),
        "initial.phi_dot": rng.uniform(-5, 5, n),
        "parameters.m": rng.uniform(0.01, 0.03, n),
        "parameters.alpha": rng.uniform(0.25, 0.35, n),
        "friction.mu": rng.uniform(0.1, 0.6, n),
        "run.until": rng.uniform(0.5, 5, n),
    }


@pytest.fixture(scope="module")
def found(mixed: dict[str, np.ndarray]) -> xr.Dataset:
    return tippetop.ensemble("inverting", mixed, threads=1)


def plain(columns: dict[str, np.ndarray]) -> dict[str, list[float]]:
    return {key: column.tolist() for key, column in columns.items()}


def test_lanes_agree_with_single_runs(mixed: dict[str, np.ndarray], found: xr.Dataset) -> None:
    """Two integrators, with steps of their own: what they tell is the same."""
    columns = plain(mixed)
    for i in range(40):
        run = solve(
            starting.load("inverting", [f"{key}={column[i]!r}" for key, column in columns.items()])
        )
        report, top = run.report, found.isel(top=i)
        assert kinds(found, "status")[i] == run.status.value
        assert float(top["t_end"]) == pytest.approx(report["t_end"], abs=1e-11)
        assert float(top["theta_end"]) == pytest.approx(report["theta_end"], abs=1e-11)
        assert int(top["turnings"]) == report["event_counts"].get("turning_significant", 0)
        inversion, band = report["inversion"], report["nutational_band"]
        expectations = {
            **{name: inversion[name] for name in ("first_equator", "last_equator", "inverted_at")},
            **{name: band[name] for name in ("theta_min", "theta_max")},
        }
        for name, expected in expectations.items():
            assert float(top[name]) == pytest.approx(
                np.nan if expected is None else expected, abs=1e-11, nan_ok=True
            )
        weight = report["normal_force"]["weight"]
        least, most = float(top["normal_force_min"]), float(top["normal_force_max"])
        assert least == pytest.approx(report["normal_force"]["min"], abs=1e-11 * weight)
        assert most == pytest.approx(report["normal_force"]["max"], abs=1e-11 * weight)
        if i % 5 == 0:  # no row of a dense scan lies outside
            times = np.linspace(0, report["t_end"], 40_001)
            dense = solve(dataclasses.replace(run.problem, times=times))
            force = dense.columns()["normal_force"].values
            assert least - force.min() < 1e-13 * weight
            assert force.max() - most < 1e-13 * weight
        assert float(top["drift_jellett"]) < 1e-13
        assert float(top["drift_energy_balance"]) < 1e-12
    assert {"finished", "liftoff"} <= set(kinds(found, "status"))


@pytest.mark.parametrize(("threads", "samples"), [(2, 64), (1, 3)])
def test_neither_threads_nor_slices_nor_order_change_a_bit(
    mixed: dict[str, np.ndarray],
    found: xr.Dataset,
    threads: int,
    samples: int,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Nor, where LLVM rounds all alike, the number of lanes: level 0 fuses other products of 4."""
    monkeypatch.setattr(lanes, "SAMPLES", samples)
    if opt_level() > 0:
        monkeypatch.setattr("tippetop.engine.pools.Pools.lanes", 4)
    order = np.random.default_rng(threads).permutation(40)
    shuffled = {key: column[order] for key, column in mixed.items()}
    again = tippetop.ensemble("inverting", shuffled, threads=threads)
    assert same(again, found.isel(top=order))


def test_a_broken_neighbour_changes_no_bit(mixed: dict[str, np.ndarray], found: xr.Dataset) -> None:
    """Every third top's parameters are spoilt after validation: the others do not notice."""
    tops = vary(starting.load("inverting"), mixed)
    assert tops.valid.all()
    spoilt = np.arange(40) % 3 == 1
    tops.pars[3, spoilt] = np.where(np.arange(spoilt.sum()) % 2, np.nan, 1e-280)
    other = outcomes.dataset(measure(tops, threads=1))
    status = kinds(other, "status")
    assert set(status[spoilt]) <= {"non-finite", "stalled", "liftoff"}
    assert "non-finite" in status[spoilt]
    assert same(other.isel(top=~spoilt), found.isel(top=~spoilt))


def test_invalid_tops_are_named_and_the_others_run() -> None:
    spins = np.array([155.0, np.nan, 160.0, 1e300])
    moments = np.array([3.2e-6, 3.2e-6, 7e-6, 3.2e-6])
    found = tippetop.ensemble(
        "inverting", {"initial.omega3": spins, "parameters.I3": moments}, until=0.5
    )
    assert kinds(found, "status").tolist() == ["finished", "invalid", "invalid", "invalid"]
    assert kinds(found).tolist() == ["under-way", "none", "none", "none"]
    faults = json.loads(found.attrs["faults"])
    assert [fault.split(":")[0] for fault in faults] == ["top 1", "top 2", "top 3"]
    assert "omega3" in faults[0]
    assert "2*I1" in faults[1]


@pytest.mark.parametrize(
    ("variations", "word"),
    [
        ({}, "vary something"),
        ({"initial.omega3": [1.0], "friction.mu": [1.0, 2.0]}, "one length"),
        ({"initial.omega3": [1.0], "initial.psi_dot": [1.0]}, "alone"),
    ],
)
def test_what_cannot_vary_is_said_in_a_sentence(variations: dict, word: str) -> None:
    with refusal(word):
        tippetop.ensemble("inverting", variations)


def test_progress_tells_every_top() -> None:
    seen: list[tuple[int, int]] = []
    tippetop.ensemble(
        "inverting",
        {"initial.omega3": np.linspace(100, 150, 40)},
        until=0.1,
        progress=lambda *at: seen.append(at),
    )
    assert seen == [(i + 1, 40) for i in range(40)]


def test_a_failure_in_one_thread_stops_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tippetop.engine.pools.Pools.lanes", 1)
    clock, numbers = time.perf_counter(), {"until": [0.1, 1e6, 1e6], "omega3": [155.0] * 3}
    with pytest.raises(ZeroDivisionError):
        tippetop.ensemble("inverting", numbers, threads=2, progress=lambda *at: 1 // 0)
    assert time.perf_counter() - clock < 5


def test_the_end_of_a_top_is_called_what_its_system_knows(monkeypatch: pytest.MonkeyPatch) -> None:
    starts = {"initial.theta": np.array([0.01, 3.1])}
    assert kinds(tippetop.ensemble("heavy-top", starts, until=1e-3)).tolist() == [
        "upright",
        "inverted",
    ]
    monkeypatch.setitem(
        SYSTEMS, "heavy-top", dataclasses.replace(SYSTEMS["heavy-top"], classes=("upright",))
    )
    assert kinds(tippetop.ensemble("heavy-top", starts, until=1e-3)).tolist() == [
        "upright",
        "under-way",
    ]


def test_numbers_of_ends_in_a_store_are_those_of_status() -> None:
    """Stores that exist have these words in this order."""
    words = ("todo", "finished", "liftoff", "fallen", "settled", "non-finite", "stalled", "invalid")
    assert (*words, "ended") == outcomes.STATUSES
    assert [Status(word).code for word in outcomes.STATUSES] == list(range(9))


def test_gliding_heavy_tops_fall_alike_in_lanes_and_alone() -> None:
    """The fall is an event that ends a run, which is no liftoff."""
    spins = np.array([5.0, 40.0, 200.0])
    tops = tippetop.ensemble("gliding-heavy-top", {"initial.omega3": spins}, threads=1)
    for i, spin in enumerate(spins.tolist()):
        run = solve(starting.load("gliding-heavy-top", [f"initial.omega3={spin!r}"]))
        assert kinds(tops, "status")[i] == run.status.value
        assert float(tops["t_end"][i]) == pytest.approx(run.report["t_end"], abs=1e-11)
    assert "fallen" in kinds(tops, "status")


# --- orientation --------------------------------------------------------------------------------


def test_the_orientation_of_lanes_is_that_of_runs_and_changes_no_other_column() -> None:
    numbers = {
        "omega3": np.array([120.0, 155.0, -140.0, 155.0]),
        "psi": np.array([0.0, 0.4, -1.0, 0.0]),
    }
    plain = tippetop.ensemble("inverting", numbers, until=0.5, threads=1)
    full = tippetop.ensemble("inverting", numbers, until=0.5, threads=1, orientation=True)
    assert set(full.variables) - set(plain.variables) == set(outcomes.ORIENTATION)
    assert same(full.drop_vars(list(outcomes.ORIENTATION)), plain)
    for i in range(4):
        sets = [f"initial.{name}={float(column[i])!r}" for name, column in numbers.items()]
        row = solve(
            starting.load("inverting", [*sets, "run.output_step=", "run.output_times=[0.5]"], 0.5)
        ).columns()
        turn = np.array([float(full[f"orientation_{part}_end"][i]) for part in "wxyz"])
        assert turn == pytest.approx(row["orientation"].values[0], abs=1e-11)
        assert float(full["psi_end"][i]) == pytest.approx(row["psi"].values[0], abs=1e-11)
