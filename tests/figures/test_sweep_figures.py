"""Maps of many tops show the numbers that they are given: cells, colours, borders, labels, read
from the artists.
"""

from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from tippetop.figures import sweep_map
from tippetop.sweeps.maps import SHOWN, Map, MapAxis


X = MapAxis("initial.omega3", "spin ω₃ (rad s⁻¹)", np.array([90.0, 110.0, 130.0, 150.0]), False)
Y = MapAxis("friction.mu", "μ", np.array([0.1, 0.2, 0.4]), True)


def drawn(made: Map) -> Figure:
    figure: Any = sweep_map.draw_map(made).get_figure(root=True)
    return figure


def a_map(kind: str, axes: tuple[MapAxis, ...], fields: dict[str, Any], **options: Any) -> Map:
    return Map(kind, "a top", axes, fields, options.get("borders", {}), options.get("notes", []))


def entries(figure: Figure) -> dict[str, Any]:
    """The legend's entries by their words."""
    (legend,) = figure.legends
    return dict(
        zip((text.get_text() for text in legend.get_texts()), legend.legend_handles, strict=True)
    )


def mesh_of(figure: Figure) -> Any:
    return next(
        c
        for c in figure.axes[0].collections
        if c.get_array() is not None and hasattr(c, "_coordinates")
    )


def test_every_cell_has_the_colour_of_its_class() -> None:
    """By place: the cell of the second spin and the first mu shows what the field has there."""
    field = np.array([[0, 1], [2, 3], [4, 5]], float)
    figure = drawn(a_map("class", (X, Y), {"class": field}))
    mesh = mesh_of(figure)
    np.testing.assert_array_equal(mesh._coordinates[0, :, 0], X.edges)
    np.testing.assert_array_equal(mesh._coordinates[:, 0, 1], Y.edges)
    colours = mesh.to_rgba(mesh.get_array()).reshape(2, 3, 4)
    for i, j in np.ndindex(3, 2):
        expected = mpl.colors.to_rgba(sweep_map.colours()[SHOWN[int(field[i, j])]])
        np.testing.assert_allclose(colours[j, i], expected, atol=1 / 255)
    assert set(sweep_map.colours()) == set(SHOWN)


def test_the_legend_names_the_classes_that_are_there() -> None:
    names = [SHOWN.index(name) for name in ("upright", "inverted", "lifted-off")]
    field = np.array([[names[0], names[0]], [names[1], np.nan], [names[2], names[1]]])
    figure = drawn(a_map("class", (X, Y), {"class": field}))
    found = entries(figure)
    assert set(found) == {"upright", "inverted", "lifted off"}
    assert found["inverted"].get_facecolor() == mpl.colors.to_rgba(sweep_map.colours()["inverted"])


def test_axes_have_their_labels_scales_and_limits() -> None:
    figure = drawn(
        a_map("inversion", (X, Y), {"inverted_at": np.ones((3, 2))}, notes=["unfinished"])
    )
    axes = figure.axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == (X.label, Y.label)
    assert (axes.get_xscale(), axes.get_yscale()) == ("linear", "log")
    assert (axes.get_xlim(), axes.get_ylim()) == ((90.0, 150.0), pytest.approx((0.1, 0.4)))
    title = axes.get_title() + axes.get_title(loc="left")
    assert title.startswith("A top: ")
    assert title.endswith("unfinished")


def test_times_of_inversion_are_shown_as_they_are_and_none_is_blank() -> None:
    times = np.array([[1.0, 2.0], [3.0, 4.0], [np.nan, 6.0]])
    figure = drawn(a_map("inversion", (X, Y), {"inverted_at": times}))
    shown = np.ma.asarray(mesh_of(figure).get_array()).reshape(2, 3)
    np.testing.assert_array_equal(shown.filled(np.nan), times.T)
    blank = entries(figure)["not inverted in time"]
    assert figure.axes[0].get_facecolor() == blank.get_facecolor()
    whole = drawn(a_map("inversion", (X, Y), {"inverted_at": np.nan_to_num(times, nan=5.0)}))
    assert not whole.legends


def test_tops_without_a_time_of_inversion_are_told_apart_by_their_end() -> None:
    """Under way, upright, tumbling, lifted off: each has the colour and a word of its own."""
    names = ["under-way", "upright", "near-upright", "lifted-off", "tumbling"]
    times = np.array([[np.nan, np.nan], [np.nan, 4.0], [np.nan, np.nan]])
    ends = np.full((3, 2), np.nan)
    ends[np.isnan(times)] = [SHOWN.index(name) for name in names]
    figure = drawn(a_map("inversion", (X, Y), {"inverted_at": times, "class": ends}))
    legend = entries(figure)
    assert set(legend) == {
        "under way",
        "upright",
        "still near upright",
        "lifted off",
        "tumbling",
    }
    layers = [
        np.ma.asarray(c.get_array()).reshape(2, 3)
        for c in figure.axes[0].collections
        if c.get_array() is not None
    ]
    meshes = [c for c in figure.axes[0].collections if c.get_array() is not None]
    for i, j in zip(*np.nonzero(np.isnan(times)), strict=True):
        (layer,) = [
            k
            for k, values in enumerate(layers)
            if not np.ma.getmaskarray(np.ma.masked_invalid(values))[j, i]
        ]
        colour = meshes[layer].to_rgba(layers[layer][j, i])
        assert colour == pytest.approx(
            mpl.colors.to_rgba(sweep_map.colours()[SHOWN[int(ends[i, j])]]), abs=1 / 255
        )


def contours(figure: Figure) -> list[np.ndarray]:
    """The lines of contours, as points."""
    sets = [c for c in figure.axes[0].collections if isinstance(c, mpl.contour.QuadContourSet)]
    return [path.vertices for c in sets for path in c.get_paths() if len(path.vertices)]


def test_a_border_runs_where_its_function_is_zero() -> None:
    """log(omega3/120): the line omega3 = 120, over all mu, drawn twice; the legend sets its
    letters.
    """
    values = np.log(X.span / 120.0)[:, None] + 0 * Y.span
    figure = drawn(
        a_map(
            "class", (X, Y), {"class": np.ones((3, 2))}, borders={"λ = λ_u: stable below": values}
        )
    )
    lines = contours(figure)
    assert len(lines) == 2
    for line in lines:
        np.testing.assert_allclose(line[:, 0], 120.0, rtol=1e-4)
        assert (line[:, 1].min(), line[:, 1].max()) == pytest.approx((0.1, 0.4))
    assert r"$\lambda = \lambda_u$: stable below" in entries(figure)


def test_liftoff_is_between_the_cells_that_touch_and_those_that_do_not() -> None:
    """The tops of the fastest spin lose contact, one of the middle ones too: the line runs along
    the edges of these cells, from one end of the map to the other.
    """
    force = np.array([[0.5, 0.6], [0.2, 0.0], [0.0, 0.0]])
    figure = drawn(a_map("normal-force", (X, Y), {"normal_force_min": force}))
    (edges,) = [c for c in figure.axes[0].collections if isinstance(c, LineCollection)]
    found = {tuple(map(tuple, np.round(segment, 9))) for segment in edges.get_segments()}
    x, y = X.edges, Y.edges
    assert found == {
        ((x[2], y[0]), (x[2], y[1])),
        ((x[1], y[1]), (x[2], y[1])),
        ((x[1], y[1]), (x[1], y[2])),
    }
    assert any("liftoff" in words for words in entries(figure))
    above = drawn(a_map("normal-force", (X, Y), {"normal_force_min": force + 0.1}))
    assert not above.legends


def test_every_border_is_drawn_however_many_there_are() -> None:
    """There are four strokes: of six borders the last two were left out."""
    borders = {
        f"λ = λ_{i}: above": np.log(X.span / (100.0 + 5 * i))[:, None] + 0 * Y.span
        for i in range(6)
    }
    figure = drawn(a_map("class", (X, Y), {"class": np.ones((3, 2))}, borders=borders))
    assert len(contours(figure)) == 12
    assert sum("above" in words for words in entries(figure)) == 6


# --- over one axis ------------------------------------------------------------------------------


def test_ends_over_one_axis_are_dots_in_the_colour_of_their_class() -> None:
    kinds = np.array([SHOWN.index(name) for name in ("upright", "inverted", "inverted")], float)
    theta = np.array([0.0, np.pi, np.nan])
    figure = drawn(a_map("class", (X,), {"class": kinds, "theta_end": theta}))
    dots = {
        line.get_label(): line
        for line in figure.axes[0].get_lines()
        if not line.get_label().startswith("_")
    }
    assert set(dots) == {"upright", "inverted"}
    np.testing.assert_array_equal(dots["upright"].get_ydata(), [0.0, np.nan, np.nan])
    np.testing.assert_array_equal(dots["inverted"].get_ydata(), [np.nan, np.pi, np.nan])
    assert dots["inverted"].get_color() == sweep_map.colours()["inverted"]


def test_times_and_forces_over_one_axis_are_curves() -> None:
    fields = {"inverted_at": np.array([5.0, 4.0, 3.0]), "first_equator": np.array([4.0, 3.0, 2.0])}
    found = {
        line.get_label(): line
        for line in drawn(a_map("inversion", (X,), fields)).axes[0].get_lines()
    }
    np.testing.assert_array_equal(
        found["first θ = π/2"].get_xydata().T, [X.centres, fields["first_equator"]]
    )
    np.testing.assert_array_equal(found["first θ = π − 0.1"].get_ydata(), fields["inverted_at"])
    fields = {
        "normal_force_min": np.array([0.5, 0.3, 0.0]),
        "normal_force_max": np.array([1.5, 2.0, 3.0]),
    }
    found = {
        line.get_label(): line
        for line in drawn(a_map("normal-force", (X,), fields)).axes[0].get_lines()
    }
    np.testing.assert_array_equal(found["least"].get_ydata(), fields["normal_force_min"])
    np.testing.assert_array_equal(found["greatest"].get_ydata(), fields["normal_force_max"])


@pytest.mark.parametrize("level", [120.0, 121.0])
def test_a_border_over_one_axis_is_a_line_where_its_function_changes_sign(level: float) -> None:
    """On a point of the scan and between two; where theory has no number there is no line."""
    values = np.log(X.span / level)
    values[X.span > 135.0] = np.nan
    fields = {"inverted_at": np.ones(3), "first_equator": np.ones(3)}
    figure = drawn(
        a_map("inversion", (X,), fields, borders={"λ = λ_de: less energy above": values})
    )
    (line,) = figure.axes[0].get_lines()[2:]
    assert line.get_label() == r"$\lambda = \lambda_{de}$: less energy above"
    np.testing.assert_allclose(line.get_xdata(), level, rtol=0, atol=1.01 * np.diff(X.span)[0])


def test_a_border_that_is_passed_twice_has_two_lines_and_one_entry() -> None:
    fields = {"inverted_at": np.ones(3), "first_equator": np.ones(3)}
    values = (X.span - 101.0) * (X.span - 139.0)
    figure = drawn(a_map("inversion", (X,), fields, borders={"λ = λ_s: above": values}))
    found = [line.get_xdata()[0] for line in figure.axes[0].get_lines()[2:]]
    assert found == pytest.approx([101.0, 139.0], abs=1.01 * np.diff(X.span)[0])
    assert [text.get_text() for text in figure.legends[0].get_texts()].count(
        r"$\lambda = \lambda_s$: above"
    ) == 1
