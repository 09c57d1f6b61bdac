"""Runs the benchmarks: python -m bench [--quick] [--case NAME]...

Each case writes bench/results/NAME.json (quick ones bench/results/quick/NAME.json); then the goals are told.
`python -m bench.report` makes tables and figures of the results.
"""

import argparse
import json
import time
from pathlib import Path

from .cases import CASES
from .goals import goals
from .measure import machine
from .report import RESULTS, read


def main() -> None:
    """Runs the cases that are asked for, or all."""
    parser = argparse.ArgumentParser(prog="python -m bench", description="Runs the benchmarks.")
    parser.add_argument("--quick", action="store_true", help="fewer and smaller: in all at most three minutes")
    parser.add_argument("--case", action="append", choices=CASES, metavar="NAME", help=f"one of {', '.join(CASES)}")
    parser.add_argument("--results", type=Path, metavar="FOLDER", help="where the JSON files go")
    options = parser.parse_args()
    folder = options.results or (RESULTS / "quick" if options.quick else RESULTS)
    folder.mkdir(parents=True, exist_ok=True)
    for name in options.case or CASES:
        before, clock = machine(), time.perf_counter()
        found = CASES[name](options.quick)
        took = time.perf_counter() - clock
        whole = {"case": name, "quick": options.quick, "machine": before, "took": round(took, 1), **found}
        path = folder / f"{name}.json"
        path.write_text(json.dumps(whole, indent=1, default=float) + "\n", encoding="utf-8")
        print(f"{name:12}{took:6.0f} s  {path}", flush=True)
    for goal in goals(read(folder)):
        met = {True: "met", False: "not met", None: ""}[goal.met]
        print(f"{goal.what}\n    {goal.goal or 'no goal':32}{met:10}{goal.measured}")


if __name__ == "__main__":
    main()
