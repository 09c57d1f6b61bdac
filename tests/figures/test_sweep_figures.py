"""Maps of many tops show the numbers that they are given: cells, colours, borders, labels, read
from the artists.
"""

from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from numpy.testing import assert_allclose, assert_array_equal

from tippetop.figures import sweep_map
from tippetop.figures.style import styled
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


def curves(figure: Figure) -> dict[str, Any]:
    """The lines of the axes by their labels."""
    return {line.get_label(): line for line in figure.axes[0].get_lines()}


def mesh_of(figure: Figure) -> Any:
    return next(
        c
        for c in figure.axes[0].collections
        if c.get_array() is not None and hasattr(c, "get_coordinates")
    )


def test_every_cell_has_the_colour_of_its_class() -> None:
    """By place: the cell of the second spin and the first mu shows what the field has there."""
    field = np.array([[0, 1], [2, 3], [4, 5]], float)
    figure = drawn(a_map("class", (X, Y), {"class": field}))
    mesh = mesh_of(figure)
    assert_array_equal(mesh.get_coordinates()[0, :, 0], X.edges)
    assert_array_equal(mesh.get_coordinates()[:, 0, 1], Y.edges)
    colours = mesh.to_rgba(mesh.get_array()).reshape(2, 3, 4)
    for i, j in np.ndindex(3, 2):
        expected = mpl.colors.to_rgba(sweep_map.colours()[SHOWN[int(field[i, j])]])
        assert_allclose(colours[j, i], expected, atol=1 / 255)
    assert set(sweep_map.colours()) == set(SHOWN)


def test_labels_and_curves_of_a_small_map_are_within_it() -> None:
    """Many classes and borders, and a long label: the panel keeps half of the height."""
    y = MapAxis(Y.of, "viscous friction coefficient of the law μ (s m⁻¹)", Y.edges, True)
    slope = np.log(X.span / 120.0)[:, None] + 0 * Y.span
    borders = {f"λ = λ_{name}: an inverted spin is stable above": slope for name in "use"}
    field = np.arange(6.0).reshape(3, 2) + 1
    for kind in ("class", "normal-force"):
        with styled(size=(3.4, 2.6)):
            figure = drawn(a_map(kind, (X, y), {"class": field}, borders=borders))
            figure.draw_without_rendering()
        (box,) = (
            axes.get_tightbbox().transformed(figure.transFigure.inverted())
            for axes in figure.axes[:1]
        )
        assert box.y1 < 1
        assert figure.axes[0].get_position().height > 0.5


# --- over one axis ------------------------------------------------------------------------------


def test_ends_over_one_axis_are_dots_in_the_colour_of_their_class() -> None:
    kinds = np.array([SHOWN.index(name) for name in ("upright", "inverted", "inverted")], float)
    theta = np.array([0.0, np.pi, np.nan])
    dots = curves(drawn(a_map("class", (X,), {"class": kinds, "theta_end": theta})))
    assert {name for name in dots if not name.startswith("_")} == {"upright", "inverted"}
    assert_array_equal(dots["upright"].get_ydata(), [0.0, np.nan, np.nan])
    assert_array_equal(dots["inverted"].get_ydata(), [np.nan, np.pi, np.nan])
    assert dots["inverted"].get_color() == sweep_map.colours()["inverted"]


def test_times_and_forces_over_one_axis_are_curves() -> None:
    fields = {"inverted_at": np.array([5.0, 4.0, 3.0]), "first_equator": np.array([4.0, 3.0, 2.0])}
    found = curves(drawn(a_map("inversion", (X,), fields)))
    assert_array_equal(found["first θ = π/2"].get_xydata().T, [X.centres, fields["first_equator"]])
    assert_array_equal(found["first θ = π − 0.1"].get_ydata(), fields["inverted_at"])
    fields = {
        "normal_force_min": np.array([0.5, 0.3, 0.0]),
        "normal_force_max": np.array([1.5, 2.0, 3.0]),
    }
    found = curves(drawn(a_map("normal-force", (X,), fields)))
    assert_array_equal(found["least"].get_ydata(), fields["normal_force_min"])
    assert_array_equal(found["greatest"].get_ydata(), fields["normal_force_max"])
