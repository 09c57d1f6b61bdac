"""The page of a sweep: its map, the line of a top, and its motion, integrated in the page."""

import base64
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typed import refused

import tippetop as tt
from tippetop.sweeps import maps
from tippetop.sweeps.plan import Plan
from tippetop.views.phase_formulas import is_movable
from tippetop.views.sweep_page import changes, page_of_sweep


PLAN = {
    "scenario": "leine-glocker",
    "set": {"run": {"until": 0.6}},
    "axis": [
        {"of": "initial.psi_dot", "values": [20.0, 180.0, 260.0]},
        {"of": "friction.mu", "geomspace": [0.1, 0.9], "n": 3},
        {"of": "parameters.alpha", "values": [0.1, 0.2]},
    ],
}


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("swept") / "S.zarr"
    tt.sweep(Plan.from_tables(PLAN), path)
    return path


LINES = """() => {
  const { map, borders } = tippetop.sweep;
  const { canvas, context } = map.chart;
  const pixels = context.getImageData(0, 0, canvas.width, canvas.height).data;
  return borders.shown.map(({ label, line }) => {
    const [x, y] = map.spot(line[0], line[1]).map(Math.round);
    const up = map.spot(line[2], line[3])[1] < y ? -1 : 1;
    const near = [0, 1, 2, 3, 4, 5, 6, 7, 8].flatMap((k) => [-1, 0, 1].map((i) => canvas.width * (y + k * up) + x + i));
    return [label, Math.min(...near.map((place) => pixels[4 * place]))];
  });
}"""
"""Every threshold in the map, and the darkest red beside its first point: a line is black."""


def test_tops_differ_as_the_plan_says() -> None:
    plan = Plan.from_tables(PLAN)
    tops = np.arange(plan.n)
    columns = changes(plan, tops)
    assert set(columns) == {"initial.omega3", "friction.mu", "parameters.alpha"}
    for top in (0, 7, 17):
        problem = plan.problem(top)
        assert columns["initial.omega3"][top] == problem.initial["psi_dot"]
        assert columns["friction.mu"][top] == problem.friction.mu
        assert columns["parameters.alpha"][top] == problem.parameters["alpha"]


def test_only_what_a_page_can_integrate_moves() -> None:
    assert is_movable(tt.load("leine-glocker-stem"))
    assert not is_movable(tt.load("rolling"))
    assert not is_movable(tt.load("inverting", ["friction.mu_d=1e-5"]))
    assert not is_movable(tt.load("flying", ["contact.restitution=newton"]))


def test_a_top_of_a_sweep_flies_in_its_page(open_page: Any, tmp_path: Path) -> None:
    plan = {
        "scenario": "flying",
        "set": {"run": {"until": 5.3}},
        "axis": [
            {"of": "contact.e_n", "values": [0.0, 0.4]},
            {"of": "friction.mu", "values": [0.3]},
        ],
    }
    tt.sweep(Plan.from_tables(plan), tmp_path / "S.zarr")
    tab = open_page(page_of_sweep(tmp_path / "S.zarr"))
    for top in (0, 1):
        tab.evaluate("top => tippetop.sweep.choose(top, true)", top)
        theta = tab.evaluate("tippetop.pose(tippetop.end).theta")
        assert theta == pytest.approx(float(tt.open(tmp_path / "S.zarr").theta_end[top]), abs=1e-6)
    assert tab.faults == []


def test_a_page_tells_the_classes_apart_as_the_figure_does(
    store: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A top that has not left the upright yet is no top that is turning over."""
    monkeypatch.setattr(maps, "NEAR", 1.0)
    data = re.search(r'id="data">(.*?)</script>', page_of_sweep(store), re.DOTALL)
    assert data is not None
    (column,) = (c for c in json.loads(data[1])["columns"] if c["name"] == "class")
    values = np.frombuffer(base64.b64decode(column["values"]), "<f4")
    shown = {column["names"][int(value)] for value in values}
    assert shown == {maps.SHOWN[i] for i in maps.values_of(store, tt.open(store), "class")}
    assert "near-upright" in shown
    labels = [axis["label"] for axis in json.loads(data[1])["axes"]]
    assert "friction coefficient μ" in labels[1]
    assert "is a sweep" in refused(f"view {store} --from 0.1 --out {tmp_path}/S.html")


def test_a_cell_has_its_line_and_its_motion(store: Path, open_page: Any) -> None:
    """Whose inclination at the end is that of the sweep."""
    table = tt.open(store)
    tab = open_page(page_of_sweep(store))
    legend = tab.locator("[data-part=legend]").inner_text()
    assert legend.count("(") == len(set(maps.values_of(store, table, "class")[1::2]))
    assert "-" not in legend
    drawn = tab.evaluate(LINES)
    words = tab.locator("[data-part=borders] .border").all_inner_texts()
    assert words == [label.replace("_", "") for label, _ in drawn]
    assert any("λu: upright spin stable below" in word for word in words)
    assert max(darkest for _, darkest in drawn) < 60
    for top in (1, 9, 17):
        tab.evaluate("top => tippetop.sweep.choose(top, true)", top)
        assert f"Top {top}:" in tab.locator("[data-part=top]").inner_text()
        end = tab.evaluate(
            "t => tippetop.pose(t).theta", float(table.t_end[top])
        )  # of liftoff, between samples
        assert end == pytest.approx(float(table.theta_end[top]), abs=2e-5)
        assert tab.evaluate("tippetop.end") == pytest.approx(float(table.t_end[top]), abs=2e-3)
    tab.locator("[data-part=map]").click(position={"x": 60, "y": 40})
    assert tab.evaluate("tippetop.sweep.map.chosen") == 5, (
        "least spin, most friction, the larger alpha"
    )
    tab.locator("[data-part=map]").press("ArrowRight")
    assert tab.evaluate("tippetop.sweep.map.chosen") == 11
    tab.locator("[data-part='further-parameters.alpha']").evaluate(
        "e => { e.value = 0; e.dispatchEvent(new Event('input')); }"
    )
    assert tab.evaluate("tippetop.sweep.map.chosen") == 10
    tab.locator("[data-part=column]").select_option("theta_end")
    assert "rad" in tab.locator("[data-part=legend]").inner_text()
    assert tab.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert tab.faults == []
