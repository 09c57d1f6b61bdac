"""Certify the references of the contact benchmark: `python -m bench.certificates [--check]`.

The error of a reference is the largest difference between its runs in double and in 80-bit numbers.
Its horizon is the time at which an error of 1e-10 of the start has grown to 1e-3: by the
variational equations, or, where the contact may open, by a second run whose start differs by 1e-12.
`rounding` are the fractions of the last digit from which the export rounds up.
The result is a data file of the package; with `--check` nothing is written, and the exit code is 1
if a reference has lost its certificate.
"""

import argparse
import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np

import tippetop
from tippetop.benchmark import Case, case, names
from tippetop.benchmark.case_files import scaled
from tippetop.benchmark.truth import Truth, differences, sample_times, truth
from tippetop.mechanics.contact.body import size
from tippetop.runs.growth import growth


PATH = Path(tippetop.__file__).parent / "benchmark" / "certificates.json"
LARGEST = 1e-10
APART = 1e-12
BLIND = 1e7
"""Growth of an error of the start beyond which results say nothing about an engine."""


def growth_of(each: Case, double: Truth) -> tuple[str, np.ndarray]:
    """Return how the growth of small errors was found, and the growth at each row."""
    problem, t = each.problem, double.t
    if problem.contact is None:
        return "variational equations (lyapunov)", growth(problem, t).factor
    moved = dict(problem.initial)
    angle = "tilt" if "tilt" in moved else "theta"
    moved[angle] = moved.get(angle, 0.0) + APART
    if moved.get("omega3"):
        moved["omega3"] *= 1 + APART
    near, _ = truth(dataclasses.replace(problem, initial=moved), t)
    apart = differences(near, double)
    off = np.maximum(apart["attitude [rad]"], apart["position [m]"] / size(problem.body()))
    return "two runs started 1e-12 apart", off / APART


def threshold(values: np.ndarray) -> float:
    """Return the fraction from which numbers are rounded up: the middle of the widest gap."""
    fractions = values % 1
    fractions = np.sort(fractions[(fractions > 0.25) & (fractions < 0.75)])
    ends = np.concatenate([[0.25], fractions, [0.75]])
    widest = int(np.diff(ends).argmax())
    return round(float(ends[widest] + ends[widest + 1]) / 2, 6)


def certificate(name: str) -> dict[str, Any]:
    """Return the certificate of a case."""
    each = case(name)
    times = sample_times(each.problem)
    (double, _), (exact, _) = truth(each.problem, times), truth(each.problem, times, "longdouble")
    by, factor = growth_of(each, double)
    beyond = np.flatnonzero(factor > BLIND)
    rows = len(times) if not len(beyond) else int(beyond[0])
    off = {key: float(curve[:rows].max()) for key, curve in differences(double, exact).items()}
    error = max(off["attitude [rad]"], off["position [m]"] / size(each.problem.body()))
    return {
        "error": float(f"{error:.1e}"),
        "against": "the run in 80-bit numbers, which is exported",
        "errors": {key: float(f"{value:.1e}") for key, value in off.items()},
        "horizon": float(f"{times[rows - 1]:.6g}"),
        "horizon_by": by,
        "growth": float(f"{factor[:rows].max():.2g}"),
        "rounding": {header: threshold(values) for header, (values, _) in scaled(exact).items()},
    }


def main() -> int:
    """Certify every case."""
    parser = argparse.ArgumentParser(prog="python -m bench.certificates", description=__doc__)
    parser.add_argument("--check", action="store_true")
    check = parser.parse_args().check
    made = {name: certificate(name) for name in names()}
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
