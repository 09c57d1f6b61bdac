"""Every wrong command ends with its exit code and one line that says what to write instead."""

import shlex
from pathlib import Path

import pytest
from plans import PLAN
from stores import files
from typed import answered, typed


FILM = "t [s],theta [deg]\n0,5.7\n0.1,5.6\n0.2,5.8\n0.3,5.6\n"
LONG = "n" * 300
COMMANDS: list[tuple[str, int, str]] = [
    # any command
    ("rum inverting", 2, 'Unknown command "rum". Did you mean "run"?'),
    ("run", 2, "SCENARIO must be given. See tippetop run --help."),
    ("run inverting --until 1 --until 2", 2, "--until specified multiple times."),
    ("run inverting --figur x.png", 2, "Unknown option: --figur. Did you mean --figure?"),
    (f"info {LONG}", 5, "File name too long"),
    (f"check {LONG}", 2, "...` is neither a TOML file nor a preset."),
    # run
    ("run invertin", 2, "neither a TOML file nor a preset. Did you mean `inverting`?"),
    ("run inverting --out ''", 2, "`--out` must be a path, but is ''."),
    ("run inverting --out RUN.zarr", 5, "`RUN.zarr` must not exist yet"),
    ("surface inverting --out RUN.zarr", 5, "`RUN.zarr` must not exist yet"),
    ("run inverting --out folder --overwrite", 5, "must be a store of tippetop"),
    ("run inverting --out film.csv/a.zarr", 5, "must be writable"),
    ("run inverting --until 0.1 --figure there.png", 5, "must not exist yet, but does: use --over"),
    (
        'run inverting --set \'run.columns=["theta", "phi_dott"]\'',
        2,
        "'phi_dott'. Did you mean `phi_dot`?",
    ),
    (
        "run inverting --set 'run.columns=[\"psi\"]' --set run.orientation=false",
        2,
        "`run.orientation` must be true where `run.columns` has 'psi', but is false.",
    ),
    ("run inverting --until '2 m'", 2, 'in s or a unit of the same kind, but is "2 m".'),
    ("run PLAN.toml", 2, "this must be a scenario, but is the plan of a sweep"),
    ("check inverting --set system=rolling-tippe-top", 2, "remove the table (--set friction=)"),
    ("run inverting --set run.output=keyframes --figure a.png", 2, "given alone|requires rows"),
    # stores
    ("resume RUN.zarr", 5, "must be unfinished"),
    ("resume RUN.zarr --until=0.1", 2, "must be later than that of"),
    ("export RUN.zarr --to pdf --out a.pdf", 2, "pdf"),
    (
        "export KEPT.zarr --to csv --out a.csv",
        2,
        "must have rows to be exported, but has none: use --gr",
    ),
    ("export inverting --to mjcf --group events --out a", 2, "must be left out with --to mjcf"),
    # replay
    ("replay KEPT.zarr --from=-1 --until 1 --step 0.1 --out a", 2, "must be within 0 and 2"),
    (
        "replay KEPT.zarr --from 2 --until 1 --step 0.1 --out a",
        2,
        "must not end before they begin, but are from 2 to 1 s",
    ),
    (
        "replay KEPT.zarr --from 1 --until 1.00000000000001 --step 1e-15 --out a",
        2,
        "must be at least 1.78e-15 s",
    ),
    # figures
    ("plot RUN.zarr", 2, "--out must be given, with a value."),
    ("plot RUN.zarr spere --out f.png", 2, "Did you mean `sphere`?"),
    ("plot RUN.zarr --size 0x5 --out f.png", 2, "`size` must be between"),
    ("plot BAR.zarr sphere --out f.png", 2, "for tops only; this is `rolling-cylinder`."),
    ("plot KEPT.zarr theta --out f.png", 2, "has none: replay a part"),
    ("plot inverting states --from 1 --out f.png", 2, "require a run, but `inverting` is a scen"),
    # pages
    ("view RUN.zarr --out there.html", 5, "must not exist yet"),
    ("view RUN.zarr --out new.pdf", 2, "--out must end with .html"),
    (
        "view RUN.zarr --out new.html --from 0.2 --until 0.1",
        2,
        "must have rows from 0.2 s to 0.1 s",
    ),
    ("view --out new.html", 2, "pass a store or `--playground`"),
    ("view --playground --until 3 --out new.html", 2, "cannot be used with `--playground`"),
    # sweeps and landscapes
    ("sweep PLAN.toml --out x --workers 1.5", 2, "`--workers` must be a whole number, at least 1"),
    ("potential inverting --D '1 kg' --lambda 0", 2, "`--D` must be in kg m2 s-1"),
    ("surface inverting --D -1:1:1000000000000 --out f.zarr", 2, "at most 10000000 points"),
    ("surface inverting --D 0:1e300:5 --out f.zarr", 2, "`--D` and `--lambda` must keep V finite"),
    ("potential inverting --D 0 --lambda 0 --n 1", 2, "--n must be at least 2"),
    ("surface inverting", 2, "nothing to do: give --out F.zarr, --figure F.png, or both."),
    # measured motions
    ("fit film.csv inverting --free friction.mu --out film.csv", 2, "--out must end with .toml"),
    ("compare film.csv", 2, "a file and a reference must be given"),
    ("compare gone.csv inverting", 2, "CSV or Parquet, but: No such file or directory"),
    ("compare film.csv inverting --up x", 2, "`up` must be one of z, y, but is 'x'."),
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with what the commands name."""
    place = tmp_path_factory.mktemp("wrong")
    keyframes = "--set run.output_step= --set run.output=keyframes"
    assert typed(f"run inverting --until 0.2 --out {place}/RUN.zarr") == 0
    assert typed(f"run inverting --until 2 {keyframes} --out {place}/KEPT.zarr") == 0
    assert typed(f"run rolling-cylinder --until 0.1 --out {place}/BAR.zarr") == 0
    (place / "folder").mkdir()
    texts = {"film.csv": FILM, "PLAN.toml": PLAN}
    for name in ("there.png", "there.html", "folder/precious"):
        texts[name] = "mine"
    for name, text in texts.items():
        (place / name).write_text(text, encoding="utf-8")
    return place


@pytest.mark.parametrize(("words", "code", "message"), COMMANDS)
def test_a_wrong_command_says_what_to_write(
    words: str, code: int, message: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    before = files(folder)
    _, out, said = answered(*shlex.split(words), codes=[code])
    assert any(part in said for part in message.split("|"))
    assert said.count("\n") == 0
    assert out == ""
    assert files(folder) == before
