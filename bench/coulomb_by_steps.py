"""Integrate exact Coulomb friction by steps of fixed length, as R. J. Cohen did in 1977.

usage: python -m bench.coulomb_by_steps [STEP ...]      (seconds; default: 1e-3 5e-4 2e-4 1e-4)

The body, start and friction are those of the preset `cohen-coulomb`. The classical method of Runge
and Kutta takes F = mu N v/|v| as it stands, and steps over the moment at which sliding stops: v
then jumps to and fro about zero by what a step changes it, and friction acts as under a law that
slides for ever. The shorter the step, the later it inverts.
"""

import sys
from typing import Any

import numpy as np

from tippetop.mechanics.contact import gliding
from tippetop.mechanics.contact.gliding import VectorState, sliding_velocity
from tippetop.mechanics.friction import Coulomb
from tippetop.problem import Problem
from tippetop.runs.starting import load


STEPS = (1e-3, 5e-4, 2e-4, 1e-4)
UNTIL = 8.0


def inversion(problem: Problem, step: float, until: float = UNTIL) -> tuple[float, float]:
    """When theta first passes pi/2 (NaN: not until the end), and the largest |v_A| of the last
    tenth [m/s].

    Parameters
    ----------
    problem
        A gliding tippe top with set-valued friction.
    step, until
        [s].

    Returns
    -------
    time, speed
        SI.
    """
    form, body = gliding.VECTOR, problem.body()
    body = body._replace(friction=Coulomb._make((body.friction.mu, 0.0)))  # v/sqrt(v^2 + 0)
    start = load("cohen")  # the same body and start under the regularised law
    angles = start.system.start(
        start.initial, np.sin(start.initial["theta"]), np.cos(start.initial["theta"]), body
    )
    s, z = np.sin(start.initial["theta"]), np.cos(start.initial["theta"])
    y = np.array(form.of_angles(angles, s, z, body), dtype=float)

    def rates(y: np.ndarray) -> np.ndarray:
        return np.array(form.rates(VectorState._make(y.tolist()), body), dtype=float)

    when, speed = float("nan"), 0.0
    for k in range(round(until / step)):
        a = rates(y)
        b = rates(y + step / 2 * a)
        c = rates(y + step / 2 * b)
        y = y + step / 6 * (a + 2 * b + 2 * c + rates(y + step * c))
        if y[2] < 0 and np.isnan(when):
            when = (k + 1) * step
        if k * step > 0.9 * until:
            speed = max(speed, slides(y, body))
    return when, speed


def slides(y: np.ndarray, body: Any) -> float:
    """|v_A| [m/s]."""
    v = sliding_velocity(VectorState._make(y.tolist()), body)
    return float(np.hypot(v.x, v.y))


def main(arguments: list[str]) -> None:
    """Prints a line for each step."""
    problem = load("cohen-coulomb")
    for step in [float(word) for word in arguments] or STEPS:
        when, speed = inversion(problem, step)
        outcome = "does not invert" if np.isnan(when) else f"inverts at {when:.3f} s"
        print(
            f"step {step:g} s: {outcome} within {UNTIL:g} s; |v_A| up to {speed:.2g} m/s at the end"
        )


if __name__ == "__main__":
    main(sys.argv[1:])
