"""Certify the references of the contact benchmark: `python -m bench.certificates [--check]`.

`tippetop.benchmark.certifying` finds the error and the horizon.
`rounding` are the fractions of the last digit from which the export rounds up.
The result is a data file of the package; with `--check` nothing is written, and the exit code is 1
if a reference has lost its certificate.
"""

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np

import tippetop
from tippetop.benchmark import case, names
from tippetop.benchmark.case_files import scaled
from tippetop.benchmark.certifying import certificate
from tippetop.benchmark.truth import sample_times, truth


PATH = Path(tippetop.__file__).parent / "benchmark" / "certificates.json"
LARGEST = 1e-10


def threshold(values: np.ndarray) -> float:
    """Return the fraction from which numbers are rounded up: the middle of the widest gap."""
    fractions = values % 1
    fractions = np.sort(fractions[(fractions > 0.25) & (fractions < 0.75)])
    ends = np.concatenate([[0.25], fractions, [0.75]])
    widest = int(np.diff(ends).argmax())
    return round(float(ends[widest] + ends[widest + 1]) / 2, 6)


def certified(name: str) -> dict[str, Any]:
    """Return the certificate of a case, with the rounding of its columns."""
    problem = case(name).problem
    exact, _ = truth(problem, sample_times(problem), "longdouble")
    rounding = {header: threshold(values) for header, (values, _) in scaled(exact).items()}
    return certificate(problem) | {"rounding": rounding}


def main() -> int:
    """Certify every case."""
    parser = argparse.ArgumentParser(prog="python -m bench.certificates", description=__doc__)
    parser.add_argument("--check", action="store_true")
    check = parser.parse_args().check
    made = {name: certified(name) for name in names()}
    for name, each in made.items():
        print(
            f"{name:22} error {each['error']:.1e}, horizon {each['horizon']:g} s, "
            f"growth {each['growth']:g}"
        )
    lost = [name for name, each in made.items() if not each["error"] < LARGEST]
    if check:
        known = json.loads(PATH.read_text(encoding="utf-8"))
        lost += [name for name in made if made[name]["horizon"] != known[name]["horizon"]]
    else:
        PATH.write_text(json.dumps(made, indent=2) + "\n", encoding="utf-8")
    print(f"without a certificate: {', '.join(lost) or 'none'}")
    return bool(lost)


if __name__ == "__main__":
    raise SystemExit(main())
