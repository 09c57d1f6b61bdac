"""The score of results with known errors."""

import math
import re
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from examples import turned
from nightly import at_night
from refusals import refusal
from scipy.spatial.transform import Rotation
from typed import refused, reported, typed

from tippetop import benchmark
from tippetop.benchmark.truth import VECTORS, Truth, truth
from tippetop.figures.errors_by_step import errors_by_step


@cache
def reference(name: str, count: int) -> Truth:
    """Return the motion of a case."""
    problem = benchmark.case(name).problem
    return truth(problem, np.linspace(0, problem.until, count))[0]


def result(name: str, turn: float = 0.0, count: int = 101) -> pd.DataFrame:
    """Return the reference of a case, turned about the vertical by `turn` rad per second."""
    exact = reference(name, count)
    q = turned(exact.quaternion, turn * exact.t)
    columns = {"t [s]": exact.t}
    for key, headers in VECTORS.items():
        values = q if key == "quaternion" else getattr(exact, key)
        columns |= dict(zip(headers, values.T, strict=True))
    return pd.DataFrame(columns)


def write(root: Path, table: pd.DataFrame, name: str = "coulomb-sticking", step="1e-3") -> Path:
    folder = root / "engine" / "best" / name
    folder.mkdir(parents=True, exist_ok=True)
    table.to_csv(folder / f"dt={step}.csv", index=False)
    return folder / f"dt={step}.csv"


@pytest.mark.parametrize("name", ["joint", "rocking-cylinder", "stem-landing"])
def test_the_reference_has_no_error(tmp_path, name):
    [only] = benchmark.score(write(tmp_path, result(name), name)).results
    assert (only.case, only.engine, only.setting) == (name, "engine", "best")
    assert all(curve.max() < 1e-11 for curve in only.compared.curves.values())
    assert len(only.compared.curves) == 6
    assert not only.wrong


def test_times_may_have_single_precision(tmp_path):
    table = result("torque-free")
    table["t [s]"] = table["t [s]"].astype(np.float32)
    assert not benchmark.score(write(tmp_path, table, "torque-free")).results[0].wrong


def test_a_known_turn_is_scored_as_it_is(tmp_path):
    [only] = benchmark.score(write(tmp_path, result("coulomb-sticking", turn=0.1))).results
    plain = benchmark.Score([only]).to_dict()[0]
    assert plain["largest"]["attitude"] == pytest.approx(0.2, abs=1e-10)
    assert plain["largest"]["theta"] < 1e-12
    assert plain["at"]["attitude"] == 2.0
    assert plain["mean"]["attitude"] == pytest.approx(0.1)
    assert plain["rms"]["attitude"] == pytest.approx(0.2 * math.sqrt(201 / 600))
    assert plain["leaves"] == {"0.001": 0.02, "0.01": 0.12, "0.1": pytest.approx(1.0, abs=0.03)}
    assert plain["step"] == 1e-3


def test_position_force_spin_and_energy(tmp_path):
    table, case = result("coulomb-sticking"), benchmark.case("coulomb-sticking")
    body, start = case.problem.body(), table.iloc[0].copy()
    table["z [m]"] += 1e-3
    table["force_x [N]"] += 0.1
    [only] = benchmark.score(write(tmp_path, table)).results
    largest = {name: curve.max() for name, curve in only.compared.curves.items()}
    energy = (
        body.I3 * 155.0**2 / 2
        + body.m * body.g * start["z [m]"]
        + body.m * sum(start[f"v{c} [m/s]"] ** 2 for c in "xyz") / 2
    )
    assert largest["position"] == pytest.approx(1e-3)
    assert largest["force"] == pytest.approx(0.1 / (body.m * body.g))
    assert largest["energy"] == pytest.approx(body.m * body.g * 1e-3 / energy)


def test_order_of_convergence(tmp_path):
    for step in (1e-3, 5e-4, 2.5e-4):
        write(tmp_path, result("coulomb-sticking", turn=1e4 * step**2), step=f"{step:g}")
    rows = benchmark.score(tmp_path).to_dict()
    assert [row["step"] for row in rows] == [1e-3, 5e-4, 2.5e-4]
    assert rows[0]["order"] is None
    assert rows[2]["order"] == pytest.approx(2, abs=1e-6)
    ratio = rows[1]["rms"]["attitude"] / rows[2]["rms"]["attitude"]
    assert rows[2]["order"] == pytest.approx(math.log2(ratio))  # as documented


@pytest.mark.parametrize(("turn", "blank"), [(0.49, False), (0.51, True), (0.0, True)])
def test_the_order_is_blank_where_an_error_is_saturated_or_rounding(tmp_path, turn, blank):
    """The attitude is off by 1 rad after 2 s with a turn of 0.5 rad/s."""
    for step in (1e-3, 5e-4):
        write(tmp_path, result("coulomb-sticking", turn=turn * step / 1e-3), step=f"{step:g}")
    scored = benchmark.score(tmp_path)
    assert (scored.to_dict()[1]["order"] is None) == blank
    lines = scored.to_markdown().splitlines()[2:]
    assert [line.split(" | ")[-2] == "-" for line in lines] == [True, blank]


def test_only_quaternions_are_required(tmp_path):
    table = result("stem-landing")[["t [s]", *VECTORS["quaternion"]]]
    [only] = benchmark.score(write(tmp_path, table, "stem-landing")).results
    assert set(only.compared.curves) == {"attitude", "theta"}
    assert set(only.outcome) == {"turns over"}
    assert only.judgement.startswith("not judged, for lack of columns: lifts off, lands")


@pytest.mark.parametrize(
    ("rows", "unseen"),
    [(slice(0, 80), "1.58 to 2"), ([0, 100], "0 to 2"), (slice(50, 101), "0 to")],
)
def test_an_outcome_that_the_rows_do_not_show_is_not_judged(tmp_path, rows, unseen):
    table = result("coulomb-sticking").iloc[rows]
    [row] = (scored := benchmark.score(write(tmp_path, table))).to_dict()
    assert row["outcome_is_right"] is None
    assert f"not judged: no rows from {unseen}" in str(scored)


@pytest.mark.parametrize(("factor", "right"), [(0.1, False), (0.9, True)])
def test_a_low_rebound_is_wrong(tmp_path, factor, right):
    table, body = result("bounce"), benchmark.case("bounce").problem.body()
    rest, bounced = body.R - body.c, table["t [s]"] > 0.101
    table.loc[bounced, "z [m]"] = rest + factor * (table.loc[bounced, "z [m]"] - rest)
    [only] = benchmark.score(write(tmp_path, table, "bounce")).results
    assert only.wrong == ([] if right else ["rises as high"])


def test_files_outside_a_case_folder(tmp_path):
    path = tmp_path / "mine.csv"
    result("joint").to_csv(path, index=False)
    told = refused(f"benchmark score {path}")
    assert "`--case CASE` is required" in told
    assert f"is in the folder `{tmp_path.name}`" in told
    assert typed("benchmark score") == 2
    assert "no such file" in refused(f"benchmark score {tmp_path}/no.csv")
    assert typed(f"benchmark score {path} --case joint --figures {tmp_path}") == 0
    [only] = benchmark.score(path, "joint").results
    assert (only.engine, only.setting) == ("mine", "-")
    assert "nan" not in str(benchmark.score(path, "joint"))


def test_references_are_no_results(tmp_path):
    benchmark.export(tmp_path, ["joint"])
    with refusal("contains exported references"):
        benchmark.score(tmp_path)
    result("joint").to_csv(tmp_path / "joint" / "mine.csv", index=False)
    [only] = benchmark.score([tmp_path, tmp_path]).results
    assert (only.case, only.compared.path.name) == ("joint", "mine.csv")


def test_the_good_files_are_scored(tmp_path, capsys):
    write(tmp_path, result("joint"), "joint")
    (tmp_path / "engine" / "best" / "joint" / "dt=1.csv").write_text("t [s],q_w\n0,1\n1,1\n")
    assert typed(f"benchmark score {tmp_path}") == 2
    told = capsys.readouterr()
    assert "engine  best" in told.out
    assert "dt=1.csv` must have the columns" in told.err


def test_a_wrong_outcome_is_named(tmp_path):
    table = result("mujoco-tutorial")
    angle = np.linspace(0, 3, len(table))
    table[VECTORS["quaternion"]] = 0.0
    table["q_w"], table["q_y"] = np.cos(angle / 2), np.sin(angle / 2)
    scored = benchmark.score(write(tmp_path, table, "mujoco-tutorial"))
    assert "turns over" in scored.results[0].wrong
    assert "wrong: turns over" in str(scored)
    assert "| mujoco-tutorial | engine | best |" in scored.to_markdown()


def nan(table):
    table.loc[5, "q_x"] = np.nan


def all_nan(table):
    table.loc[5, table.columns != "t [s]"] = np.nan


def late(table):
    table["t [s]"] *= 2


def no_quaternion(table):
    del table["q_z"]


def rolled(table):
    table[VECTORS["quaternion"]] = np.roll(table[VECTORS["quaternion"]].values, -1, axis=1)


def other_start(table):
    table[VECTORS["quaternion"]] = [0.0, 1.0, 0.0, 0.0]


def far(table):
    table["x [m]"] += 5.0


def other_spin(table):
    table["omega_z [rad/s]"] /= 2


def velocity_of_centre_of_ball(table):
    table[VECTORS["velocity"]] += np.cross(table[VECTORS["omega"]], arm(table))


def body_axes(table):
    q = table[VECTORS["quaternion"]].to_numpy() * [1, -1, -1, -1]
    table[VECTORS["omega"]] = rotated(q, table[VECTORS["omega"]].to_numpy(copy=True))


def arm(table):
    """Return the vector from the centre of mass to the centre of the ball: 6 mm along the axis."""
    return rotated(table[VECTORS["quaternion"]].to_numpy(), np.array([0.0, 0.0, 0.006]))


def rotated(q, v):
    return Rotation.from_quat(q[:, [1, 2, 3, 0]]).apply(v)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (nan, "column `q_x`: a cell must be a number, but is"),
        (all_nan, "line 7, column `x`: a cell must be a number, but is"),
        (late, "times must be from 0 to 2 s"),
        (no_quaternion, "q_w, q_x, q_y, q_z"),
        (rolled, "the order of the quaternion is x, y, z, w"),
        (other_start, "check the start, the frames, the units and the order of the quaternion"),
        (far, r"position \[m\] at 0 s must be near the reference, but differs by 5; check"),
        (other_spin, r"omega \[rad/s\] at 0 s must be near the reference"),
        (velocity_of_centre_of_ball, r"velocity \[m/s\].*it is that of the centre of the ball"),
    ],
)
def test_bad_results_get_one_message(tmp_path, spoil, message):
    table = result("coulomb-sticking")
    spoil(table)
    path = write(tmp_path, table)
    with refusal(message) as error:
        benchmark.score(path)
    assert len(error.value.sentences) == 1
    assert re.search(message, refused(f"benchmark score {path}"))


@pytest.mark.parametrize("name", ["mujoco-tutorial", "torque-free", "joint", "rocking-cylinder"])
@pytest.mark.parametrize("first", [0, 1])
def test_other_conventions_are_noticed_in_every_case_and_without_the_first_row(
    tmp_path, name, first
):
    table, c = result(name, count=1001), benchmark.case(name).problem.body().c
    table[VECTORS["position"]] += arm(table) * c / 0.006
    with refusal("it is that of the centre of the ball"):
        benchmark.score(write(tmp_path, table.iloc[first:], name))
    if name != "rocking-cylinder":  # it turns about an axis that is fixed in both frames
        table = result(name, count=1001)
        body_axes(table)
        with refusal("it is in body axes: name the columns omega_body_x"):
            benchmark.score(write(tmp_path, table.iloc[first:], name))


@pytest.mark.parametrize("name", ["joint", "bounce", *map(at_night, benchmark.names())])
def test_an_inaccurate_result_of_the_right_conventions_is_scored(tmp_path, name):
    """Errors that grow to 1 rad, and to 30 % of every vector, are not those of another start."""
    table = result(name, turn=1.0 / benchmark.case(name).problem.until)
    for key in ("position", "velocity", "omega"):
        grown = np.linspace(0, 0.3, len(table)) * np.abs(table[VECTORS[key]]).to_numpy().max()
        table[VECTORS[key]] += grown[:, None]
    assert len(benchmark.score(write(tmp_path, table, name)).results) == 1


def test_a_conjugated_quaternion_of_an_upright_top_is_noticed(tmp_path):
    table = result("drill-to-rest")
    table[["q_x", "q_y", "q_z"]] *= -1
    with refusal(r"space axes into body axes.*change the sign"):
        benchmark.score(write(tmp_path, table, "drill-to-rest"))


@pytest.mark.parametrize(
    ("options", "code", "words"),
    [
        ("--fail-above 0.21", 0, ""),
        ("--fail-above 0.19", 4, "the error of attitude must be at most 0.19, but is 0.2."),
        ("--fail-above attitude=0.19 --fail-above 0.21", 0, ""),
        ("--fail-above 1 --fail-above position=1e-9", 0, ""),
        ("--fail-above force=1e-9", 4, "force must be at most 1e-09, but its columns are missing"),
        ("--fail-above speed=1", 2, "must be one of attitude, theta, position"),
        ("--fail-above much", 2, "`--fail-above` must be"),
    ],
)
def test_exit_code_for_continuous_integration(tmp_path, options, code, words):
    table = result("coulomb-sticking", turn=0.1).drop(columns=VECTORS["force"])
    path = write(tmp_path, table)
    assert words in refused(f"benchmark score {path} {options}", code)


def test_wrong_outcomes_and_missing_rows_fail_where_a_limit_is_given(tmp_path):
    table = result("bounce")
    short = write(tmp_path, table.iloc[:50], "bounce")
    assert typed(f"benchmark score {short}") == 0
    assert "not judged: no rows from 0.245" in refused(f"benchmark score {short} --fail-above 1", 4)
    table.loc[table["t [s]"] > 0.101, "z [m]"] = 0.014
    low = write(tmp_path, table, "bounce", "1e-4")
    assert "must be right, but is wrong: lifts off, rises as high" in refused(
        f"benchmark score {low} --fail-above 1", 4
    )
    lean = write(tmp_path, result("bounce").filter(regex="t |q_"), "bounce", "2e-4")
    assert "must be right, but is not judged, for lack of columns" in refused(
        f"benchmark score {lean} --fail-above 4", 4
    )
    low.write_text("t [s]\n0\n")
    assert typed(f"benchmark score {tmp_path} --fail-above 1") == 2


def test_the_figure_of_an_upright_case_shows_the_height(tmp_path):
    drawn = {}
    for name in ("bounce", "stem-landing"):
        results = benchmark.score(write(tmp_path, result(name), name)).results
        drawn[name] = errors_by_step(name, results).axes[1]
    assert "height" in drawn["bounce"].get_ylabel()
    heights = drawn["bounce"].lines[0].get_ydata()
    np.testing.assert_allclose(heights, result("bounce")["z [m]"], rtol=1e-14)
    assert drawn["stem-landing"].get_ylabel() == "theta [rad]"


def test_json_and_figures(tmp_path):
    path = write(tmp_path, result("joint"), "joint")
    found = reported(f"benchmark score {path} --figures {tmp_path}")
    assert found["results"][0]["outcome_is_right"] is True
    assert (tmp_path / "joint.png").stat().st_size > 10_000
    assert typed(f"benchmark score {path} --figures {path}") == 5
    assert typed(f"benchmark score {path} --figures /proc/figures") == 5
