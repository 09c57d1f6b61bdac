"""Run the benchmarks: python -m bench [--quick] [--case NAME]...

Each case writes bench/results/NAME.json (with --quick, bench/results/quick/NAME.json).
`python -m bench.report` makes tables and figures from the results.
"""

import argparse
import multiprocessing
import sys
from pathlib import Path

from .cases import CASES, carry_out
from .report import RESULTS


def main() -> None:
    """Runs the cases that are asked for, or all."""
    parser = argparse.ArgumentParser(prog="python -m bench", description="Runs the benchmarks.")
    parser.add_argument(
        "--quick", action="store_true", help="fewer and smaller: in all at most three minutes"
    )
    parser.add_argument(
        "--case", action="append", choices=CASES, metavar="NAME", help=f"one of {', '.join(CASES)}"
    )
    parser.add_argument("--results", type=Path, metavar="FOLDER", help="where the JSON files go")
    options = parser.parse_args()
    folder = options.results or (RESULTS / "quick" if options.quick else RESULTS)
    folder.mkdir(parents=True, exist_ok=True)
    for name in options.case or CASES:
        # in separate processes: threads, heaps and compiled code of one case would slow the next
        process = multiprocessing.get_context("spawn").Process(
            target=carry_out, args=(name, options.quick, folder)
        )
        process.start()
        process.join()
        if process.exitcode:
            sys.exit(process.exitcode)


if __name__ == "__main__":
    main()
