"""A sweep's store is the same whoever computes it, and whoever of them is killed."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from plans import PLAN
from stores import assert_same, chunks, ended, wait_until, written
from typed import typed

import tippetop
from tippetop.errors import Unfinished
from tippetop.scenario import build
from tippetop.store import provenance
from tippetop.sweeps import chunk, workers
from tippetop.sweeps.plan import Plan


LINES = chunk.compute_chunk


def test_dask_makes_the_same_store(
    whole: Path,
    file: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Use a scheduler and two workers in threads; a chunk fails, then all succeed."""
    from distributed import LocalCluster

    store = tmp_path / "S.zarr"
    with LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        processes=False,
        dashboard_address=":0",
        protocol="tcp://",
        host="127.0.0.1",
    ) as cluster:
        with monkeypatch.context() as patched:
            patched.setattr(chunk, "compute_chunk", failing)
            assert typed(f"sweep {file} --out {store} --scheduler {cluster.scheduler_address}") == 6
        assert (
            "chunk 2 (tops 14 to 20) failed: ArithmeticError: it will not do."
            in capsys.readouterr().err
        )
        assert chunks(store) == [1, 1, 2, 1]
        tippetop.sweep(file, store, scheduler=cluster.scheduler_address)
    assert_same(store, whole)


def failing(task: chunk.Task, threads: int = 1) -> chunk.Rows:
    """Raises for one chunk."""
    if task.chunk == 2:
        raise ArithmeticError("it will not do")
    return LINES(task, threads)


def start(file: Path, store: Path, *words: str) -> subprocess.Popen:
    code = (
        "from tippetop.cli import main; "
        f"main({['sweep', str(file), '--out', str(store), *words]!r})"
    )
    return subprocess.Popen(
        [sys.executable, "-c", code], stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )


def children(process: subprocess.Popen) -> list[int]:
    """Its worker processes; with setproctitle installed they carry dask's name."""
    names = "spawn_main|dask worker"
    found = subprocess.run(
        ["pgrep", "-P", str(process.pid), "-f", names], capture_output=True, text=True
    )
    return [int(word) for word in found.stdout.split()]


@pytest.fixture(scope="module")
def longer(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A plan of 40 chunks of tenths of a second, and its undisturbed store."""
    folder = tmp_path_factory.mktemp("longer")
    text = PLAN.replace("0.5", "4.0").replace("n = 6", "n = 250").replace("chunk = 7", "chunk = 25")
    (folder / "PLAN.toml").write_text(text)
    tippetop.sweep(folder / "PLAN.toml", folder / "S.zarr", workers=1)
    return folder / "PLAN.toml", folder / "S.zarr"


def wait_for(process: subprocess.Popen, store: Path, done: int) -> None:
    """Waits until so many chunks are done."""
    wait_until(lambda: written(store) >= done, process)


@pytest.mark.slow
def test_killed_workers_cost_nothing(longer: tuple[Path, Path], tmp_path: Path) -> None:
    store = tmp_path / "S.zarr"
    process = start(longer[0], store, "--workers", "2")
    for done in (3, 12, 25):
        wait_for(process, store, done)
        os.kill(children(process)[0], signal.SIGKILL)
    assert ended(process) == (0, "")
    assert_same(store, longer[1])


@pytest.mark.slow
def test_killed_itself_it_goes_on_with_any_number_of_workers(
    longer: tuple[Path, Path], tmp_path: Path
) -> None:
    store = tmp_path / "S.zarr"
    for done, count in ((5, "2"), (14, "1"), (25, "3")):
        process = start(longer[0], store, "--workers", count)
        wait_for(process, store, done)
        process.kill()
        ended(process)
        assert written(store) < 40
    assert ended(start(longer[0], store)) == (0, "")
    assert_same(store, longer[1])


def deadly(task: chunk.Task, threads: int = 1) -> chunk.Rows:
    """Kills its worker for one chunk, raises for another."""
    if task.chunk == 1:
        os._exit(1)
    return failing(task, threads)


@pytest.mark.slow
def test_a_chunk_that_kills_its_workers_takes_no_other_with_it(
    whole: Path, file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = tmp_path / "S.zarr"
    with monkeypatch.context() as patched:
        patched.setattr(chunk, "compute_chunk", deadly)
        with pytest.raises(Unfinished) as error:
            tippetop.sweep(file, store, workers=2)
    assert sorted(error.value.sentences) == [
        "chunk 1 (tops 7 to 13) failed: every worker that tried it died.",
        "chunk 2 (tops 14 to 20) failed: ArithmeticError: it will not do.",
    ]
    assert chunks(store) == [1, 2, 2, 1]
    tippetop.sweep(file, store, workers=1)
    assert_same(store, whole)


@pytest.mark.slow
def test_a_scheduler_may_die_too(longer: tuple[Path, Path], tmp_path: Path) -> None:
    store, address = tmp_path / "S.zarr", "tcp://127.0.0.1:8797"
    dask = [
        sys.executable,
        "-m",
        "distributed.cli.dask_scheduler",
        "--host",
        "127.0.0.1",
        "--port",
        "8797",
    ]
    worker = [
        sys.executable,
        "-m",
        "distributed.cli.dask_worker",
        address,
        "--nthreads",
        "1",
        "--no-dashboard",
    ]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    scheduler = subprocess.Popen([*dask, "--no-dashboard"], **quiet)
    workers = [subprocess.Popen([*worker, "--no-nanny"], **quiet) for _ in range(2)]
    try:
        process = start(longer[0], store, "--scheduler", address)
        wait_for(process, store, 4)
        workers[0].kill()
        wait_for(process, store, 10)
        scheduler.kill()
        code, err = ended(process)
        assert code == 6
        assert "tippetop: the scheduler went away; the results that it returned are stored." in err
    finally:
        for other in (scheduler, *workers):
            other.kill()
            other.wait()
    assert 10 <= written(store) < 40
    tippetop.sweep(longer[0], store, workers=1)
    assert_same(store, longer[1])


@pytest.mark.slow
def test_no_worker_outlives_its_parent(longer: tuple[Path, Path], tmp_path: Path) -> None:
    process = start(longer[0], tmp_path / "S.zarr", "--workers", "2")
    wait_for(process, tmp_path / "S.zarr", 1)
    workers = children(process)
    assert workers
    process.kill()
    ended(process)
    wait_until(lambda: not any(map(runs, workers)))


def runs(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"


def test_workers_get_no_interrupt_while_they_import() -> None:
    with workers.processes(1).start(False) as pool:
        masked = pool.submit(signal.pthread_sigmask, signal.SIG_BLOCK, []).result()
    assert signal.SIGINT in masked
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, [])


@pytest.mark.slow
def test_a_script_without_its_guard_gets_one_sentence(file: Path, tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(f"import tippetop\ntippetop.sweep({str(file)!r}, 'S.zarr', workers=2)\n")
    process = subprocess.run(
        [sys.executable, script], cwd=tmp_path, capture_output=True, text=True, timeout=120
    )
    assert process.stderr.strip().endswith('a script needs `if __name__ == "__main__":`.')


def test_a_worker_of_other_versions_is_refused(file: Path) -> None:
    """Its bits could differ."""
    of = Plan.from_toml(file)
    task = chunk.Task(
        0,
        build.resolved(of.base),
        of.columns(of.tops(0)),
        None,
        {**provenance.versions(), "heyoka": "0"},
    )
    with pytest.raises(
        chunk.OtherVersions, match="other versions of heyoka than the sweep was begun with"
    ):
        chunk.compute_chunk(task)
