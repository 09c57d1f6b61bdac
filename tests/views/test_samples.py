"""What a page keeps of a run: poses between which the attitude is the run's, forces and places as
rows say them.
"""

import base64
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from limits import assert_near
from refusals import refusal

import tippetop as tt
from tippetop.exchange.motion import angle_between
from tippetop.mechanics.rotation import Quaternion, axes
from tippetop.views import samples, spacing
from tippetop.views.run_page import read


TENTH, FIFTH = np.radians(0.1), np.radians(0.2)


def rows(run: tt.Run) -> dict[str, np.ndarray]:
    return {str(name): column.values for name, column in run.trajectory.variables.items()}


def attitudes(times: np.ndarray, kept: np.ndarray, at: np.ndarray) -> np.ndarray:
    """The attitudes that a page shows at times `at`."""
    i = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 2)
    h = times[i + 1] - times[i]
    ends = (kept[i, :4], kept[i, 4:7], kept[i + 1, :4], kept[i + 1, 4:7])
    return spacing.attitude(*ends, h, (at - times[i]) / h)


def test_rows_that_are_too_far_apart_are_named() -> None:
    page = tt.run("inverting", until=2.0, output_step=0.05).view()
    assert "rows are far apart" in page.text
    assert "rows are far apart" not in tt.run("inverting", until=2.0, output_step=0.002).view().text


TOPS = ["inverting", "rolling", "heavy-top", "gliding-heavy-top", "gliding-cylinder"]
OUTLINES = ["spinning-egg", "rolling-egg", "spinning-coin", "rolling-coin"]


@pytest.mark.parametrize("preset", TOPS + OUTLINES)
def test_the_horizontal_force_moves_the_centre_of_mass(preset: str) -> None:
    """m r'' = F, place and force being independent columns; L' = a x F would say the same."""
    run = tt.run(preset, until=0.2, output_step=1e-4)
    table, m = rows(run), run.attributes["parameters"]["m"]
    s = samples.samples(table, run.attributes)
    t, place, force = table["time"], s[:, 7:9], s[:, 10:12]
    inner = slice(5, -5)
    pull = m * np.gradient(np.gradient(place, t, axis=0), t, axis=0)[inner]
    scale = np.abs(pull).max()
    assert scale > 0
    assert_near(force[inner], pull, 2e-3 * scale)
    lifted = m * (
        np.gradient(np.gradient(s[:, 9], t), t)[inner] + run.attributes["parameters"]["g"]
    )
    np.testing.assert_allclose(s[inner, 12], lifted, rtol=2e-3)


def test_the_angular_velocity_turns_the_attitude() -> None:
    """Of a top on its stem too: q' = omega q/2."""
    run = tt.run(
        "leine-glocker-stem", friction=dict(law="viscous", mu=3.93), until=0.8, output_step=2e-4
    )
    table = rows(run)
    assert set(np.unique(table["ball"])) == {0, 1}
    s = samples.samples(table, run.attributes)
    turned = angle_between(s[1:, :4], s[:-1, :4]) / np.diff(table["time"])
    rate = np.linalg.norm(s[1:, 4:7] + s[:-1, 4:7], axis=1) / 2
    usual = np.abs(np.diff(s[:, 4:7], axis=0)).max(axis=1) < 2  # not across the impact
    assert usual.mean() > 0.99
    np.testing.assert_allclose(turned[usual], rate[usual], rtol=2e-4)
    touching = s[:, 9] - np.where(table["ball"] == 1, 0.005, 0.015)
    offset = np.where(table["ball"] == 1, 0.016, 0.003)
    third = axes(Quaternion(*s[:, :4].T))[2]
    assert_near(touching, -offset * third.z, 1e-12)


def test_a_part_of_a_run_is_shown_alone(inverting: tt.Run) -> None:
    data = content(inverting.view(2.0, 3.0).text)
    times = np.frombuffer(base64.b64decode(data["times"]), "<f8")
    assert (times[0], times[-1]) == (2.0, 3.0)
    assert all(2.0 <= event["time"] <= 3.0 for event in data["events"])
    with refusal("rows from 7 s to be shown"):
        inverting.view(7.0)


def test_samples_of_many_rows_are_spread_evenly_over_the_time_that_is_shown(
    inverting: tt.Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However many pieces they are read in: 10^7 rows are no larger a page than 10^5."""
    monkeypatch.setattr(spacing, "FEW", 2000)
    table = {k: v for k, v in rows(inverting).items() if np.ndim(v) and len(v) == 6501}
    pieces = [
        {k: v[first : first + 650] for k, v in table.items()} for first in range(0, 6501, 650)
    ]
    times, *_ = read(iter(pieces), inverting.attributes, None, None)
    assert len(times) < 1.15 * 2000
    assert np.diff(times).max() < 0.0041
    part, *_ = read(iter(pieces), inverting.attributes, 2.0, 3.0)
    np.testing.assert_allclose(np.diff(part), 1e-3)  # fewer rows than samples: all


def content(text: str) -> Any:
    """The data of a page."""
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL)
    assert found is not None
    return json.loads(found[1])


def test_what_cannot_be_shown_is_refused_in_a_sentence(tmp_path: Path) -> None:
    with refusal("orientation"):
        tt.run("inverting", until=0.01, orientation=False).view()
    with refusal(r"must have rows .* replay` one"):
        tt.run("inverting", until=0.01, output="keyframes", out=tmp_path / "k.zarr").view()
