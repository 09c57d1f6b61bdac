"""`tippetop film`: an MP4 or a GIF of any size, or one sentence and an exit code."""

from pathlib import Path

import numpy as np
import pytest
from nightly import at_night
from typed import refused, typed


encoder = pytest.importorskip("imageio_ffmpeg", reason="no encoder: pip install 'tippetop[film]'")


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # of the reader
@pytest.mark.parametrize(
    ("name", "options", "frames", "seconds"),
    [
        at_night("top.mp4", "", 5, 0.2),
        ("top.mp4", "--fps 50 --speed 0.5 --from 0.1", 10, 0.2),
        ("top.gif", "--fps 30 --from 0.1", 4, 0.12),  # at 33.3 frames a second
    ],
)
def test_a_film_has_its_size_and_lasts_as_long_as_the_motion(
    short_run: Path, tmp_path: Path, name: str, options: str, frames: int, seconds: float
) -> None:
    out = tmp_path / name
    assert typed(f"film {short_run} --out {out} --size 161x120 {options}") == 0
    assert encoder.count_frames_and_secs(str(out)) == (frames, pytest.approx(seconds, abs=0.005))
    reader = encoder.read_frames(str(out))
    assert next(reader)["size"] == (160, 120)
    pictures = [np.frombuffer(picture, np.uint8).reshape(120, 160, 3) for picture in reader]
    moved = np.abs(pictures[0].astype(int) - pictures[-1]).max(axis=2) > 20
    assert 0.005 < moved.mean() < 0.5, "the body moves on a floor that is almost empty"
    assert [path.name for path in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize(
    ("options", "code", "words"),
    [
        ("x.avi", 2, "must end with .mp4 or .gif"),
        ("x.mp4 --size 8x5", 2, "from 16 to 8192 pixels"),
        ("x.mp4 --size big", 2, "width x height, such as 1280x720"),
        ("x.mp4 --speed 0", 2, "--speed positive"),
        ("x.mp4 --fps nan", 2, "--fps from 1 to 100"),
        ("x.mp4 --from 0.2", 2, "must have two rows"),
        ("x.mp4 --from 7", 2, "must have rows from 7 s"),
        ("is.mp4", 5, "use --overwrite"),
    ],
)
def test_a_film_that_cannot_be_made_is_refused(
    short_run: Path,
    tmp_path: Path,
    options: str,
    code: int,
    words: str,
) -> None:
    (tmp_path / "is.mp4").touch()
    assert words in refused(f"film {short_run} --out {tmp_path}/{options}", code)
    assert [path.name for path in tmp_path.iterdir()] == ["is.mp4"]


def test_a_film_of_a_sweep_is_refused(whole: Path, tmp_path: Path) -> None:
    assert "must be a run to be viewed, but is a sweep" in refused(
        f"film {whole} --out {tmp_path}/x.mp4"
    )


def test_too_many_frames_and_an_encoder_without_ffmpeg_are_refused(
    short_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert "must have at most 100000 frames" in refused(
        f"film {short_run} --out {tmp_path}/x.mp4 --speed 1e-9"
    )

    def absent() -> None:
        raise RuntimeError("No ffmpeg exe could be found.")

    monkeypatch.setattr(encoder, "get_ffmpeg_exe", absent)
    assert "requires the encoder ffmpeg" in refused(f"film {short_run} --out {tmp_path}/x.mp4")
