"""What people stumbled over: each wrong word on the command line gets a sentence that says what to
write instead.
"""

import json
import sys
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import tippetop as tt
from tippetop import cli
from tippetop.cli.application import COMMANDS, application
from tippetop.figures import catalogue
from tippetop.mechanics.systems import SYSTEMS
from tippetop.store import root


def test_a_time_may_have_a_unit(tmp_path: Path, said: Callable) -> None:
    a, b = tmp_path / "a.zarr", tmp_path / "b.zarr"
    said(f"run inverting --until '1/1200 min' --out {a}")
    assert root.attributes(a)["run"]["until"] == 0.05
    said(f"replay {a} --from '10 ms' --until 0.02 --step '1e3 us' --out {b}")
    np.testing.assert_array_equal(tt.open(b).trajectory.time, 0.01 + np.arange(11) * 0.001)


def test_a_picture_in_a_store_is_refused_before_the_store_is_replaced(
    tmp_path: Path, said: Callable
) -> None:
    store = tmp_path / "a.zarr"
    said(f"run inverting --until 0.05 --out {store}")
    again = f"run inverting --until 0.02 --out {store} --overwrite --figure {store}/a.png"
    assert "must lie outside of every store" in said(again, code=5)[1]
    assert root.attributes(store)["run"]["until"] == 0.05


def test_help_of_plot_lists_every_kind(said: Callable) -> None:
    text = " ".join(said("plot --help")[0].replace("│", " ").split())
    assert all(f"{name}: {figure.shows}" in text for name, figure in catalogue.FIGURES.items())
    assert all(f"{name}: {shows}" in text for name, shows in catalogue.SWEEP_KINDS.items())


def test_every_argument_and_option_has_help() -> None:
    app = application()
    for command in COMMANDS:
        for argument in app[command].assemble_argument_collection(parse_docstring=True):
            assert argument.parameter.help, (command, argument.name)


def test_systems_lists_every_system(said: Callable) -> None:
    text = " ".join(said("systems")[0].split())
    found = json.loads(said("systems --json")[0])
    for name, system in SYSTEMS.items():
        assert f"{name}: {system.title}" in text
        assert found[name]["integrals"] == ", ".join(system.integrals) or "none"


def test_json_keys_are_names_and_units_are_values(said: Callable) -> None:
    found = json.loads(said("check inverting --json")[0])
    assert found["at_start"]["jellett"]["unit"] == "kg m3 s-1"
    assert found["at_start"]["jellett"]["value"] == pytest.approx(6.8944413e-06)
    assert found["thresholds"]["lambda_s"]["unit"] == "kg m3 s-1"


def test_an_empty_value_removes_a_key_or_a_table(said: Callable) -> None:
    words = "check inverting --set system=rolling-tippe-top --set friction= --json"
    assert "friction" not in json.loads(said(words)[0])


def test_negative_ranges_work_as_typed(tmp_path: Path, said: Callable) -> None:
    grid = "--D -1e-4:1e-4:3 --lambda -1e-6:1e-6:3"
    said(f"surface inverting {grid} --out {tmp_path}/s.zarr")
    assert "F = " in said("potential inverting --D -1e-4 --lambda -4e-6")[0]
    assert "F = " in said("potential flying --D -1e-4 --lambda 4e-6")[0]  # its sphere's


def test_warnings_are_lines_of_ours_on_stderr(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(cli, "outcome", lambda _: warnings.warn("two\nlines", stacklevel=1) or 0)
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        with pytest.raises(SystemExit):
            cli.main([])
    assert capsys.readouterr() == ("", "tippetop: warning: two lines\n")


@pytest.mark.parametrize(
    ("missing", "words", "extra"),
    [
        ("matplotlib", "run inverting --until 0.1 --out r.zarr --figure f.png", "figures"),
        ("pyarrow", "export {} --to parquet --out r.pq", "export"),
        ("h5netcdf", "export {} --to netcdf --out r.nc", "export"),
        ("imageio_ffmpeg", "film {} --out r.mp4", "film"),
    ],
)
def test_what_an_extra_brings_is_missed_before_anything_is_made(
    missing: str, words: str, extra: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    said: Callable,
) -> None:  # fmt: skip
    store, place = tmp_path / "a.zarr", tmp_path / "empty"
    said(f"run inverting --until 0.1 --out {store}")
    place.mkdir()
    monkeypatch.chdir(place)
    monkeypatch.setitem(sys.modules, missing, None)
    assert (
        said(words.format(store), code=2)[1] == f"tippetop: {missing} is required, but not "
        f"installed: pip install 'tippetop[{extra}]', or in a checkout '.[{extra}]'.\n"
    )
    assert list(place.iterdir()) == []
