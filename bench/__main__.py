"""Runs the benchmarks: python -m bench [--quick] [--case NAME]...

Each case writes bench/results/NAME.json; `python -m bench.report` makes tables and figures of them.
"""

import argparse
import json
import time
from pathlib import Path

from .cases import CASES
from .measure import machine


RESULTS = Path(__file__).parent / "results"


def main() -> None:
    """Runs the cases that are asked for, or all."""
    parser = argparse.ArgumentParser(prog="python -m bench", description="Runs the benchmarks.")
    parser.add_argument("--quick", action="store_true", help="fewer and smaller: in all at most three minutes")
    parser.add_argument("--case", action="append", choices=CASES, metavar="NAME", help=f"one of {', '.join(CASES)}")
    parser.add_argument("--results", type=Path, default=RESULTS, metavar="FOLDER", help="where the JSON files go")
    options = parser.parse_args()
    options.results.mkdir(parents=True, exist_ok=True)
    for name in options.case or CASES:
        before, clock = machine(), time.perf_counter()
        found = CASES[name](options.quick)
        took = time.perf_counter() - clock
        whole = {"case": name, "quick": options.quick, "machine": before, "took": round(took, 1), **found}
        path = options.results / f"{name}.json"
        path.write_text(json.dumps(whole, indent=1, default=float) + "\n", encoding="utf-8")
        print(f"{name:12}{took:6.0f} s  {path}", flush=True)


if __name__ == "__main__":
    main()
