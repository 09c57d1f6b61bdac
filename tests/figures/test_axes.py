"""What a figure is where it is shown."""


def test_a_notebook_shows_a_figure_though_nobody_imported_pyplot() -> None:
    from tippetop.figures.style import figure

    assert figure(2.0, 1.0)._repr_png_()[:8] == b"\x89PNG\r\n\x1a\n"  # type: ignore[attr-defined]
