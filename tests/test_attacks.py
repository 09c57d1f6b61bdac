"""The attacks of the nightly run, a handful of each: nothing is lost, wrong, hanging or without a
sentence.
"""

import json
import subprocess
import sys
from pathlib import Path

import pytest


ATTACKS = Path(__file__).parent / "attacks"


@pytest.mark.parametrize(
    "campaigns",
    ["scenarios", pytest.param("kills damage scenarios extremes", marks=pytest.mark.slow)],
)
def test_a_few_attacks_find_nothing(campaigns: str, tmp_path: Path) -> None:
    """Without the plans: their lanes compile for half a minute."""
    results = tmp_path / "attacks.jsonl"
    words = f"{ATTACKS} {campaigns} --count 6 --seconds 400 --results {results}"
    done = subprocess.run([sys.executable, *words.split()], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    verdicts = [json.loads(line) for line in results.read_text().splitlines()]
    assert {v["campaign"] for v in verdicts} == {*campaigns.split()}
    assert all(v["repeat"] for v in verdicts)


def test_what_fails_is_counted_and_repeated(tmp_path: Path) -> None:
    """A campaign that finds something ends with 1, and says with which seed and case it does so
    again.
    """
    (tmp_path / "scenarios.py").write_text(
        "COUNT = 4\n"
        "from verdict import Verdict\n"
        "def prepare(folder, count, first): return None\n"
        "def attack(number, rng, folder, prepared):\n"
        "    import os, time\n"
        "    if number == 1: os.kill(os.getpid(), 11)\n"
        "    if number == 2: raise RuntimeError('a fault of its own')\n"
        "    return Verdict('wrong' if number == 3 else 'same', str(rng.integers(10**9)))\n"
    )
    results = tmp_path / "attacks.jsonl"
    code = (
        "import runpy, sys; sys.path[:0] = sys.argv.pop(1).split(); "
        "runpy.run_path(sys.argv.pop(1), None, '__main__')"
    )
    command = [sys.executable, "-c", code, f"{tmp_path} {ATTACKS}"]
    command += f"{ATTACKS}/__main__.py scenarios --results {results}".split()
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 1, done.stdout + done.stderr
    verdicts = {v["number"]: v for v in map(json.loads, results.read_text().splitlines())}
    assert [verdicts[n]["kind"] for n in range(4)] == ["same", "crash", "traceback", "wrong"]
    again = subprocess.run([*command, "--case", "3"], capture_output=True, text=True)
    assert f"scenarios 3: wrong: {verdicts[3]['what']}" in again.stdout
