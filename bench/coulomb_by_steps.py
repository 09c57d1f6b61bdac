"""Integrate exact Coulomb friction by steps of fixed length, as R. J. Cohen did in 1977.

usage: python -m bench.coulomb_by_steps [STEP ...]      (seconds; default: 1e-3 5e-4 2e-4 1e-4)

The body, start and friction are those of the preset `cohen-coulomb`. The classical method of Runge
and Kutta takes F = mu N v/|v| as it stands, and steps over the moment at which sliding stops: v
then jumps to and fro about zero by what a step changes it, and friction acts as under a law that
slides for ever. The shorter the step, the later it inverts.
"""

import sys

import numpy as np

from tippetop.mechanics.contact import gliding
from tippetop.mechanics.friction import Coulomb
from tippetop.runs.starting import load


STEPS = (1e-3, 5e-4, 2e-4, 1e-4)
UNTIL = 8.0


def inversion(step: float, until: float = UNTIL) -> float:
    """Return when theta first passes pi/2 [s], by steps of a fixed length; NaN if it does not."""
    form, problem = gliding.VECTOR, load("cohen")  # the same start under the regularised law
    body = problem.body()
    body = body._replace(friction=Coulomb._make((problem.friction.mu, 0.0)))  # v/sqrt(v^2 + 0)
    s, z = np.sin(problem.initial["theta"]), np.cos(problem.initial["theta"])
    angles = problem.system.start(problem.initial, s, z, body)
    y = np.array(form.of_angles(angles, s, z, body), dtype=float)

    def rates(y: np.ndarray) -> np.ndarray:
        return np.array(form.rates(form.units._make(y.tolist()), body), dtype=float)

    for k in range(round(until / step)):
        a = rates(y)
        b = rates(y + step / 2 * a)
        c = rates(y + step / 2 * b)
        y = y + step / 6 * (a + 2 * b + 2 * c + rates(y + step * c))
        if y[2] < 0:
            return (k + 1) * step
    return float("nan")


def main(arguments: list[str]) -> None:
    """Print a line for each step."""
    for step in [float(word) for word in arguments] or STEPS:
        print(f"step {step:g} s: theta passes pi/2 at {inversion(step):.3f} s (nan: never)")


if __name__ == "__main__":
    main(sys.argv[1:])
