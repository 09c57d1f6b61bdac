"""Stores that earlier versions wrote stay readable: one of each layout of format 1, as it was written then."""

import json
import tarfile
from pathlib import Path

import numpy as np
import pytest

import tippetop as tt
from tippetop.cli import outcome
from tippetop.store.provenance import FORMAT_VERSION


STORES = Path(__file__).parents[1] / "reference" / "stores"
WRITTEN = {
    "1-first": "runs as they first were: without the turn of the body, a seal, and an end from which to continue",
    "2-end-in-a-file": "the turn of the body, keyframes, and an end, in a file beside the groups",
    "3-end": "the end is a root attribute, under a seal",
    "4-sweep-and-contact": "a sweep with a run in it, and a run whose contact may change: phases and impacts",
}
"""Archives, and what was new in what they hold, written from 21 to 22 November 2026, before release 0.1. The first
form of the seal, which had another digest for some hours of these days, is not read."""


@pytest.fixture(scope="module", params=sorted(WRITTEN))
def stores(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The stores of an archive."""
    folder = tmp_path_factory.mktemp("old")
    with tarfile.open(STORES / f"{request.param}.tar.xz") as archive:
        safely = {"filter": "data"} if hasattr(tarfile, "data_filter") else {}  # Python 3.11.2 has none
        archive.extractall(folder, **safely)
    return folder


def test_every_archive_is_listed_and_every_format_has_one() -> None:
    assert {path.name.removesuffix(".tar.xz") for path in STORES.glob("*.tar.xz")} == set(WRITTEN)
    assert FORMAT_VERSION == 1, "a new format: stores of it must be among the archives"


FIGURES = {"run": "theta", "contact": "theta"}


def test_they_are_opened_described_exported_and_drawn(
    stores: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = sorted(stores.iterdir())
    assert found
    for store in found:
        kind = store.stem
        if kind == "sweep":
            assert outcome(["info", str(store)]) == 5
            assert "was written by a preview of tippetop (format 1)" in capsys.readouterr().err
            continue
        assert outcome(["info", str(store), "--json"]) == 0, store
        said = json.loads(capsys.readouterr().out)
        assert said.get("status", "finished") == "finished", store
        assert outcome(["info", str(store)]) == 0, store
        table = tmp_path / f"{kind}.csv"
        if kind != "keyframes":  # keeps no rows
            assert outcome(["export", str(store), "--to", "csv", "--out", str(table)]) == 0, store
            assert len(table.read_text().splitlines()) > 2
            drawn = ["plot", str(store), *([FIGURES[kind]] if kind in FIGURES else [])]
            assert outcome([*drawn, "--out", str(tmp_path / f"{kind}.png")]) == 0, store
        capsys.readouterr()


def test_their_numbers_are_those_of_today(stores: Path) -> None:
    """To the rounding that code of another day may have."""
    if not (stores / "run.zarr").exists():
        return
    old = tt.open(stores / "run.zarr")
    run = tt.run("inverting", until=0.2, output_step=0.02)
    assert old.summary.parameters.to_dict() == run.summary.parameters.to_dict()
    for name in ("theta", "omega3", "jellett", "normal_force"):
        np.testing.assert_allclose(old.trajectory[name], run.trajectory[name], rtol=1e-12)
    turnings = old.events.time[old.events.kind == 0]
    np.testing.assert_allclose(turnings, run.events.time[run.events.kind == 0], rtol=0, atol=1e-12)
