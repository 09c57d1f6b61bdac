"""Whether fits are honest, on many synthetic films of the inversion: `python -m
bench.fit_statistics [--sets 200]`.

Each film has 10 s at 60 frames a second, a fifth of them missing, the axis with 1 degree of noise
in each direction across it. Four numbers are free, and each starts 30 % off, above or below by
chance. Printed are how many fits end at the truth (all four within six standard errors), how often
the 95 % intervals contain it, and the processor time of a fit. `--intervals` begins at the truth,
and only improves the numbers over all of the film: the intervals alone, at a tenth of the cost.
`--cut`: the film, at 30 frames a second, begins 2 s after the start; nine numbers are free, and
only the first azimuth is measured; a fit ends at the truth if none is better that begins at the
truth.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

import tippetop as tt
from tippetop.exchange.fitting import MET, fit, judged
from tippetop.exchange.misfit import Misfit
from tippetop.exchange.observation import Observation
from tippetop.exchange.scales import Space, scale_of
from tippetop.exchange.search import Minimum, local_minimum, widen


TRUE = {
    "friction.mu": 0.3,
    "initial.omega3": 155.0,
    "initial.theta": 0.1,
    "parameters.I1": 131 / 350 * 8e-6,
}
NOISE, MISSING, OFF = np.deg2rad(1.0), 0.2, 0.3
CUT, FRAMES = 60, 270
CUT_TRUE = {
    "friction.mu": 0.27,
    "parameters.I1": 3.05e-6,
    "initial.theta": 0.13,
    "initial.omega3": 148.0,
}
CUT_FREE = ("theta", "theta_dot", "phi", "phi_dot", "omega3", "nu_x", "nu_y")
ERRORS = 6.0  # standard errors within which a fit has ended at the truth


def film(axis: np.ndarray, t: np.ndarray, random: np.random.Generator) -> dict[str, np.ndarray]:
    """What a camera sees of a motion."""
    seen = axis + np.cross(NOISE * random.standard_normal(axis.shape), axis)
    seen /= np.linalg.norm(seen, axis=1)[:, None]
    kept = random.random(len(t)) > MISSING
    return {"t": t[kept], "axis": seen[kept]}


def best_near(observation: Observation, values: dict[str, float]) -> tuple[Misfit, Minimum]:
    """Return the best fit of all of the film next to these numbers."""
    space = Space(values, [scale_of(observation.rule(name), v) for name, v in values.items()])
    misfit = Misfit(observation, space, "linear")
    widen(misfit)
    return misfit, local_minimum(misfit, np.zeros(len(values)), len(observation.t))


def cut_films(sets: int) -> None:
    """Print a line for each fit of a film that begins after the start of the motion."""
    t = np.arange(1, FRAMES) / 30
    rows = f"run.output_times={t.tolist()}"
    changes = [*(f"{k}={v}" for k, v in CUT_TRUE.items()), rows]
    run = tt.run(tt.load("inverting", changes, until=9.0)).trajectory
    axis = run.axis.sel(time=t).values
    true = {name: CUT_TRUE[name] for name in ("friction.mu", "parameters.I1")}
    true |= {f"initial.{name}": float(run[name].sel(time=t[CUT])) for name in CUT_FREE}
    right, wrong, scores = 0, 0, []
    for k in range(sets):
        seen = axis + NOISE * np.random.default_rng(k).standard_normal(axis.shape)
        seen = (seen / np.linalg.norm(seen, axis=1)[:, None])[CUT:]
        phi = float(np.arctan2(seen[0, 1], seen[0, 0]))
        film_of = {"t": t[CUT:] - t[CUT], "axis": seen}
        observation = Observation(tt.load("inverting", [f"initial.phi={phi}"]), list(true), film_of)
        _, best = best_near(observation, true)
        began = time.process_time()
        found = fit(observation, systematic=False)
        seconds = time.process_time() - began
        ratio = float(np.sum(found.residuals["axis"] ** 2)) / best.cost
        errors = {name: (e.value - true[name]) / e.sigma for name, e in found.estimates.items()}
        turns = 2 * np.pi / found.estimates["initial.phi"].sigma
        errors["initial.phi"] -= turns * np.round(errors["initial.phi"] / turns)
        at_truth = ratio < 1 + 1e-4
        right += at_truth
        wrong += found.trustworthy and not at_truth
        scores.append([float(e) for e in errors.values()])
        shown = " ".join(f"{e:+.1f}" for e in scores[-1])
        print(
            f"{k}: {seconds:.1f} s, cost {ratio:.4f}, trustworthy: {found.trustworthy}, errors "
            f"{shown}",
            flush=True,
        )
    print(f"{right} of {sets} ended at the best minimum; {wrong} wrong ones are called trustworthy")
    print("root mean squares of errors:", np.sqrt(np.mean(np.square(scores), axis=0)).round(2))


def main() -> None:
    """Prints a line for each fit, and what all of them say."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sets", type=int, default=200)
    parser.add_argument("--intervals", action="store_true", help="begin at the truth")
    parser.add_argument("--cut", action="store_true", help="films that begin 2 s after the start")
    given = parser.parse_args()
    if given.cut:
        cut_films(given.sets)
        return
    count, off = given.sets, 0.0 if given.intervals else OFF
    t = np.arange(1, 600) / 60
    axis = tt.run("inverting", until=10.0, output_times=t).trajectory.axis.sel(time=t).values
    right, held, seconds = 0, [], []
    for k in range(count):
        random = np.random.default_rng(k)
        seen = film(axis, t, random)
        start = {
            name: float(value * (1 + off * random.choice([-1, 1]))) for name, value in TRUE.items()
        }
        problem = tt.load("inverting", [f"{name}={value!r}" for name, value in start.items()])
        began = time.process_time()
        observation = Observation(problem, list(TRUE), seen)
        if given.intervals:
            misfit, end = best_near(observation, start)
            end = end._replace(searches=MET)
            found = judged(misfit, [end], MET, systematic=False, hopeless=False)
        else:
            found = fit(observation, systematic=False)
        seconds.append(time.process_time() - began)
        errors = [(e.value - TRUE[name]) / e.sigma for name, e in found.estimates.items()]
        where = "at the truth" if max(map(abs, errors)) < ERRORS else "elsewhere"
        print(
            f"{k}: {seconds[-1]:.2f} s, ended {where}, trustworthy: {found.trustworthy}. "
            f"{' '.join(found.reasons)}",
            flush=True,
        )
        if where == "elsewhere":
            continue
        right += 1
        held.append([e.low <= TRUE[name] <= e.high for name, e in found.estimates.items()])
    hold = ", ".join(
        f"{name} {part:.1%}" for name, part in zip(TRUE, np.mean(held, axis=0), strict=True)
    )
    print(
        f"{right} of {count} fits ended at the truth; of these 95 % intervals hold it: {hold}; "
        f"all {np.mean(held):.1%}"
    )
    print(
        f"processor time of a fit: median {np.median(seconds):.2f} s, largest {max(seconds):.2f} s"
    )


if __name__ == "__main__":
    main()
