"""Films of real tops by independent equations, fitted by the right model and by wrong ones:
`python -m bench.film_campaign [KIND ...] [--films N] [--first SEED]`.

The equations are Newton's and Euler's in the space frame with the normal force from the constraint,
integrated by SciPy: they share no formula with the package. Kinds: `level` (viscous friction on a
level table), `far` (the same, but the search begins up to 30 % off), `tilt` (0.1 to 0.5 degrees),
`air` (a torque -c omega), `disc` (Coulomb friction of a disc of 0.05 to 0.3 mm), `all`, and
`wooden` (`wooden-toy` of the package, with noise). Films have 2, 3 or 8 s, theta or the axis, 30 or
240 frames a second, and noise of 1 degree; each is fitted as if it were `level` (`disc`: by exact
Coulomb friction).

Printed for each film are the errors in standard errors and in total errors, which include the
systematic one, and for each kind how often 95 % intervals contain the truth, and how often a fit is
trustworthy although a number is off by more than three total errors.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

import tippetop as tt


NOISE = np.deg2rad(1.0)
M, R, ALPHA, I1, I3, G = 0.020, 0.020, 0.3, 131 / 350 * 8e-6, 3.2e-6, 9.82
KINDS = {"level": 20, "far": 20, "tilt": 20, "air": 20, "disc": 20, "all": 10, "wooden": 20}


def film(
    times: np.ndarray, theta: float, spin: float, mu: float, world: dict[str, float]
) -> np.ndarray:
    """Return the axis (rows, 3) of a top whose centre is at rest when it is let go."""
    up = np.array([0.0, 0.0, 1.0])
    tilt, turn = world.get("tilt", 0.0), world.get("azimuth", 0.0)
    along = np.sin(tilt)
    weight = M * G * np.array([along * np.cos(turn), along * np.sin(turn), -np.cos(tilt)])
    disc = world.get("disc", 0.0)

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        e = y[:3] / np.linalg.norm(y[:3])
        momentum, velocity = y[3:6], y[6:9]
        spin = momentum @ e / I3
        omega = momentum / I1 + (1 - I3 / I1) * spin * e
        e_dot = np.cross(omega, e)
        arm = R * (ALPHA * e - up)
        slip = velocity + np.cross(omega, arm)
        slip[2] = 0.0

        def moved(force: float) -> tuple[float, np.ndarray, np.ndarray]:
            torque = -world.get("c", 0.0) * omega
            push = -mu * force * slip
            if disc:  # Coulomb friction of a disc under Zhuravlev's fractions
                speed, around = np.linalg.norm(slip), disc * abs(omega[2])
                push /= speed + 8 * around / (3 * np.pi) + 1e-9
                drill = around / (16 / (3 * np.pi) * around + 5 * speed + 1e-9)
                torque = torque - up * np.sign(omega[2]) * mu * force * disc * drill
            total = force * up + push
            change = np.cross(arm, total) + torque
            spin_dot = (change @ e + momentum @ e_dot) / I3
            omega_dot = change / I1 + (1 - I3 / I1) * (spin_dot * e + spin * e_dot)
            bent = np.cross(omega_dot, e) + np.cross(omega, e_dot)
            return (total + weight)[2] / M + R * ALPHA * bent[2], change, (total + weight) / M

        none, one = moved(0.0)[0], moved(M * G)[0]
        _, change, acceleration = moved(-none * M * G / (one - none))
        return np.concatenate([e_dot, change, acceleration])

    axis = np.array([np.sin(theta), 0.0, np.cos(theta)])
    start = np.concatenate([axis, I3 * spin * axis, np.zeros(3)])
    found = solve_ivp(
        rates, (0, times[-1]), start, method="DOP853", rtol=1e-10, atol=1e-13, t_eval=times
    )
    return (found.y[:3] / np.linalg.norm(found.y[:3], axis=0)).T


def world_of(kind: str, random: np.random.Generator) -> dict[str, float]:
    """Return what a film of a kind has that the model lacks."""
    every = {
        "tilt": {"tilt": np.deg2rad(random.uniform(0.1, 0.5)), "azimuth": random.uniform(0, 6.28)},
        "air": {"c": random.uniform(0.5e-8, 5e-8)},
        "disc": {"disc": random.uniform(0.5e-4, 3e-4)},
    }
    if kind == "all":
        return {**every["tilt"], **every["air"], **every["disc"]}
    return every.get(kind, {})


def seen_of(kind: str, seed: int, path: Path) -> tuple[tt.Problem, dict[str, float], float]:
    """Write a film; return the scenario of its fit, the truth, and the plausible distance."""
    random = np.random.default_rng((sum(map(ord, kind)), seed))
    if kind == "wooden":
        t = np.linspace(0, 3.0, 301)
        rows = tt.run("wooden-toy", until=3.0, output_times=t).trajectory
        columns = [rows.theta.values]
        true = dict(zip(("friction.mu", "initial.omega3"), (0.15, 250.0), strict=True))
        true |= {"initial.theta": 0.1, "parameters.alpha": 0.1688}
        preset, extra, within = "wooden-toy", [], 0.01
    else:
        world = world_of(kind, random)
        sharp = "disc" in world
        t = np.arange(0, random.choice([2.0, 3.0, 8.0]), 1 / random.choice([30, 240]))
        mu = random.uniform(0.1, 0.3) if sharp else random.uniform(0.2, 0.4)
        true = {"friction.mu": mu, "initial.omega3": random.uniform(130, 180)}
        true |= {"initial.theta": random.uniform(0.2, 0.5), "parameters.I1": I1}
        axis = film(t, true["initial.theta"], true["initial.omega3"], mu, world)
        theta = np.arccos(np.clip(axis[:, 2], -1, 1))
        columns = [theta] if random.random() < 0.5 else list(axis.T)
        preset, within = "inverting", {"far": 0.4}.get(kind, 0.05 if sharp else 0.1)
        extra = ["initial.centre_at_rest=true", *(["friction.law=coulomb"] if sharp else [])]
    noise = NOISE * random.standard_normal((len(columns), len(t)))
    if len(columns) == 3:
        axis = np.array(columns) + np.cross(noise.T, np.array(columns).T).T
        columns = list(axis / np.linalg.norm(axis, axis=0))
    else:
        columns = [columns[0] + noise[0]]
    header = "t [s],theta [rad]" if len(columns) == 1 else "t [s],axis_x,axis_y,axis_z"
    np.savetxt(path, np.column_stack([t, *columns]), delimiter=",", header=header, comments="")
    off = {"wooden": 0.005, "far": 0.3}.get(kind, 0.03) * random.uniform(-1, 1, len(true))
    guess = [f"{n}={float(v * (1 + d))!r}" for (n, v), d in zip(true.items(), off, strict=True)]
    return tt.load(preset, [*extra, *guess]), true, within


def main() -> None:
    """Print a line for each film, and a summary of each kind."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("kinds", nargs="*", default=list(KINDS))
    parser.add_argument("--films", type=int, help="of each kind")
    parser.add_argument("--first", type=int, default=0, help="seed of the first film")
    given = parser.parse_args()
    for kind in given.kinds:
        held, wrong, found, trusted, seconds = [], 0, 0, 0, []
        count = given.films or KINDS[kind]
        for seed in range(given.first, given.first + count):
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / "film.csv"
                problem, true, within = seen_of(kind, seed, path)
                starts = {"wooden": 1, "disc": 3, "all": 3}.get(kind, 12)
                began = time.process_time()
                fit = tt.fit(
                    path, problem, list(true), noise=NOISE, within=within, starts=starts,
                    progress=False,
                )  # fmt: skip
                seconds.append(time.process_time() - began)
            errors = {n: e.value - true[n] for n, e in fit.estimates.items()}
            sigmas = [abs(errors[n]) / e.sigma for n, e in fit.estimates.items()]
            totals = [
                abs(errors[n]) / np.hypot(e.sigma, e.systematic) for n, e in fit.estimates.items()
            ]
            if not np.isnan(next(iter(fit.estimates.values())).low):
                held += [e.low <= true[n] <= e.high for n, e in fit.estimates.items()]
            found += max(sigmas) < 6
            trusted += fit.trustworthy
            wrong += fit.trustworthy and max(totals) > 3
            print(
                f"{kind} {seed}: {seconds[-1]:.1f} s, trustworthy {fit.trustworthy}, standard "
                f"errors {np.round(sigmas, 1)}, total {np.round(totals, 2)}. {fit.reason}",
                flush=True,
            )
        part = f"{np.mean(held):.1%} of {len(held)}" if held else "none"
        print(
            f"{kind}: {count} films, {found} within 6 standard errors, {trusted} trustworthy, "
            f"{wrong} of them off by more than 3 total errors; 95 % intervals hold: {part}; "
            f"processor time: median {np.median(seconds):.1f} s, largest {max(seconds):.1f} s",
            flush=True,
        )


if __name__ == "__main__":
    main()
