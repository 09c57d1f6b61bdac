"""The main equation as an equation of motion: from D(t) and E~(t) of a run back to theta(t).

[T 4.40, 5.26]

The equation of first order, z'^2 = Q(z, t) with z = cos(theta), has a branch point at every turning
angle. There Q and Q_t vanish together, which fixes time and angle of the turning, and 2 a^2 - Q_z a
= Q_tt, which leaves two values of the curvature a = z''. Neighbours leave the solution of curvature
a as |t|^p, p = Q_z/(2 a), 1 without friction:

- p <= 1: only one curvature has the sign that a turning needs. The smooth solution is a power
  series; from it the equation of second order, z'' = Q_z/2 + Q_t/(2 z'), is integrated outwards,
  forward and backward in time.
- p > 1: both have that sign. They cross at p = 2, in the canonical inversion at 4.41 s. Which of
  them the motion has, the piece before it says: towards such a turning errors fade.

Where a swing slows down without turning, the integration continues, if it can.
Where nothing depends on time, Q_t = 0 for every angle, and the equation of second order is all that
is needed.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import Polynomial

from ..system import System


COMPLEX_STEP = 1e-30
# of z, without one and with one of t
STEPS = np.array([1j * COMPLEX_STEP, 0.0])
# order of the power series at a turning
ORDER = 10
# share of the time between turnings in which the series is used
REACH = 0.06
# reaches before a turning with p > 1, from which on the piece before it determines its curvature
KNOWN = 3.0
# most difference of z where two pieces meet; a good one has 1e-9 and less
APART = 1e-6
# of the largest speed of a swing: below these a turning is sought
SLOW = 0.5, 0.1
# p below which errors grow too fast towards a turning to wait for the second speed
STEEP = -0.5
# evaluations in a piece, thirty times those of a swing: beyond, z' touches 0 without turning
CALLS = 40_000
# relative variation below which momenta and energy are constants of the motion
CONSTANT = 1e-11


class Reconstruction(NamedTuple):
    """A reconstructed motion.

    z = cos(theta) at the given times (NaN after the last swing that ends in a turning), times of
    the turnings, the worst mismatch of z where pieces meet, and whether it ends early: pieces do
    not meet, or no turning follows.
    """

    z: np.ndarray
    turnings: np.ndarray
    mismatch: float
    early: bool


def reconstruct(
    system: System,
    b: Any,
    times: np.ndarray,
    momenta: list[np.ndarray],
    energy: np.ndarray,
    z: float,
    period: float,
) -> Reconstruction:
    """Return theta(t) from E~(t) = inertia(z) theta'^2 + V(z, *momenta(t)). [T 4.40, 5.26]

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
    out, mismatch = np.full(len(times), np.nan), 0.0
    turnings: list[Any] = []
    reach, end = REACH * period / 2, float(times[-1])
    here = _series(equation, z, float(times[0]), reach, None)
    _fill(out, times, here.t, here.t + reach, here)
    while True:
        edge = here.t + here.reach
        try:
            forward, there = equation.swing(here, end)
            early = there is None and forward.end < end
            if there is None or there.t + reach > end:
                # from p = 2 on errors grow too fast without a later turning
                if not early and here.power < 2:
                    _fill(out, times, edge, forward.end, forward)
                return Reconstruction(out, np.array(turnings), mismatch, early)
            # if p > 1, errors of earlier pieces fade towards the turning
            last = meet = there.t - reach
            comes: _Series | _Piece = there
            goes = forward
            if not there.node:
                meet, goes = (
                    edge if here.node else (here.t + there.t) / 2,
                    _Piece(equation, there, -1.0),
                )
                comes = here if here.node else forward
                goes.go(meet)
                _fill(out, times, meet, last, goes)
        except _Lost:
            return Reconstruction(out, np.array(turnings), mismatch, True)
        mismatch = max(mismatch, abs(float(comes(meet) - goes(meet))))
        if not mismatch <= APART:
            out[times > here.t] = np.nan
            return Reconstruction(out, np.array(turnings), mismatch, True)
        _fill(out, times, edge, meet, forward)
        _fill(out, times, last, there.t + reach, there)
        turnings.append(there.t)
        here = there


class _Lost(Exception):
    """A piece does not come to its end."""


class _Equation:
    """Q(z, t) = z'^2 of a body whose momenta and E~ are known at some times, and its motion."""

    def __init__(
        self,
        system: System,
        b: Any,
        times: np.ndarray,
        momenta: list[np.ndarray],
        energy: np.ndarray,
        period: float,
    ):
        from scipy.interpolate import make_interp_spline

        assert system.potential is not None
        assert system.theta_inertia is not None
        self.potential, self.inertia, self.b, self.period = (
            system.potential,
            system.theta_inertia,
            b,
            period,
        )
        self.calls = 0  # of `motion`, in this piece
        self.values = make_interp_spline(times, np.array([energy, *momenta]).T, k=7)
        self.rates = self.values.derivative()

    def square(self, z: Any, t: Any) -> Any:
        """Return Q(z, t) = z'^2."""
        return self._square(z, self.values(t).T)

    def _square(self, z: Any, given: Any) -> Any:
        return (
            (1 - z)
            * (1 + z)
            * (given[0] - self.potential(z, *given[1:], self.b))
            / self.inertia(z, self.b)
        )

    def slopes(self, z: Any, t: Any) -> Any:
        """Return Q_z and Q_t, from one evaluation with a complex step in each direction."""
        values, rates = self.values(t).T, self.rates(t).T
        given = np.stack([values, values + 1j * COMPLEX_STEP * rates], -1)
        square = self._square(np.asarray(z)[..., None] + STEPS, given)
        return np.moveaxis(square.imag / COMPLEX_STEP, -1, 0)

    def conserving(self, times: np.ndarray, z: float) -> Reconstruction:
        """Return the motion where nothing depends on time.

        Q_t = 0 does not determine the turnings, and z'' = Q_z/2 does not need them, because it has
        no branch points. `mismatch` is that of z'^2 = Q, relative to the largest z'^2.
        """
        from scipy.integrate import solve_ivp

        def rates(t: float, y: np.ndarray) -> list[float]:
            return [y[1], self.slopes(y[0], start)[0] / 2]

        def turning(t: float, y: np.ndarray) -> float:
            return float(y[1])

        start = float(times[0])
        solution = solve_ivp(
            rates,
            (start, float(times[-1])),
            [z, 0.0],
            "DOP853",
            times,
            events=turning,
            rtol=1e-12,
            atol=1e-14,
        )
        square = solution.y[1] ** 2
        mismatch = float(
            np.abs(square - self.square(solution.y[0], start)).max() / max(square.max(), 1e-300)
        )
        turnings = solution.t_events[0]
        return Reconstruction(
            solution.y[0], turnings[turnings > start + 1e-6 * self.period], mismatch, False
        )

    def motion(self, t: float, y: np.ndarray) -> np.ndarray:
        """Return the rates of z and z': z'' = Q_z/2 + Q_t/(2 z')."""
        self.calls += 1
        if self.calls > CALLS:
            raise _Lost
        along_z, along_t = self.slopes(y[0], t)
        return np.array([y[1], along_z / 2 + along_t / (2 * y[1])])

    def swing(self, here: "_Series", end: float) -> "tuple[_Piece, _Series | None]":
        """Return the motion from one turning to the next, and its series.

        The motion goes up to the edge of the next turning; without one its series is None.
        """
        piece, peak, share = _Piece(self, here, 1.0), 0.0, 0.0
        way = np.sign(piece.state[1])

        def speed(y: np.ndarray) -> float:
            nonlocal peak
            peak = max(peak, way * y[1])
            return way * y[1] - share * peak

        slow, fast = _event(speed, -1), _event(speed, 1)
        back = _event(lambda y: way * y[1], -1)
        while True:
            for share in SLOW:
                if piece.go(end, slow) >= end:
                    return piece, None
                goal = self.turning(piece, here.reach)
                # near p = 0 Q and Q_t vanish at two points, and only close to them it shows which
                # is the turning
                if goal is not None and (share < SLOW[0] or goal[2] < STEEP):
                    piece.go(min(end, goal[1] - here.reach))
                    return piece, _series(self, *goal[:2], here.reach, piece)
            share *= 1.5  # it slows down, and does not turn
            piece.go(end, (fast, back))
            if way * piece.state[1] <= 0:
                return piece, None
            peak = way * piece.state[1]

    def turning(self, piece: "_Piece", reach: float) -> tuple[float, float, float] | None:
        """Return angle, time and power p where Q = Q_t = 0 soon after the end of a piece.

        Return None if there is no such point.
        """
        start, (z, speed) = piece.end, piece.state
        # about the time that a harmonic swing would still need
        left = abs(speed / self.motion(start, piece.state)[1])
        z, t, h, far = z + speed * left / 2, start + left, 1e-4 * reach, 4 * abs(speed) * left
        first = z
        for _ in range(20):
            across = self.slopes(z + 1e-6, t)[1] - self.slopes(z - 1e-6, t)[1]
            along = self.slopes(z, t + h)[1] - self.slopes(z, t - h)[1]
            jacobian = np.array([self.slopes(z, t), [across / 2e-6, along / (2 * h)]])
            if not (np.isfinite(jacobian).all() and np.linalg.det(jacobian)):
                return None
            step = np.linalg.solve(jacobian, [self.square(z, t), jacobian[0, 1]])
            z, t = float(z - step[0]), float(t - np.clip(step[1], -reach, reach))
            if abs(step[0]) <= 4 * np.spacing(1.0) and abs(step[1]) <= 4 * np.spacing(
                abs(t) + reach
            ):
                break
        converged = abs(step[0]) <= 1e-10 and abs(step[1]) <= 1e-6 * reach  # noise
        if not (converged and start < t < start + 4 * left and abs(z - first) < far):
            return None
        (along_z, _), (_, q_tt) = jacobian
        return z, t, along_z / (2 * _curvature(along_z, q_tt, speed))


def _curvature(along_z: float, q_tt: float, way: float) -> float:
    """Return a = z'' of a turning, of 2 a^2 - Q_z a = Q_tt; `way` is the sign of z' before it."""
    return (along_z - np.copysign(np.sqrt(max(along_z**2 + 8 * q_tt, 0.0)), way)) / 4


def _event(function: Callable[[np.ndarray], float], direction: int) -> Any:
    """Return an event of `solve_ivp` that ends the integration."""

    def event(t: float, y: np.ndarray) -> float:
        return function(y)

    event.terminal, event.direction = True, direction  # type: ignore[attr-defined]
    return event


class _Piece:
    """The motion from the edge of a series on, forward or backward in time: z at any time of it."""

    def __init__(self, equation: _Equation, start: "_Series", way: float):
        self.equation, self.end = equation, start.t + way * start.reach
        equation.calls = 0
        self.start, self.state = self.end, np.array([start(self.end), start.speed(self.end)])
        self.parts: list[tuple[float, Any]] = []

    def go(self, until: float, event: Any = None) -> float:
        """Integrate up to a time or an event; the time that is reached."""
        from scipy.integrate import solve_ivp

        if self.end != until:
            span = self.end, until
            solution = solve_ivp(
                self.equation.motion,
                span,
                self.state,
                "DOP853",
                None,
                True,
                event,
                rtol=1e-11,
                atol=1e-13,
            )
            self.end, self.state = float(solution.t[-1]), solution.y[:, -1]
            self.parts.append((self.end, solution.sol))
        return self.end

    def __call__(self, t: Any) -> np.ndarray:
        z, which = np.empty(np.shape(t)), np.searchsorted([end for end, _ in self.parts[:-1]], t)
        for k, (_, part) in enumerate(self.parts):
            if (which == k).any():
                z[which == k] = part(np.asarray(t)[which == k])[0]
        return z


class _Series(NamedTuple):
    """z as a power series in (t - turning)/reach; neighbours leave it as |t|^power."""

    t: float
    reach: float
    curve: Polynomial
    power: float
    node: bool

    def __call__(self, t: Any) -> Any:
        return self.curve((np.asarray(t) - self.t) / self.reach)

    def speed(self, t: Any) -> Any:
        return self.curve.deriv()((np.asarray(t) - self.t) / self.reach) / self.reach


def _series(
    equation: _Equation, z: float, t: float, reach: float, before: _Piece | None
) -> _Series:
    """Return the smooth solution through a turning, by least squares on z'^2 = Q.

    `before` is the piece that leads to it, None at the first one, where time begins.
    """
    along_z, h = equation.slopes(z, t)[0], 1e-4 * reach
    x = np.cos(np.linspace(0, np.pi, 4 * ORDER))
    if before is None:
        x = (1 - x) / 2
    powers, slopes = _powers(x), np.arange(ORDER + 1) * _powers(x)[:, [0, *range(ORDER)]] / reach
    c, free, node = np.zeros(ORDER + 1), [0, *range(2, ORDER + 1)], False
    c[:3] = z, 0.0, along_z / 4 * reach**2
    if before is not None:
        q_tt = (equation.slopes(z, t + h)[1] - equation.slopes(z, t - h)[1]) / (2 * h)
        node = q_tt < 0 < -along_z * before.state[1]
        c[2] = _curvature(along_z, q_tt, before.state[1]) / 2 * reach**2
        if node:
            y = np.linspace(-min(KNOWN, (t - before.start) / reach), -1, 2 * ORDER)
            few = [2, 3, 4, 5]  # enough to say which of both curvatures it is
            c[few] = np.linalg.lstsq(_powers(y)[:, few], before(t + reach * y) - z, rcond=None)[0]
    for _ in range(12):
        speed, place = slopes @ c, powers @ c
        left = speed**2 - equation.square(place, t + reach * x)
        along = equation.slopes(place, t + reach * x)[0]
        change = 2 * speed[:, None] * slopes - along[:, None] * powers
        c[free] -= np.linalg.lstsq(change[:, free], left, rcond=None)[0]
    return _Series(t, reach, Polynomial(c), float(along_z * reach**2 / (4 * c[2])), bool(node))


def _powers(x: np.ndarray) -> np.ndarray:
    return np.vander(x, ORDER + 1, increasing=True)


def _fill(out: np.ndarray, times: np.ndarray, first: float, last: float, z: Any) -> None:
    inside = (times >= first) & (times <= last)
    if inside.any():
        out[inside] = z(times[inside])
