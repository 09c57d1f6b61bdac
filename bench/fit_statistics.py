"""Whether fits are honest, on many synthetic films of the inversion: `python -m bench.fit_statistics [--sets 200]`.

Each film has 10 s at 60 frames a second, a fifth of them missing, the axis with 1 degree of noise in each direction
across it. Four numbers are free, and each starts 30 % off, above or below by chance. Said is how many fits end at the
truth (all four within six standard errors), how often the 95 % intervals hold it, and the processor time of a fit.
`--intervals` begins at the truth, and only improves the numbers over all of the film: what the intervals say, at a
tenth of the cost.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

import tippetop as tt
from tippetop.exchange.fitting import Fit, fit, judged
from tippetop.exchange.misfit import Misfit
from tippetop.exchange.motion import Motion
from tippetop.exchange.observation import Observation
from tippetop.exchange.scales import Space, scale_of
from tippetop.exchange.search import finished


TRUE = {"friction.mu": 0.3, "initial.omega3": 155.0, "initial.theta": 0.1, "parameters.I1": 131 / 350 * 8e-6}
NOISE, MISSING, OFF = np.deg2rad(1.0), 0.2, 0.3
ERRORS = 6.0  # standard errors within which a fit has ended at the truth


def film(axis: np.ndarray, t: np.ndarray, random: np.random.Generator) -> Motion:
    """What a camera sees of a motion."""
    seen = axis + np.cross(NOISE * random.standard_normal(axis.shape), axis)
    seen /= np.linalg.norm(seen, axis=1)[:, None]
    kept = random.random(len(t)) > MISSING
    return Motion(t[kept], None, seen[kept], None, None, None, None, None)


def improved(observation: Observation) -> Fit:
    """The fit next to where an observation starts."""
    begin = observation.start()
    space = Space(begin, [scale_of(observation.rule(name), value) for name, value in begin.items()])
    misfit = Misfit(observation, space, "linear")
    return judged(misfit, finished(misfit, space.start))


def main() -> None:
    """Prints a line for each fit, and what all of them say."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sets", type=int, default=200)
    parser.add_argument("--intervals", action="store_true", help="begin at the truth")
    given = parser.parse_args()
    count, off = given.sets, 0.0 if given.intervals else OFF
    t = np.arange(1, 600) / 60
    axis = tt.run("inverting", until=10.0, output_times=t).trajectory.axis.sel(time=t).values
    right, held, seconds = 0, [], []
    for k in range(count):
        random = np.random.default_rng(k)
        seen = film(axis, t, random)
        start = {name: float(value * (1 + off * random.choice([-1, 1]))) for name, value in TRUE.items()}
        problem = tt.load("inverting", [f"{name}={value!r}" for name, value in start.items()])
        began = time.process_time()
        observation = Observation(problem, list(TRUE), seen)
        found = improved(observation) if given.intervals else fit(observation)
        seconds.append(time.process_time() - began)
        errors = [(e.value - TRUE[name]) / e.sigma for name, e in found.estimates.items()]
        where = "at the truth" if max(map(abs, errors)) < ERRORS else "elsewhere"
        print(
            f"{k}: {seconds[-1]:.2f} s, ended {where}, converged: {found.converged}. {' '.join(found.reason)}",
            flush=True,
        )
        if where == "elsewhere":
            continue
        right += 1
        held.append([e.low <= TRUE[name] <= e.high for name, e in found.estimates.items()])
    hold = ", ".join(f"{name} {part:.1%}" for name, part in zip(TRUE, np.mean(held, axis=0), strict=True))
    print(
        f"{right} of {count} fits ended at the truth; of these 95 % intervals hold it: {hold}; all {np.mean(held):.1%}"
    )
    print(f"processor time of a fit: median {np.median(seconds):.2f} s, largest {max(seconds):.2f} s")


if __name__ == "__main__":
    main()
