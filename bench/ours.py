"""The engine as its users call it, and heyoka as a competent user would call it without
the engine.
"""

from collections.abc import Callable
from dataclasses import replace

import heyoka as hy
import numpy as np

from tippetop.engine.driver import Driver
from tippetop.engine.expressions import equations_of_motion, formulas_of
from tippetop.engine.taylor import driver_of
from tippetop.mechanics.operand import leaves
from tippetop.mechanics.units import SECOND
from tippetop.problem import Problem
from tippetop.runs.run import solve

from .minimal import Minimal, theta_of
from .peers import Peer, Solver


OURS, PLAIN = "tippetop", "heyoka"
TAYLOR = (1e-8, 1e-11, 1e-13, 1e-15, 0.0)  # 0: to rounding
WHOLE = (1e-8, 1e-13, 0.0)
ENDLESS = 1 << 62  # steps


class NoRows:
    """A request for nothing."""

    rows_at_steps = False

    def next_times(self) -> np.ndarray:
        """No times."""
        return np.zeros(0)

    def add_rows(self, times: np.ndarray, states: np.ndarray) -> None:
        """None come."""


def at(minimal: Minimal, tolerance: float) -> Problem:
    """The problem at a tolerance, with rows at the samples; without the orientation of the body,
    which no peer has.
    """
    tolerance = tolerance or 2.0**-52
    return replace(minimal.problem, tolerance=tolerance, times=minimal.samples, orientation=False)


def end_of(problem: Problem) -> float:
    """The end, internal."""
    return problem.until / float(problem.scales.of(SECOND))


def _solved(problem: Problem) -> np.ndarray:
    return theta_of(problem, solve(problem).rows)


def alone(problem: Problem) -> hy.taylor_adaptive_dbl:
    """An integrator of the engine's equations of motion and integrals, and of nothing else."""
    sys = equations_of_motion(
        formulas_of(problem.system, problem.form.name, type(problem.friction)), problem.variables
    ).rates
    pars = [float(leaf) for leaf in leaves(problem.internal_body)]
    return hy.taylor_adaptive(
        sys, problem.start(), pars=pars, tol=problem.tolerance or 2.0**-52, high_accuracy=True
    )


def motion(minimal: Minimal) -> Callable[[float], Solver]:
    """The engine's own equations of motion without integrals, as a peer gets them."""
    problem = minimal.problem
    sys = equations_of_motion(
        formulas_of(problem.system, problem.form.name, type(problem.friction)), problem.variables
    ).rates[: problem.variables.moving]
    used = [int(str(p)[1:]) for p in hy.get_params([rate for _, rate in sys])]
    pars = [float(leaf) for leaf in leaves(problem.internal_body)][: max(used, default=-1) + 1]

    def solver(tolerance: float) -> Solver:
        made = hy.taylor_adaptive(
            sys, minimal.start, pars=pars, tol=tolerance or 2.0**-52, high_accuracy=True
        )
        return _driven(minimal, made, minimal.theta)

    return solver


def equations(minimal: Minimal) -> Callable[[float], Solver]:
    """The engine's own equations of motion and integrals, without events: what the integration
    itself costs.
    """

    def solver(tolerance: float) -> Solver:
        problem = at(minimal, tolerance)
        return _driven(minimal, alone(problem), lambda rows: theta_of(problem, rows))

    return solver


def with_events(minimal: Minimal) -> Callable[[float], Solver]:
    """The engine's driver: the steps, and all events of the system with their states; extremes of
    the force.
    """

    def solver(tolerance: float) -> Solver:
        problem = at(minimal, tolerance)
        return Solver(
            to_the_end,
            lambda: _solved(problem),
            lambda: driver_of(problem),
        )

    return solver


def to_the_end(driver: Driver) -> None:
    """Advance a driver to the end of its run: one call returns when the sample buffer is full."""
    while driver.advance(NoRows(), ENDLESS).status is None:
        pass


def solved(minimal: Minimal) -> Callable[[float], Solver]:
    """`tippetop.run` with the rows of the preset and their orientation, as a user waits for it."""

    def solver(tolerance: float) -> Solver:
        problem = at(minimal, tolerance)
        asked = replace(problem, orientation=True, times=minimal.problem.times)
        return Solver(lambda _: solve(asked), lambda: _solved(problem))

    return solver


def _driven(
    minimal: Minimal, made, theta: Callable[[np.ndarray], np.ndarray], scale: float = 1.0
) -> Solver:
    """propagate_until, from a fresh start each time; theta at the samples from the same steps."""
    start, times = made.state.copy(), minimal.times * scale

    def fresh():
        made.time = 0.0
        made.state[:] = start
        return made

    def sampled() -> np.ndarray:
        return theta(np.array(fresh().propagate_grid(times)[-1])[1:])

    return Solver(lambda _: fresh().propagate_until(times[-1]), sampled)


def by_hand(minimal: Minimal) -> Callable[[float], Solver]:
    """The tippe top written straight into heyoka, as a competent user would: vectors, SI units,
    numbers for parameters. [T 3.12, 3.16, 3.17]
    """
    sys = tippe_top_by_hand(minimal)
    start = start_by_hand(minimal)
    second = float(minimal.problem.scales.of(SECOND))

    def solver(tolerance: float) -> Solver:
        made = hy.taylor_adaptive(sys, start, tol=tolerance or 2.0**-52, high_accuracy=True)
        return _driven(
            minimal, made, lambda y: np.arctan2(np.hypot(y[:, 0], y[:, 1]), y[:, 2]), second
        )

    return solver


def start_by_hand(minimal: Minimal) -> np.ndarray:
    """3hat, L, r' in SI units at t = 0, by the engine."""
    problem = minimal.problem
    record, _ = problem.variables.split(problem.start())
    scales = problem.scales
    names = ("ux", "uy", "uz", "Lx", "Ly", "Lz", "rx_dot", "ry_dot")
    return np.array(
        [float(getattr(record, n) * scales.of(getattr(problem.form.units, n))) for n in names]
    )


def tippe_top_by_hand(minimal: Minimal) -> list[tuple[hy.expression, hy.expression]]:
    """Return the equations of motion."""
    p, mu = minimal.problem.parameters, minimal.problem.friction.mu
    m, R, alpha, I1, I3, g = (p[name] for name in ("m", "R", "alpha", "I1", "I3", "g"))
    ux, uy, uz, Lx, Ly, Lz, rx, ry = q = hy.make_vars(
        "ux", "uy", "uz", "Lx", "Ly", "Lz", "rx", "ry"
    )
    L3 = Lx * ux + Ly * uy + Lz * uz
    ux_t, uy_t, uz_t = (
        (Ly * uz - Lz * uy) / I1,
        (Lz * ux - Lx * uz) / I1,
        (Lx * uy - Ly * ux) / I1,
    )
    wx, wy = (Lx / I1 + (1 / I3 - 1 / I1) * L3 * ux, Ly / I1 + (1 / I3 - 1 / I1) * L3 * uy)
    vx, vy = rx + R * alpha * ux_t - R * wy, ry + R * alpha * uy_t + R * wx
    L2, vu = Lx**2 + Ly**2 + Lz**2, vx * ux + vy * uy
    N = (m * g * I1**2 + m * R * alpha * (uz * L2 - Lz * L3)) / (
        I1**2
        + m * I1 * R**2 * alpha**2 * (1 - uz**2)
        - m * I1 * R**2 * alpha * (1 - alpha * uz) * mu * vu
    )
    h = mu * R * (1 - alpha * uz)
    rates = (
        ux_t,
        uy_t,
        uz_t,
        N * (R * alpha * uy - h * vy),
        N * (-R * alpha * ux + h * vx),
        -mu * N * R * alpha * (ux * vy - uy * vx),
        -mu * N * vx / m,
        -mu * N * vy / m,
    )
    return list(zip(q, rates, strict=True))


ENGINE = (
    Peer("tippetop, motion alone", OURS, motion, tolerances=TAYLOR),
    Peer("tippetop, equations only", OURS, equations, tolerances=TAYLOR),
    Peer("tippetop, events on", OURS, with_events, tolerances=TAYLOR),
    Peer("tippetop, whole run with rows and orientation", OURS, solved, tolerances=WHOLE),
)
HAND = Peer("heyoka by hand", PLAIN, by_hand, tolerances=TAYLOR)
