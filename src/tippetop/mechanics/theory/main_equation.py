"""The main equation as an equation of motion: from D(t) and E~(t) of a run back to theta(t). [T 4.40, 5.26]

The equation of first order, z'^2 = Q(z, t) with z = cos(theta), has a branch point at every turning angle. There Q and
Q_t vanish together, which fixes time and angle of the turning; the smooth solution through it is a power series. From
there the equation of second order, z'' = Q_z/2 + Q_t/(2 z'), is integrated outwards, forward and backward in time:
towards a turning it would lose what it knows, away from it errors do not grow. Half-way the pieces must meet.
Where nothing depends on time, Q_t = 0 for every angle, and the equation of second order is all that is needed.
"""

from typing import Any, NamedTuple

import numpy as np

from ..system import System


COMPLEX_STEP = 1e-30
WAYS = np.array([1j * COMPLEX_STEP, 0.0])  # of z, and of t
ORDER = 10  # of the power series at a turning
REACH = 0.06  # of the time between turnings, where the series hands over
APART = 1e-6  # of z where two pieces meet: nothing beyond is to be relied on; a good one has 1e-9 and less
MEET = 0.5  # of the largest z'^2 of a swing: where the piece from the next turning takes over
CONSTANT = 1e-11  # relative: momenta and energy that vary less than this are constants of the motion
QUARTER = np.pi / 4  # the phase that is left there, where z'' = z' in units of the frequency


class Reconstruction(NamedTuple):
    """z = cos(theta) at the times asked for (NaN after the last swing that ends in a turning, or before the first two
    pieces that do not meet), times of the turnings, and the worst mismatch of z where pieces meet."""

    z: np.ndarray
    turnings: np.ndarray
    mismatch: float


def reconstruct(
    system: System, b: Any, times: np.ndarray, momenta: list[np.ndarray], energy: np.ndarray, z: float, period: float
) -> Reconstruction:
    """theta(t) from E~(t) = inertia(z) theta'^2 + V(z, *momenta(t)). [T 4.40, 5.26]

    Parameters
    ----------
    system
        A system with `potential` and `theta_inertia`.
    b
        Its body, SI.
    times
        Times of the rows [s], ascending, (n,), the first at a turning angle.
    momenta
        The momenta that the potential takes, at the times, each (n,), SI.
    energy
        E~ at the times [J], (n,).
    z
        cos(theta) at the first time.
    period
        A guess of the period of nutation [s].

    Returns
    -------
    Reconstruction
        z at the times. Nothing else of the run is read.
    """
    equation = _Equation(system, b, times, momenta, energy, period)
    if all(np.ptp(values) <= CONSTANT * np.abs(values).max() for values in (energy, *momenta)):
        return equation.conserving(times, z)
    out, known, mismatch = np.full(len(times), np.nan), float(times[0]), 0.0
    turnings: list[Any] = []
    reach = REACH * period / 2
    here = _series(equation, float(times[0]), z, reach, fixed=True)
    while True:
        forward, meet, last = equation.outward(here, 1.0, float(times[-1]))
        _fill(out, times, known, here.t + reach, here)
        _fill(out, times, here.t + reach, meet, lambda t, f=forward: f(t)[0])
        known = meet
        if meet >= times[-1]:
            return Reconstruction(out, np.array(turnings), mismatch)
        left = QUARTER * abs(last[1] / equation.motion(meet, last)[1])  # what a harmonic swing would still need
        there = _series(equation, meet + left, last[0] + last[1] * left / 2, reach)
        if there.t + reach > times[-1]:
            return Reconstruction(out, np.array(turnings), mismatch)
        backward, _, _ = equation.outward(there, -1.0, meet)
        mismatch = max(mismatch, abs(float(backward(meet)[0] - last[0])))
        if not mismatch <= APART:
            out[times > here.t] = np.nan
            return Reconstruction(out, np.array(turnings), mismatch)
        _fill(out, times, meet, there.t - reach, lambda t, f=backward: f(t)[0])
        known, here = there.t - reach, there
        turnings.append(there.t)


class _Equation:
    """Q(z, t) = z'^2 of a body whose momenta and E~ are known at some times, and the motion that follows from it."""

    def __init__(
        self, system: System, b: Any, times: np.ndarray, momenta: list[np.ndarray], energy: np.ndarray, period: float
    ):
        from scipy.interpolate import make_interp_spline

        assert system.potential is not None
        assert system.theta_inertia is not None
        self.potential, self.inertia, self.b, self.period = system.potential, system.theta_inertia, b, period
        self.values = make_interp_spline(times, np.array([energy, *momenta]).T, k=7)
        self.rates = self.values.derivative()

    def square(self, z: Any, t: Any, step: Any = 0.0) -> Any:
        """Q(z, t) = z'^2; `step` is a complex step of time."""
        return self._square(z, (self.values(t) + step * self.rates(t) if step else self.values(t)).T)

    def _square(self, z: Any, given: Any) -> Any:
        return (1 - z) * (1 + z) * (given[0] - self.potential(z, *given[1:], self.b)) / self.inertia(z, self.b)

    def along_z(self, z: Any, t: Any) -> Any:
        """Q_z."""
        return self.square(z + 1j * COMPLEX_STEP, t).imag / COMPLEX_STEP

    def along_t(self, z: Any, t: Any) -> Any:
        """Q_t."""
        return self.square(z, t, 1j * COMPLEX_STEP).imag / COMPLEX_STEP

    def conserving(self, times: np.ndarray, z: float) -> Reconstruction:
        """The motion where nothing depends on time: Q_t = 0 says nothing of the turnings, and z'' = Q_z/2 needs no
        turnings, as it has no branch points. `mismatch` is that of z'^2 = Q, in the largest z'^2."""
        from scipy.integrate import solve_ivp

        def rates(t: float, y: np.ndarray) -> list[float]:
            return [y[1], self.along_z(y[0], start) / 2]

        def turning(t: float, y: np.ndarray) -> float:
            return float(y[1])

        start = float(times[0])
        solution = solve_ivp(
            rates, (start, float(times[-1])), [z, 0.0], "DOP853", times, events=turning, rtol=1e-12, atol=1e-14
        )
        square = solution.y[1] ** 2
        mismatch = float(np.abs(square - self.square(solution.y[0], start)).max() / max(square.max(), 1e-300))
        turnings = solution.t_events[0]
        return Reconstruction(solution.y[0], turnings[turnings > start + 1e-6 * self.period], mismatch)

    def motion(self, t: float, y: np.ndarray) -> np.ndarray:
        """The rates of z and z': z'' = Q_z/2 + Q_t/(2 z')."""
        # both slopes of Q from one evaluation: here the time of a reconstruction goes
        momenta, rates = self.values(t), self.rates(t)
        given = np.array([momenta, momenta + 1j * COMPLEX_STEP * rates]).T
        along_z, along_t = self._square(y[0] + WAYS, given).imag / COMPLEX_STEP
        return np.array([y[1], along_z / 2 + along_t / (2 * y[1])])

    def outward(self, start: "_Series", way: float, until: float) -> Any:
        """From the edge of a series, forward or backward, past the fastest point of the swing: the dense output, and
        time and state at its end."""
        from scipy.integrate import solve_ivp

        edge = start.t + way * REACH * self.period / 2
        peak = 0.0

        def past(t: float, y: np.ndarray) -> float:
            nonlocal peak
            peak = max(peak, y[1] ** 2)
            return y[1] ** 2 - MEET * peak

        past.terminal, past.direction = True, -1  # type: ignore[attr-defined]
        at_edge = [start(edge), start.speed(edge)]
        solution = solve_ivp(self.motion, (edge, until), at_edge, "DOP853", None, True, past, rtol=1e-11, atol=1e-13)
        return solution.sol, float(solution.t[-1]), solution.y[:, -1]


class _Series(NamedTuple):
    """z as a power series in the time since a turning, in units of its reach."""

    t: float
    reach: float
    coefficients: np.ndarray

    def __call__(self, t: Any) -> Any:
        return np.polynomial.polynomial.polyval((np.asarray(t) - self.t) / self.reach, self.coefficients)

    def speed(self, t: Any) -> Any:
        slope = np.polynomial.polynomial.polyder(self.coefficients)
        return np.polynomial.polynomial.polyval((np.asarray(t) - self.t) / self.reach, slope) / self.reach


def _series(equation: _Equation, t: float, z: float, reach: float, *, fixed: bool = False) -> _Series:
    """The smooth solution through the turning near (t, z): Newton on Q = Q_t = 0, then least squares on z'^2 = Q."""
    square, along_z, along_t = equation.square, equation.along_z, equation.along_t
    for _ in range(0 if fixed else 20):
        h = 1e-4 * reach
        jacobian = np.array(
            [
                [along_z(z, t), along_t(z, t)],
                [
                    (along_t(z + 1e-6, t) - along_t(z - 1e-6, t)) / 2e-6,
                    (along_t(z, t + h) - along_t(z, t - h)) / (2 * h),
                ],
            ]
        )
        step = np.linalg.solve(jacobian, [square(z, t), along_t(z, t)])
        z, t = float(z - step[0]), float(t - np.clip(step[1], -reach, reach))
        if abs(step[0]) <= 4 * np.spacing(1.0) and abs(step[1]) <= 4 * np.spacing(abs(t) + reach):
            break
    x = np.cos(np.linspace(0, np.pi, 4 * ORDER)) if not fixed else (1 - np.cos(np.linspace(0, np.pi, 4 * ORDER))) / 2
    powers = np.vander(x, ORDER + 1, increasing=True)
    slopes = np.arange(ORDER + 1) * np.vander(x, ORDER + 1, increasing=True)[:, [0, *range(ORDER)]] / reach
    c = np.zeros(ORDER + 1)
    c[:3] = z, 0.0, along_z(z, t) / 4 * reach**2
    free = [0, *range(2, ORDER + 1)]
    for _ in range(12):
        speed, place = slopes @ c, powers @ c
        left = speed**2 - square(place, t + reach * x)
        change = 2 * speed[:, None] * slopes - along_z(place, t + reach * x)[:, None] * powers
        c[free] -= np.linalg.lstsq(change[:, free], left, rcond=None)[0]
    return _Series(t, reach, c)


def _fill(out: np.ndarray, times: np.ndarray, first: float, last: float, z: Any) -> None:
    inside = (times >= first) & (times <= last)
    if inside.any():
        out[inside] = z(times[inside])
