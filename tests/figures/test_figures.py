"""Figures show the numbers that they are given: curves, marks, labels and limits, read back from
the artists.
"""

from typing import Any

import numpy as np
import pytest
import xarray as xr
from examples import CANONICAL
from matplotlib.figure import Figure
from numpy.testing import assert_allclose, assert_array_equal
from refusals import refusal

from tippetop.figures import catalogue, drawing, labels
from tippetop.landscape import landscape_body, marked_lines, surface
from tippetop.library.finished_run import Run
from tippetop.runs import starting
from tippetop.runs.run import solve


PARAMETERS = {**CANONICAL, "I1": 3.008e-6}


@pytest.fixture(scope="module")
def inverting() -> tuple[xr.Dataset, xr.Dataset, dict]:
    """An inversion: its trajectory, its events, its attributes."""
    run = Run(solve(starting.load("inverting", until=8.0)))
    return run.trajectory, run.events, run.attributes


def figure_of(*given: Any) -> Figure:
    figure: Figure = drawing.axes_of(*given).get_figure(root=True)
    return figure


def drawn(kind: str, inverting: tuple) -> Figure:
    """A figure of the inversion, as the catalogue feeds it."""
    trajectory, events, attrs = inverting
    return figure_of(kind, {"trajectory": trajectory, "events": events}, attrs)


def lines(figure: Figure) -> dict[str, Any]:
    """The labelled lines of a figure."""
    found = [line for axes in figure.axes for line in axes.get_lines()]
    return {
        str(line.get_label()): line for line in found if not str(line.get_label()).startswith("_")
    }


def marks(figure: Figure) -> dict[str, np.ndarray]:
    """The places of labelled dots."""
    found = [
        (str(c.get_label()), c.get_offsets()) for axes in figure.axes for c in axes.collections
    ]
    return {label: np.asarray(places) for label, places in found if not label.startswith("_")}


def test_theta_is_drawn_with_its_turnings(inverting: tuple) -> None:
    trajectory, events, _ = inverting
    figure = drawn("theta", inverting)
    curve = lines(figure)["θ(t)"]
    assert_array_equal(curve.get_xdata(), trajectory["time"])
    assert_array_equal(curve.get_ydata(), trajectory["theta"])
    turning = events.isel(event=(events["kind"].values == 0) & events["significant"].values)
    for label, sign in (("maxima: upper envelope", -1), ("minima: lower envelope", 1)):
        some = turning.isel(event=turning["theta_dot_sign"].values == sign)
        assert some.sizes["event"] > 100
        assert_array_equal(marks(figure)[label].T, [some["time"], some["theta"]])
    above, below = figure.axes
    assert above.get_ylabel() == "inclination θ (rad)"
    assert below.get_xlabel() == "time t (s)"
    assert above.get_xlim() == (0.0, 8.0)
    assert [tick.get_text() for tick in above.get_yticklabels()] == ["0", "π/4", "π/2", "3π/4", "π"]


def test_without_turnings_there_is_neither_band_nor_panel_nor_entry(inverting: tuple) -> None:
    trajectory, events, attrs = inverting
    figure = drawn("theta", (trajectory, events.isel(event=slice(0, 0)), attrs))
    assert len(figure.axes) == 1
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["θ(t)"]


@pytest.mark.parametrize("title", ["$x_{$ <b>", "50$ and 60$ $$", "first\n$x_{$"])
def test_a_title_that_is_not_a_formula_is_literal(title: str, inverting: tuple) -> None:
    trajectory, events, attrs = inverting
    look = catalogue.Look(title)
    figure = figure_of("normal-force", {"trajectory": trajectory, "events": events}, attrs, look)
    figure.canvas.draw()
    assert figure.axes[0].get_title(loc="left").replace(r"\$", "$") == title


def test_quantities_of_the_sphere_are_not_drawn_on_the_stem(inverting: tuple) -> None:
    """The modified energy is undefined there, and the run ends later than the sphere."""
    trajectory, events, attrs = inverting
    ball = xr.DataArray(
        (trajectory["time"] > 6.0).astype(np.int8), attrs={"flag_meanings": "body stem"}
    )
    groups = {"trajectory": trajectory.assign(ball=ball), "events": events}
    shown = lines(figure_of("energy", groups, attrs))[
        "modified energy Ẽ; none on the stem, in the air"
    ]
    assert np.asarray(shown.get_xdata())[np.isfinite(shown.get_ydata())].max() == 6.0
    for kind in ("states", "surface"):
        assert "last on its sphere" in lines(figure_of(kind, groups, attrs))
    wells = figure_of("potential", groups, attrs).axes
    assert len(wells) == 6
    assert all(float(axes.get_title(loc="left").split()[2]) <= 6.0 for axes in wells)
    on_stem = groups | {"trajectory": groups["trajectory"].isel(time=slice(6100, None))}
    with refusal("on its stem or in the air"):
        figure_of("potential", on_stem, attrs)


def test_a_title_has_the_letters_of_the_axes_and_units(inverting: tuple) -> None:
    title = drawn("theta", inverting).axes[0].get_title(loc="left")
    assert (
        title == "Rolling and gliding tippe top\nθ(0) = 0.1 rad, ω₃(0) = 155 rad s⁻¹, viscous "
        "friction, μ = 0.3 s m⁻¹"
    )
    given = {"theta": 0.2, "phi_dot": -3.0, "nu_x": 0.5, "centre_at_rest": True, "gap": 1e-7}
    units = {"theta": "rad", "phi_dot": "rad s-1", "nu_x": "m s-1", "gap": "m"}
    attrs = drawing.with_records(
        {"system": "tippe-top", "title": "top", "initial": given, "units": units}
    )
    assert labels.title(attrs) == (
        "Top\nθ(0) = 0.2 rad, φ'(0) = −3 rad s⁻¹, $\\nu_x$(0) = 0.5 m s⁻¹, centre of mass at "
        "rest,\ngap(0) = 1 × 10⁻⁷ m"
    )


def test_normal_force_is_drawn_in_weights_with_its_extremes(inverting: tuple) -> None:
    trajectory, _, attrs = inverting
    weight = attrs["parameters"]["m"] * attrs["parameters"]["g"]
    figure = drawn("normal-force", inverting)
    (axes,) = figure.axes
    assert_allclose(axes.get_lines()[-1].get_ydata(), trajectory["normal_force"] / weight)
    extremes = attrs["report"]["normal_force"]
    dots = [tuple(map(float, c.get_offsets()[0])) for c in axes.collections]
    assert dots == [(extremes[f"t_{key}"], extremes[key] / weight) for key in ("min", "max")]
    words = " ".join(text.get_text() for text in figure.legends[0].get_texts())
    assert f"min {extremes['min'] / weight:.4g} at t = {extremes['t_min']:.5g} s" in words
    assert axes.get_ylim()[0] < 0 < extremes["max"] / weight < axes.get_ylim()[1]


def test_sphere_shows_the_near_side_of_the_path(inverting: tuple) -> None:
    """From above only z > 0, from below only z < 0; a segment's ends are rows of the axis."""
    path = inverting[0]["axis"].values
    figure = drawn("sphere", inverting)
    titles = [axes.get_title(loc="left") for axes in figure.axes[:3]]
    assert titles == ["from the side", "from above", "from below"]
    for axes, sign, mirrored in ((figure.axes[1], 1, 1), (figure.axes[2], -1, -1)):
        segments = np.array(
            next(c for c in axes.collections if c.get_array() is not None).get_segments()
        )
        near = (sign * path[1:, 2] >= 0) & (sign * path[:-1, 2] >= 0)
        assert_array_equal(segments[:, 0], path[:-1, :2][near] * (1, mirrored))
        assert_array_equal(segments[:, 1], path[1:, :2][near] * (1, mirrored))


# --- in the landscape ---------------------------------------------------------------------------


def test_band_is_the_predicted_one_with_the_logged_turnings(inverting: tuple) -> None:
    figure = drawn("band", inverting)
    above, below = figure.axes
    curves = lines(figure)
    assert above.get_ylabel() == "inclination θ (rad)"
    assert_array_equal(curves["θ(t)"].get_ydata(), inverting[0]["theta"])
    low, high = (line.get_ydata() for line in above.get_lines()[1::-1])
    inside = (curves["θ(t)"].get_ydata() > low - 1e-6) & (curves["θ(t)"].get_ydata() < high + 1e-6)
    assert inside.all()
    assert np.nanmedian(below.get_lines()[0].get_ydata()) < 1e-7


def test_surface_is_drawn_with_its_marked_lines() -> None:
    from tippetop.figures import landscape_figures

    D, lam = np.linspace(-6e-4, 8e-4, 21), np.linspace(0, 7e-6, 31)
    top = landscape_body.top(PARAMETERS)
    grid = surface.minimal_surface(top, D, lam)
    axes = landscape_figures.surface(grid, marked_lines.marked_lines(top, lam))
    shown = [line for line in axes.get_lines() if not str(line.get_label()).startswith("_")]
    assert {str(line.get_label()) for line in shown} >= {"spinning, θ = 0", "spinning, θ = π"}
    assert axes.get_zlim() == pytest.approx((float(grid.F.min()), float(grid.F.max())))
    assert "D" in axes.get_xlabel()
    assert "λ" in axes.get_ylabel()
    assert axes.get_zlabel() == "energy (J)"
    on, above = (
        next(line for line in shown if line.get_label() == f"spinning, θ = π{x}")
        for x in ("", ": above F")
    )
    solid, dotted = (np.array(line.get_data_3d()) for line in (on, above))
    both = np.isfinite(solid).all(axis=0)
    assert_array_equal(solid[:, both], dotted[:, both])  # solid above dotted
    assert np.isfinite(dotted).all(axis=0).sum() > both.sum() > 0


@pytest.mark.parametrize("kind", list(catalogue.FIGURES))
def test_every_kind_has_labels_and_a_title(kind: str, inverting: tuple) -> None:
    figure = drawn(kind, inverting)
    labels = [axes.get_xlabel() + axes.get_ylabel() for axes in figure.axes if axes.get_visible()]
    labels += [
        tick.get_text()
        for axes in figure.axes[:1]
        for tick in axes.get_xticklabels()
        if kind == "film"
    ]
    assert any(labels), kind
    texts = [
        figure.get_suptitle(),
        *(axes.get_title(loc=loc) for axes in figure.axes for loc in ("left", "center")),
    ]
    assert any(texts), kind
    assert not any(
        "_" in text.replace("$", "").replace("\\nu_", "") or "3hat" in text for text in texts
    ), kind
