"""Attacks on the product: it is killed, its stores are damaged, its input is nonsense, its physics
extreme.

usage: python tests/attacks [CAMPAIGN ...] [--seconds S] [--count N] [--seed S] [--results FILE]
[--case NUMBER]

CAMPAIGN is one of kills, damage, scenarios, extremes; without it, all. Each says in its own
file what it does, how it judges, and what it cannot see. --count is the number of tries of each
campaign (default: its own); no case is begun after --seconds of a campaign's share. Every verdict
is a line of --results, a failure with what repeats it: `--seed` and `--case` do it again. Exit
code: 0 nothing failed, 1 something did, 3 time was over before the end.
"""

import argparse
import importlib
import sys
import tempfile
import time
import zlib
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from forking import apart, judged
from verdict import Verdict, table


CAMPAIGNS = {
    "kills": 0.3,
    "damage": 0.12,
    "scenarios": 0.26,
    "extremes": 0.18,
}  # shares of the time


def judge(module: Any, prepared: Any, seed: int, number: int, folder: Path) -> Verdict:
    """The verdict on one case, whose numbers come from seed, campaign and number alone."""
    rng = np.random.default_rng([seed, zlib.crc32(module.__name__.encode()), number])
    verdict = module.attack(number, rng, folder, prepared)
    verdict.repeat |= {"seed": seed}
    return verdict


def run(
    name: str,
    options: argparse.Namespace,
    seconds: float,
    folder: Path,
    note: Callable[[Verdict], None],
) -> list[Verdict]:
    """The verdicts of a campaign."""
    module, began = importlib.import_module(name), time.monotonic()
    count, first = (options.count or module.COUNT, 0) if options.case is None else (1, options.case)
    prepared = module.prepare(folder, count, first)
    verdicts = []
    for verdict in judged(
        partial(judge, module, prepared, options.seed), count, began + seconds, folder, first
    ):
        verdict.campaign = name
        note(verdict)
        verdicts.append(verdict)
    return verdicts


def main() -> int:
    """Runs the campaigns, each in a fork that has compiled nothing before; prints the table."""
    parser = argparse.ArgumentParser(description="Attacks on the product.")
    parser.add_argument("campaigns", nargs="*", metavar="CAMPAIGN", help=", ".join(CAMPAIGNS))
    parser.add_argument("--seconds", type=float, default=1150.0, help="for all campaigns together")
    parser.add_argument("--count", type=int, help="tries of each campaign")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--case", type=int, help="only this case")
    parser.add_argument(
        "--results", type=Path, help="a line of JSON for each verdict is added here"
    )
    options = parser.parse_args()
    wanted = options.campaigns or list(CAMPAIGNS)
    if unknown := sorted({*wanted} - {*CAMPAIGNS}):
        parser.error(f"a campaign must be one of {', '.join(CAMPAIGNS)}, but is {unknown[0]}")

    def note(verdict: Verdict) -> None:
        if options.results is not None:
            with options.results.open("a", encoding="utf-8") as file:
                file.write(verdict.line() + "\n")
        if verdict.failed:
            print(
                f"{verdict.campaign} {verdict.number}: {verdict.kind}: {verdict.what[-1500:]}",
                flush=True,
            )

    importlib.import_module("tippetop.cli")
    verdicts, deadline, whole = [], time.monotonic() + options.seconds, True
    for i, name in enumerate(wanted):
        share = CAMPAIGNS[name] / sum(CAMPAIGNS[other] for other in wanted[i:])
        clock = time.monotonic()
        with tempfile.TemporaryDirectory(prefix="attacks-") as folder:
            part = apart(
                partial(run, name, options, share * (deadline - clock), Path(folder), note)
            )
        if not isinstance(part, list):
            raise SystemExit(f"{name} failed itself: {part}")
        tries = sum(v.tries for v in part)
        print(f"{name}: {tries} tries in {time.monotonic() - clock:.0f} s", flush=True)
        module = importlib.import_module(name)
        whole &= tries >= (options.count or module.COUNT) or options.case is not None
        verdicts += part
    print(table(verdicts, wanted))
    failures = [v for v in verdicts if v.failed]
    return 1 if failures else 0 if whole else 3


if __name__ == "__main__":
    sys.exit(main())
