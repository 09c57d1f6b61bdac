"""The score of results with known errors."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from examples import turned
from typed import typed

from tippetop import benchmark
from tippetop.benchmark.truth import VECTORS, truth
from tippetop.errors import InputError


def result(name: str, turn: float = 0.0, count: int = 101) -> pd.DataFrame:
    """Return the reference of a case, turned about the vertical by `turn` rad per second."""
    problem = benchmark.case(name).problem
    exact, _ = truth(problem, np.linspace(0, problem.until, count))
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


def test_the_exported_reference_has_the_error_of_its_digits(tmp_path):
    benchmark.export(tmp_path, ["bounce", "joint"])
    for name, digits in (("bounce", 1e-12), ("joint", 1e-10)):
        [only] = benchmark.score(tmp_path / name / "reference.csv").results
        assert only.compared.numbers["position"]["max"] < digits
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
    assert plain["leaves"] == {"0.001": 0.02, "0.01": 0.12, "0.1": pytest.approx(1.0, abs=0.03)}
    assert plain["step"] == 1e-3


def test_position_force_spin_and_energy(tmp_path):
    table, case = result("coulomb-sticking"), benchmark.case("coulomb-sticking")
    body, start = case.problem.body(), result("coulomb-sticking").iloc[0]
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
    table["z [m]"] = body.R - body.c + factor * (table["z [m]"] - body.R + body.c)
    [only] = benchmark.score(write(tmp_path, table, "bounce")).results
    assert only.wrong == ([] if right else ["rises as high"])


def test_files_outside_a_case_folder(tmp_path, capsys):
    path = tmp_path / "mine.csv"
    result("joint").to_csv(path, index=False)
    assert typed(f"benchmark score {path}") == 2
    assert "`--case CASE` is required" in capsys.readouterr().err
    assert typed(f"benchmark score {tmp_path}/no.csv") == 2
    assert "no such file" in capsys.readouterr().err
    assert typed(f"benchmark score {path} --case joint --figures {tmp_path}") == 0
    [only] = benchmark.score(path, "joint").results
    assert (only.engine, only.setting) == ("mine", "-")
    assert "nan" not in str(benchmark.score(path, "joint"))


def test_references_are_no_results(tmp_path):
    benchmark.export(tmp_path, ["joint"])
    with pytest.raises(InputError, match="contains exported references"):
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


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (nan, "column `q_x`: a cell must be a number, but is"),
        (all_nan, "line 7, column `x`: a cell must be a number, but is"),
        (late, "times must be from 0 to 2 s"),
        (no_quaternion, "q_w, q_x, q_y, q_z"),
        (rolled, "its order is x, y, z, w"),
        (other_start, "check the order of the quaternion, the frames and the start"),
    ],
)
def test_bad_results_get_one_message(tmp_path, capsys, spoil, message):
    table = result("coulomb-sticking")
    spoil(table)
    path = write(tmp_path, table)
    with pytest.raises(InputError, match=message) as error:
        benchmark.score(path)
    assert len(error.value.sentences) == 1
    assert typed(f"benchmark score {path}") == 2
    assert message in " ".join(capsys.readouterr().err.split())


def test_a_conjugated_quaternion_of_an_upright_top_is_noticed(tmp_path):
    table = result("drill-to-rest")
    table[["q_x", "q_y", "q_z"]] *= -1
    with pytest.raises(InputError, match=r"space axes into body axes.*change the sign"):
        benchmark.score(write(tmp_path, table, "drill-to-rest"))


def test_unknown_case_and_nothing_to_score(tmp_path, capsys):
    path = write(tmp_path, result("bounce"), "no-case")
    assert typed(f"benchmark score {path}") == 2
    assert "is in the folder `no-case`" in capsys.readouterr().err
    assert typed("benchmark score") == 2
    assert typed(f"benchmark score {path} --case bounce") == 0


def test_json_and_figures(tmp_path, capsys):
    path = write(tmp_path, result("joint"), "joint")
    assert typed(f"benchmark score {path} --json --figures {tmp_path}") == 0
    assert json.loads(capsys.readouterr().out)["results"][0]["outcome_is_right"] is True
    assert (tmp_path / "joint.png").stat().st_size > 10_000
    assert typed(f"benchmark score {path} --figures {path}") == 5
    assert typed(f"benchmark score {path} --figures /proc/figures") == 5
