"""The main equation as an equation of motion: from D(t) and E~(t) of a run back to theta(t).

[T 4.40, 5.26]

The equation of first order, z'^2 = Q(z, t) with z = cos(theta), has a branch point at every turning
angle. The motion is smooth there: on a piece of a nutation z(t) is a polynomial, found by least
squares from z'^2 = Q at many times, and from z and z' where the piece before it ends. Where
neighbours leave the motion behind a turning, the turning itself determines it; where they approach
it, the piece before does.

The polynomial is sought near a solution of z'' = Q_z/2 + r, where r is Q_t/(2 z') away from
turnings and keeps its value through them.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import Chebyshev
from numpy.polynomial.chebyshev import chebder, chebfit, chebval, chebvander

from ..system import System


COMPLEX_STEP = 1e-30
# of the polynomial of a piece
ORDER = 32
# longest piece, by the period of nutation
LONGEST = 0.4
# shortest piece, by the period of nutation
SHORTEST = 1 / 64
# rate at which r follows Q_t/(2 z') where z' is largest, per period
FOLLOWS = 100.0
# most mismatch of a piece, a good one has 1e-9 and less, and most standard error of z at its end
APART = 1e-7
# turnings nearer to one another than this part of a period are one
SAME = 1e-5
ITERATIONS = 20

NODES = np.cos(np.pi * (np.arange(3 * ORDER) + 0.5) / (3 * ORDER))
PLACES = np.append(NODES, -1.0)
VALUES = chebvander(PLACES, ORDER)
SLOPES = chebval(PLACES, chebder(np.eye(ORDER + 1))).T
"""From the coefficients of a polynomial on [-1, 1] to its values and slopes at the nodes, and at
the beginning."""


class Reconstruction(NamedTuple):
    """A reconstructed motion.

    z = cos(theta) at the given times (NaN after the last piece), times of the turnings, the worst
    mismatch of a piece, and whether it ends early: no polynomial is the motion on the next piece,
    or errors of the pieces before have grown beyond `APART`.
    """

    z: np.ndarray
    turnings: np.ndarray
    mismatch: float
    early: bool


@np.errstate(all="ignore")  # a piece that is too long may leave the numbers
def reconstruct(
    system: System,
    b: Any,
    times: np.ndarray,
    momenta: list[np.ndarray],
    energy: np.ndarray,
    z: float,
    period: float,
) -> Reconstruction:
    """Return z(t) = cos(theta) from E~(t) = inertia(z) theta'^2 + V(z, *momenta(t)).

    [T 4.40, 5.26]

    Parameters
    ----------
    system
        A system with `potential` and `theta_inertia`.
    b
        Its body, SI.
    times
        Times of the rows [s], ascending, (n,), the first at a turning angle.
    momenta
        The momenta that the potential takes, at the times, each (n,), SI, in the order of
        `System.momenta`.
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
    equation = Equation(system, b, times, momenta, energy)
    out = np.full(len(times), np.nan)
    turnings = [float(times[0])]  # with the start, which the results leave out
    mismatch = 0.0
    out[0] = z
    t = float(times[0])
    end = float(times[-1])
    length = LONGEST * period
    start = np.array([z, 0.0, 0.0])
    # of the order of z''/(2 pi/period), with z'' = Q_z/2; pieces replace it by their own
    fastest = abs(equation.slope(z, t)) * period / 20
    spread = np.zeros((2, 2))  # of z and z' at the start of a piece: the covariance of their errors
    while t < end:
        piece, apart, ways = equation.piece(t, min(t + length, end), start, fastest, period)
        if not apart <= APART:  # NaN too
            length /= 2
            if length < SHORTEST * period:
                return Reconstruction(out, np.array(turnings[1:]), apart, True)
            continue
        mismatch = max(mismatch, apart)
        speed = piece.deriv()
        # the next piece begins where the motion is fastest: from there errors fade to the turning
        moments, speeds = speed.linspace(101)
        last = float(piece.domain[1])
        if last < end:
            last = float(moments[50 + np.argmax(np.abs(speeds[50:]))])
        half = (piece.domain[1] - t) / 2
        x = (last - t) / half - 1
        moves = np.array([chebval(x, ways), chebval(x, chebder(ways)) / half])
        nodes = moves[:, :-2]
        ends = moves[:, -2:]
        spread = apart**2 * nodes @ nodes.T + ends @ spread @ ends.T
        if not spread[0, 0] <= APART**2:
            return Reconstruction(out, np.array(turnings[1:]), float(spread[0, 0] ** 0.5), True)
        inside = (times >= t) & (times <= last)
        out[inside] = piece(times[inside])
        roots = speed.roots()
        for turning in np.sort(roots[np.abs(roots.imag) < SAME * period].real):
            # not the one before again; in the piece or, by rounding, just before it
            if max(turnings[-1], t - 2 * SAME * period) + SAME * period < turning <= last:
                turnings.append(float(turning))
        if len(turnings) > 2:
            period = 2 * (turnings[-1] - turnings[-2])
        fastest = max(fastest / 2, float(np.abs(speeds).max()))
        z = float(piece(last))
        t = last
        start = np.array([z, speed(t), speed.deriv()(t) - equation.slope(z, t) / 2])
        length = min(2 * length, LONGEST * period)
    return Reconstruction(out, np.array(turnings[1:]), mismatch, False)


class Equation:
    """Q(z, t) = z'^2 of a body whose momenta and E~ are known at some times, and its motion."""

    def __init__(
        self,
        system: System,
        b: Any,
        times: np.ndarray,
        momenta: list[np.ndarray],
        energy: np.ndarray,
    ):
        """Interpolate energy and momenta, which change slowly, by splines of degree 7 in time.

        The arguments are those of `reconstruct`; the energy is the first column, as `square` takes
        it.
        """
        from scipy.interpolate import make_interp_spline

        self.system = system
        self.b = b
        self.values: Any = make_interp_spline(times, np.array([energy, *momenta]).T, k=7)

    def square(self, z: Any, t: Any, step: complex = 0.0) -> Any:
        """Return Q(z, t) = z'^2 [1/s^2] for numbers or arrays z and t [s] of one shape.

        `step` is added to t to first order: an imaginary one gives the derivative by t. All that
        is called must take complex numbers.
        """
        energy, *momenta = (self.values(t) + step * self.values(t, 1)).T
        potential = self.system.potential
        inertia = self.system.theta_inertia
        assert potential is not None
        assert inertia is not None
        return (1 - z) * (1 + z) * (energy - potential(z, *momenta, self.b)) / inertia(z, self.b)

    def slope(self, z: Any, t: Any) -> Any:
        """Return Q_z [1/s^2], the derivative of Q by z, by a complex step."""
        return self.square(z + 1j * COMPLEX_STEP, t).imag / COMPLEX_STEP

    def drift(self, z: Any, t: Any) -> Any:
        """Return Q_t [1/s^3], the derivative of Q by t, by a complex step."""
        return self.square(z, t, 1j * COMPLEX_STEP).imag / COMPLEX_STEP

    def piece(
        self, first: float, last: float, start: np.ndarray, fastest: float, period: float
    ) -> tuple[Chebyshev, float, np.ndarray]:
        """Return the motion z(t) between two times, its mismatch, and how errors move it.

        Parameters
        ----------
        first, last
            The times [s].
        start
            z, z' and r at the first.
        fastest
            About the largest |z'| of a swing.
        period
            About the period of nutation [s].

        Returns
        -------
        Chebyshev
        float
            The worst error of z'^2 = Q, relative to the largest z'^2, or of z at the first time.
        ndarray
            Change of its coefficients by errors of z'^2 at the nodes, relative to the largest, and
            of z and z' at the first time.
        """
        from scipy.integrate import solve_ivp

        follows = FOLLOWS / (period * fastest**2)

        def rates(t: float, y: np.ndarray) -> list[float]:
            """Return dy/dt at the time t [s] for scipy, of y = (z, z', r): z'' = Q_z/2 + r.

            r follows Q_t/(2 z') at the rate `follows` z'^2, and so keeps its value at turnings.
            """
            z, speed, r = y
            rest = self.drift(z, t) / 2 - r * speed
            return [speed, self.slope(z, t) / 2 + r, follows * speed * rest]

        half = (last - first) / 2
        times = first + half * (NODES + 1)
        # NODES descend, and scipy needs ascending times
        guess = solve_ivp(rates, (first, last), start, "DOP853", times[::-1], rtol=1e-8, atol=1e-10)
        if len(guess.t) < len(times):
            return Chebyshev([0.0], [first, last]), np.inf, np.empty(0)
        c = chebfit(NODES, guess.y[0, ::-1], ORDER)
        for _ in range(ITERATIONS):
            z = VALUES @ c
            speed = SLOPES @ c / half
            off = (z[-1] - start[0]) * fastest / half, (speed[-1] - start[1]) * fastest
            left = np.append(speed[:-1] ** 2 - self.square(z[:-1], times), off)
            across = self.slope(z[:-1], times)[:, None] * VALUES[:-1]
            along = 2 * speed[:-1, None] * SLOPES[:-1] / half - across
            rows = [along, VALUES[-1:] * fastest / half, SLOPES[-1:] * fastest / half]
            change = np.linalg.lstsq(np.vstack(rows), left, rcond=None)[0]
            c = c - change
            if np.abs(change).max() < 1e-13:
                break
        error = np.abs(left[:-2]).max() / fastest**2
        scales = np.append(np.full(len(NODES), fastest**2), [fastest / half, fastest])
        ways = np.linalg.pinv(np.vstack(rows)) * scales
        return Chebyshev(c, [first, last]), float(max(error, abs(z[-1] - start[0]))), ways
