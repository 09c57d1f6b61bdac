"""The best of the field, each given the same formulas, compiled: one function per peer, which makes
it ready once and then gives a solver for a tolerance. A peer that is not installed is named as
missing.
"""

import ctypes
import importlib.util
import warnings
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from .minimal import COMPILER, Minimal


COMPILED, CALLING = "compiled", "calls back into Python"
LADDER = (1e-8, 1e-10, 1e-12, 1e-13, 1e-14, 1e-15, 1e-16, 1e-17)
FEW = (1e-9, 1e-11, 1e-13, 1e-15, 1e-17)
MOST_STEPS = 10**8


class Solver(NamedTuple):
    """A peer at a tolerance: `work(setup())` is timed, `theta()` gives theta at the samples [rad],
    untimed.
    """

    work: Callable[[Any], Any]
    theta: Callable[[], np.ndarray]
    setup: Callable[[], Any] = lambda: None
    tops: int = 1  # that the work integrates


class Peer(NamedTuple):
    """A contestant: `prepare(minimal)` compiles, and gives `solver(tolerance)`."""

    name: str
    kind: str
    prepare: Callable[[Minimal], Callable[[float], Solver]]
    needs: str | None = None
    package: str | None = None  # to be installed, where it is called otherwise
    tolerances: tuple[float, ...] = LADDER

    @property
    def missing(self) -> str | None:
        """Why it cannot take part; None if it can."""
        if self.needs == "c++":
            return None if COMPILER else "no C++ compiler"
        if self.needs and importlib.util.find_spec(self.needs) is None:
            return f"{self.package or self.needs} is not installed"
        return None


def sentence(error: Exception) -> str:
    """The first line of what a peer said when it broke."""
    return f"{type(error).__name__}: {error}".splitlines()[0]


def rows_solver(minimal: Minimal, rows: Callable[[], np.ndarray]) -> Solver:
    """A solver whose work gives states at 0 and the samples, (k + 1, n)."""
    return Solver(lambda _: rows(), lambda: minimal.theta(np.ascontiguousarray(rows())[1:]))


def dop853_cpp(minimal: Minimal) -> Callable[[float], Solver]:
    """Our own, compiled with the right-hand side inside: as good as DOP853 can be written."""
    from .dop853 import Compiled

    solve = Compiled(minimal)
    return lambda tolerance: rows_solver(minimal, partial(solve, tolerance))


def numbalsoda(minimal: Minimal) -> Callable[[float], Solver]:
    """Return the compiled DOP853 of numbalsoda, on a C function."""
    import numbalsoda as package

    address = ctypes.cast(minimal.built.rhs, ctypes.c_void_p).value

    def rows(tolerance: float) -> np.ndarray:
        found, success = package.dop853(
            address, minimal.start, minimal.times, rtol=tolerance, atol=tolerance, mxstep=MOST_STEPS
        )
        if not success:
            raise ArithmeticError("it gave up")
        return found

    return lambda tolerance: rows_solver(minimal, partial(rows, tolerance))


def diffrax(minimal: Minimal) -> Callable[[float], Solver]:
    """Dopri8 of diffrax, on JAX, compiled for the processor."""
    import diffrax as package
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)
    times, n = jnp.asarray(minimal.times), len(minimal.names)
    term = package.ODETerm(lambda t, y, _: jnp.stack(minimal.rates([y[i] for i in range(n)])))

    def solver(tolerance: float) -> Solver:
        control = package.ClipStepSizeController(
            package.PIDController(tolerance, tolerance), step_ts=times
        )

        @jax.jit
        def go(start):
            return package.diffeqsolve(
                term,
                package.Dopri8(),
                times[0],
                times[-1],
                1e-3,
                start,
                saveat=package.SaveAt(ts=times),
                stepsize_controller=control,
                max_steps=None,
                adjoint=package.ForwardMode(),
            ).ys

        start = jnp.asarray(minimal.start)
        return rows_solver(minimal, lambda: np.asarray(go(start).block_until_ready()))

    return solver


def scipy_dop853(minimal: Minimal) -> Callable[[float], Solver]:
    """solve_ivp's DOP853; from sample to sample, because its dense output is less exact than its
    steps.
    """
    from numba import njit
    from scipy.integrate import solve_ivp

    slope = minimal.jitted

    @njit(error_model="numpy", nogil=True)
    def rates(t, y):
        d = np.empty_like(y)
        slope(y, d)
        return d

    rates(0.0, minimal.start)  # compile

    def rows(tolerance: float) -> np.ndarray:
        found, step = [minimal.start], None
        for span in zip(minimal.times[:-1], minimal.times[1:], strict=True):
            # SciPy warns that a tolerance of 1e-15 is too small
            with warnings.catch_warnings(action="ignore"):
                made = solve_ivp(
                    rates,
                    span,
                    found[-1],
                    method="DOP853",
                    rtol=tolerance,
                    atol=tolerance,
                    first_step=step,
                )
            found.append(made.y[:, -1])
            step = min(made.t[-2] - made.t[-3], span[1] - span[0]) if len(made.t) > 2 else None
        return np.array(found)

    return lambda tolerance: rows_solver(minimal, partial(rows, tolerance))


FIELD = (
    Peer("DOP853, C++", COMPILED, dop853_cpp, "c++"),
    Peer("DOP853, numbalsoda", COMPILED, numbalsoda, "numbalsoda"),
    Peer("Dopri8, diffrax", COMPILED, diffrax, "diffrax", tolerances=FEW),
    Peer("DOP853, SciPy", CALLING, scipy_dop853, "scipy", tolerances=FEW),
)
