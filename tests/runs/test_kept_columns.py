"""`columns` of a run: what is kept has the bits that it has beside everything else; what is left
out is said.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zarr
from matplotlib.lines import Line2D
from matplotlib.text import Text
from refusals import refusal
from stores import assert_same
from typed import typed

import tippetop as tt
from tippetop.errors import InputError
from tippetop.figures import catalogue, drawing
from tippetop.problem import column_names
from tippetop.runs import attributes, recording, starting
from tippetop.runs.run import solve
from tippetop.scenario import build


SOME = {
    "inverting": ("theta", "phi_dot", "axis", "friction_power"),
    "rolling": ("phi", "energy"),
    "heavy-top": ("orientation", "L"),
    "gliding-cylinder": ("theta",),
    "flying": ("gap", "phase", "nu_z"),
}


def asked(*names: str) -> str:
    return f"run.columns={list(names)!r}"


@pytest.mark.parametrize("preset", list(SOME))
def test_what_is_kept_has_the_bits_that_it_has_beside_everything(preset: str) -> None:
    """Columns, events, end and report; the turn of the body is integrated only where a column needs
    it.
    """
    whole = solve(starting.load(preset, until=1.0))
    some = solve(starting.load(preset, [asked(*SOME[preset])], until=1.0))
    kept, every = some.columns(), whole.columns()
    assert set(kept) == {"time", *SOME[preset]}
    assert set(every) == {"time", *whole.problem.kept_columns}
    for name, column in kept.items():
        np.testing.assert_array_equal(column.values, every[name].values, strict=True)
        assert column.attrs == every[name].attrs
    for name, column in some.events.items():
        np.testing.assert_array_equal(column.values, whole.events[name].values)
    assert some.report == whole.report
    assert some.problem.orientation is ("orientation" in SOME[preset])


@pytest.mark.parametrize("precision", ["longdouble", "quad"])
def test_wider_columns_come_with_their_low_parts(precision: str) -> None:
    sets = [f"run.precision={precision}", "run.output_times=[0.0]"]
    base = starting.load("rolling-cylinder", [*sets, "run.output_step="])
    every = solve(base)
    named = [name for name in every.columns() if name != "time" and not name.endswith("_lo")]
    assert sorted(named) == sorted(base.kept_columns)
    last = named[-1]
    some = solve(
        starting.load("rolling-cylinder", [*sets, "run.output_step=", asked(last)])
    ).columns()
    assert set(some) == {"time", last, f"{last}_lo"}
    np.testing.assert_array_equal(some[f"{last}_lo"].values, every.columns()[f"{last}_lo"].values)


def test_a_store_keeps_them_and_is_continued_with_them(tmp_path: Path) -> None:
    """The store of a run in memory, of one that is recorded, and of one that is continued are the
    same files.
    """
    names = ("phi_dot", "theta", "time")  # the time is there in any case
    recording.record(
        starting.load("inverting", [asked(*names)], until=2.0), tmp_path / "whole.zarr"
    )
    recording.record(starting.load("inverting", [asked(*names)], until=0.7), tmp_path / "run.zarr")
    assert sorted(zarr.open_group(tmp_path / "run.zarr/trajectory").array_keys()) == sorted(names)
    tt.resume(tmp_path / "run.zarr", until=2.0)
    assert_same(tmp_path / "run.zarr", tmp_path / "whole.zarr")
    tt.run("inverting", until=2.0, columns=names).save(tmp_path / "saved.zarr")
    assert_same(tmp_path / "saved.zarr", tmp_path / "whole.zarr")
    assert tt.open(tmp_path / "whole.zarr").summary.run.columns == ["theta", "phi_dot"]
    assert typed(f"export {tmp_path}/whole.zarr --to csv --out {tmp_path}/run.csv") == 0
    assert (tmp_path / "run.csv").read_text().splitlines()[
        0
    ] == "time [s],phi_dot [rad s-1],theta [rad]"


def test_a_replay_has_the_columns_of_its_run(tmp_path: Path) -> None:
    source = starting.load(
        "inverting", [asked("theta"), "run.output_step=", "run.output=keyframes"], until=2.0
    )
    recording.record(source, tmp_path / "run.zarr")
    rows: Any = tt.open(tmp_path / "run.zarr")
    rows = rows.replay(1.0, 1.5, 0.1)
    assert list(rows.data_vars) == ["theta"]
    whole = tt.run("inverting", until=2.0, output_times=rows.time.values)
    np.testing.assert_array_equal(rows.theta, whole.trajectory.theta)


def test_columns_of_ones_own_are_kept_beside_those_that_are_named() -> None:
    own = tt.extending.Quantity("height", "h", tt.extending.Unit("m"), "height", lambda s, b: s.z)

    def kept(columns: Any, tables: Any = "inverting") -> set[str]:
        return set(tt.run(tables, until=0.01, columns=columns).trajectory.data_vars)

    every = set(tt.run("inverting", until=0.01).trajectory.data_vars)
    assert kept(None) == every
    assert kept(own) == kept([own]) == every | {"height"}
    assert kept(["theta", own]) == {"theta", "height"}
    assert kept("theta") == {"theta"}
    assert kept([]) == set()
    narrow = {**build.resolved(starting.load("inverting", [asked("theta")])), "form": "vector"}
    assert kept(own, narrow) == {"theta", "height"}


def test_what_needs_a_column_that_was_left_out_says_so(tmp_path: Path) -> None:
    run = tt.run("inverting", until=2.0, columns=["theta", "work"])
    run.plot("theta")
    for kind, name in (
        ("drift", "energy"),
        ("energy", "modified_energy"),
        ("sphere", "axis"),
        ("band", "routh"),
    ):
        with refusal(f"the figure `{kind}` must have .*`{name}`"):
            run.plot(kind)
    with refusal(
        "the band along a run must have `routh`, `jellett`, `modified_energy`: add",
    ):
        tt.landscapes.band(run)
    with refusal("what theta is reconstructed from must have `modified_energy`"):
        tt.theory.reconstruct(run)
    work = "--set \"run.columns=['work']\""
    assert typed(f"run inverting {work} --figure {tmp_path}/theta.png") == 2
    assert not (tmp_path / "theta.png").exists()
    assert run.certify(0.1).theta < 1e-12  # it keeps theta for itself


@pytest.mark.slow
def test_a_figure_needs_no_more_than_it_names() -> None:
    """Of a run that keeps what the catalogue says alone, each figure shows what it shows of the
    whole run.
    """

    def shown(kind: str, groups: dict[str, Any], attrs: dict[str, Any]) -> list[Any]:
        picture = drawing.axes_of(kind, groups, attrs).get_figure(root=True)
        lines = [line.get_xydata() for line in picture.findobj(Line2D)]
        return [*lines, np.array([text.get_text() for text in picture.findobj(Text)])]

    problem = starting.load("inverting", until=0.3)
    system, done = problem.system, solve(problem)
    attrs = attributes.attributes(done.progress)
    groups = {
        name: attributes.dataset(columns, attrs)
        for name, columns in attributes.groups(done).items()
    }
    has = column_names(system, problem.form, True, "double")
    for kind, figure in catalogue.FIGURES.items():
        if figure.needs not in groups["trajectory"]:
            continue
        uses = {figure.needs, *figure.uses}
        if "integrals" in uses:
            uses |= {*system.integrals}
        if "landscape" in uses:
            uses |= {*system.landscape.columns}
        columns = [name for name in has if name in uses]
        narrow = {**attrs, "run": {**attrs["run"], "columns": columns}}
        some = {**groups, "trajectory": groups["trajectory"][columns].assign_attrs(attrs)}
        try:
            whole = shown(kind, groups, attrs)
        except InputError:
            continue  # of no such system
        for mine, yours in zip(shown(kind, some, narrow), whole, strict=True):
            np.testing.assert_array_equal(mine, yours, err_msg=kind)
