"""`tippetop film`: a store becomes a film, drawn frame by frame."""

from __future__ import annotations

from typing import Any

from .streams import report
from .values import Place, Seconds, sides


FORMATS: dict[str, dict[str, Any]] = {
    ".mp4": {},
    ".gif": {  # each frame has colours of its own
        "codec": "gif",
        "pix_fmt_out": "pal8",
        "output_params": [
            "-filter_complex",
            "split[a][b];[a]palettegen=stats_mode=single[p];[b][p]paletteuse=new=1:dither=none",
        ],
    },
}
"""Settings of the encoder."""

MOST_FRAMES = 100_000
"""As many as an hour of 28 frames a second."""


def film(
    store: Place,
    *,
    out: Place,
    size: str = "1280x720",
    fps: float = 25,
    speed: float = 1,
    from_: Seconds | None = None,
    until: Seconds | None = None,
    overwrite: bool = False,
) -> int:
    """Write a film of a run: an MP4 or GIF of any size, drawn frame by frame.

    Parameters
    ----------
    store
        A store that `run` or `replay` wrote, finished, with rows and their orientation.
    out
        The film to write: a name that ends with .mp4 or .gif.
    size
        Width and height in pixels, rounded to even numbers.
    fps
        Frames per second; of a GIF the nearest of 50, 33, 25, 20 and so on, for its times are in
        hundredths of a second.
    speed
        Seconds of the motion in a second of the film: 0.1 shows it ten times slower.
    from_
        Show the run from this time on [s].
    until
        Show it up to this time [s].
    overwrite
        Replace an existing film.
    """
    import numpy as np
    from imageio_ffmpeg import get_ffmpeg_exe, write_frames

    from ..errors import InputError
    from ..figures.film import frames
    from ..mechanics.contact.surroundings import moving_axes
    from ..runs.shape import rotation, shape
    from ..store import chunks, files, root
    from ..views import run_page, samples, spacing

    sizes = [2 * round(side / 2) for side in sides(size, "1280x720")]
    fits = all(16 <= side <= 8192 for side in sizes) and 1 <= fps <= 100 and speed > 0
    if out.suffix not in FORMATS or not fits:
        raise InputError(
            "--out must end with .mp4 or .gif, --size be from 16 to 8192 pixels, --fps from 1 to "
            f"100, and --speed positive, but they are {out}, {size}, {fps:g} and {speed:g}."
        )
    if out.suffix == ".gif":
        fps = 100 / max(2, round(100 / fps))
    try:
        get_ffmpeg_exe()
    except RuntimeError as error:
        raise InputError(f"a film requires the encoder ffmpeg, but: {error}") from None
    attrs = root.attributes(store)
    run_page.refuse(attrs, str(store))
    pieces = chunks.pieces(store, "trajectory", samples.needed(attrs))
    times, kept, _, notes = run_page.read(pieces, attrs, from_, until)
    for note in notes + moving_axes(attrs):
        report(note)
    count = (times[-1] - times[0]) * fps / speed
    if count > MOST_FRAMES:
        raise InputError(
            f"a film must have at most {MOST_FRAMES} frames, but has {count:.3g}: a larger --speed "
            "or a shorter part makes fewer."
        )
    shown = np.arange(times[0], times[-1], speed / fps)
    if not shown.size:
        raise InputError("a film must have two rows, but there is one.")
    # channels of `samples.samples`: 0-3 orientation, 7-9 centre of mass, 19 theta
    at = spacing.interpolated(times, kept, shown)
    texts = [
        f"{t:.3f} s   θ = {theta:.1f}°   {speed:g}×"
        for t, theta in zip(shown, np.degrees(at[:, 19]), strict=True)
    ]
    with files.replacing(out, overwrite=overwrite) as scratch:
        film = write_frames(
            str(scratch),
            sizes,
            "rgba",
            fps=fps,
            macro_block_size=2,
            ffmpeg_log_level="error",
            **FORMATS[out.suffix],
        )
        film.send(None)  # starts the generator, which then takes a frame by each `send`
        for picture in frames(at[:, :4], at[:, 7:10], texts, shape(attrs), rotation, sizes):
            film.send(picture)
        film.close()
    print(f"{out}: {len(texts)} frames")
    return 0
