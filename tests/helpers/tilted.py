"""A rigid body in air on a plane that is level or tilted, vibrates or turns, by Newton and Euler in
a frame at rest with gravity along -z: the oracle of runs.

No formula of the package is used: the body is a rotation matrix, a momentum and an ellipsoid (a
sphere, or a tip) or a rim, the plane has a normal, and the force of the contact is solved for
numerically.
"""

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from limits import assert_below
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation


SOON = 1e-5
"""Time [s] after a start in which no event is looked for."""

TIGHT = {"method": "DOP853", "rtol": 2.3e-14, "atol": 1e-16}


@cache
def turned_about(*vector: float) -> np.ndarray:
    """Return the matrix of a rotation."""
    return Rotation.from_rotvec(vector).as_matrix()


@cache
def plane_of(tilt: float, azimuth: float) -> np.ndarray:
    """Return the axes of a plane as columns; the last is its normal."""
    return turned_about(-tilt * np.sin(azimuth), tilt * np.cos(azimuth), 0.0)


@cache
def quadric(a: float, b: float, c: float, turn: float) -> np.ndarray:
    """Return the matrix of an ellipsoid whose axes are turned about axis 3."""
    twist = turned_about(0.0, 0.0, turn)
    return twist @ np.diag([a * a, b * b, c * c]) @ twist.T


def cross(a: Any, b: Any) -> np.ndarray:
    """Return the product of vectors, or of a vector and the columns of a matrix."""
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


class Body(NamedTuple):
    """A body with its surroundings, SI."""

    m: float
    inertia: Any  # principal moments
    centre: Any  # of its ellipsoid, body axes
    half: Any  # axes of its ellipsoid; (0, 0, 0): a tip, or a rim
    g: float
    ring: float = 0.0  # radii of the rim
    tube: float = 0.0
    tilt: float = 0.0
    azimuth: float = 0.0
    c1: float = 0.0
    c2: float = 0.0
    turn: float = 0.0  # of the ellipsoid about axis 3
    amplitude: float = 0.0
    frequency: float = 0.0
    phase: float = 0.0
    omega: float = 0.0  # of the plane about x, y
    x: float = 0.0
    y: float = 0.0

    @property
    def plane(self) -> np.ndarray:
        """The axes of the plane as columns; the last is its normal."""
        return plane_of(self.tilt, self.azimuth)

    def height(self, t: float) -> tuple[float, float, float]:
        """Height, velocity and acceleration of the plane along its normal."""
        rate = 2 * np.pi * self.frequency
        now = rate * t + self.phase
        a = self.amplitude
        return -a * np.cos(now), a * rate * np.sin(now), a * rate**2 * np.cos(now)

    def turned(self, t: float) -> np.ndarray:
        """The axes of the plane at this time as columns."""
        return self.plane @ turned_about(0.0, 0.0, self.omega * t)

    def reached(self, n: np.ndarray) -> np.ndarray:
        """The lowest point, where n is the normal of the plane in body axes."""
        if self.ring:
            across = n * [1, 1, 0]
            return self.centre - self.tube * n - self.ring * across / np.sqrt(across @ across)
        reach = quadric(*self.half, self.turn) @ n
        return self.centre - reach / (np.sqrt(n @ reach) or 1.0)

    @property
    def centre_of_table(self) -> np.ndarray:
        """The axis of turning."""
        return self.plane @ [self.x, self.y, 0.0]


def body_of(top: Any, air: Any = (), plane: Any = ()) -> Body:
    """Return the body of a record, with the tables of its surroundings."""
    centre, half, more = [0, 0, getattr(top, "c", 0.0)], np.zeros(3), {}
    if hasattr(top, "l"):
        centre = [0, 0, -top.l]
    elif hasattr(top, "R"):
        centre, half = [0, 0, top.alpha * top.R], np.full(3, top.R)
    elif hasattr(top, "ring"):
        more = {"ring": top.ring, "tube": top.tube}
    elif hasattr(top, "delta"):
        centre, half = [top.x, top.y, top.h], np.array([top.a, top.b, top.c])
        more = {"turn": top.delta}
    else:
        half = np.array([top.b, top.b, top.a])
    inertia = top.I1, getattr(top, "I2", top.I1), top.I3
    return Body(top.m, inertia, centre, half, top.g, **more, **dict(air), **dict(plane))


def split(s: np.ndarray) -> tuple[np.ndarray, ...]:
    """Place, velocity, momentum, axes."""
    return s[:3], s[3:6], s[6:9], s[9:18].reshape(3, 3)


class Point(NamedTuple):
    """The lowest point of a body, its velocity from the plane, and accelerations by forces there.

    The last two of `rates` are that from the plane, and that of the angular velocity.
    """

    arm: np.ndarray
    omega: np.ndarray
    gap: float
    v: np.ndarray
    rates: Callable  # rates(F, T=0) -> v', L', v_A', omega'


def lowest(s: np.ndarray, b: Body) -> Point:
    """Return the lowest point of a body in a state."""
    r, v, L, Q = split(s)
    n = b.plane[:, 2]
    inverse = (Q / b.inertia) @ Q.T
    w = inverse @ L
    nb, nb_dot = Q.T @ n, Q.T @ cross(n, w)
    p, p_dot = b.reached(nb), np.imag(b.reached(nb + 1e-30j * nb_dot)) / 1e-30
    a = Q @ p
    a_dot = cross(w, a) + Q @ p_dot
    height, speed, lift = b.height(s[18])
    at = r + a - b.centre_of_table
    carries = speed * n + b.omega * cross(n, at)
    carries_dot = lift * n + b.omega * cross(n, v + a_dot)
    air = -(b.c1 + b.c2 * np.linalg.norm(w)) * w

    def rates(F: Any, T: Any = 0.0) -> tuple[np.ndarray, ...]:
        L_dot = cross(a, F) + air + T
        w_dot = inverse @ (L_dot - cross(w, L))
        v_dot = np.asarray(F) / b.m - [0, 0, b.g]
        G = v_dot + cross(w_dot, a) + cross(w, a_dot)
        return v_dot, L_dot, G - carries_dot, w_dot

    return Point(a, w, n @ (r + a) - height, v + cross(w, a) - carries, rates)


def no_torque(omega: np.ndarray) -> np.ndarray:
    """Return the torque of a contact of a point, per normal force."""
    return 0 * omega


def sliding(k: Callable, torque: Callable = no_torque) -> Callable:
    """Return force and torque of friction -k(|v|) N v, and of a torque per normal force."""

    def force(point: Point, n: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        slip = point.v - n * (n @ point.v)
        push, twist = n - k(np.linalg.norm(slip)) * slip, torque(point.omega)
        free = n @ point.rates(0 * n)[2]
        N = -free / (n @ point.rates(push, twist)[2] - free)
        return N * push, N * twist

    return force


def resting(torque: Callable = no_torque, turns: bool = True) -> Callable:
    """Return force and torque that keep a contact at rest, and its turning about the vertical if it
    does not turn.
    """

    def force(point: Point, n: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        def given(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            return x[:3], (n @ x[:3]) * torque(point.omega) + x[3] * n

        def gained(x: np.ndarray) -> np.ndarray:
            *_, slip, turning = point.rates(*given(x))
            return np.append(slip, n @ turning)[:kept]

        kept = 3 if turns else 4
        free, one = gained(np.zeros(4)), np.eye(4)[:kept]
        by_part = np.array([gained(x) - free for x in one]).T
        return given(np.linalg.solve(by_part, -free) @ one)

    return force


rolling = resting()


def flying(point: Point, n: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return no force and no torque."""
    return np.zeros(3), np.zeros(3)


def motion(force: Callable, b: Body) -> Callable:
    """Return the right-hand side of the equations under force and torque (point, normal)."""

    def rates(t: float, s: np.ndarray) -> np.ndarray:
        point = lowest(s, b)
        v_dot, L_dot, *_ = point.rates(*force(point, b.plane[:, 2]))
        _, v, _, Q = split(s)
        return np.concatenate([v, v_dot, L_dot, cross(point.omega, Q).ravel(), [1.0]])

    return rates


def follow(force: Callable, b: Body, s: np.ndarray, until: float, event: Any = None) -> tuple:
    """Return the time and the state at the end, or at an event(s, b) that falls through zero."""
    events = None
    if event is not None:
        events = lambda t, s: event(s, b) if t > SOON else 1.0  # noqa: E731
        events.terminal, events.direction = True, -1
    found = solve_ivp(motion(force, b), (0, until), s, events=events, **TIGHT)
    return found.t[-1], found.y[:, -1]


def struck(s: np.ndarray, b: Body, k: Callable, e_n: float) -> np.ndarray:
    """Return the state after an impact of Newton's restitution, with friction -k(|v|) v per N."""
    n = b.plane[:, 2]
    rises = n @ lowest(s, b).v

    def rates(p: float, s: np.ndarray) -> np.ndarray:
        point = lowest(s, b)
        slip = point.v - n * (n @ point.v)
        push = n - k(np.linalg.norm(slip)) * slip
        return np.concatenate([0 * n, push / b.m, cross(point.arm, push), np.zeros(10)])

    def ends(p: float, s: np.ndarray) -> float:
        return n @ lowest(s, b).v + e_n * rises

    ends.terminal = True
    found = solve_ivp(rates, (0, 10 * b.m * abs(rises)), s, events=ends, **TIGHT)
    return found.y_events[0][0]


def bounced(b: Body, s: np.ndarray, k: Callable, e_n: float, until: float) -> tuple:
    """Return the times of all landings of a body in the air, and its state at the end."""
    landings: list[float] = []
    now = 0.0
    while True:
        lasts, s = follow(flying, b, s, until - now, lambda s, b: lowest(s, b).gap)
        now += lasts
        if now >= until:
            return landings, s
        landings.append(now)
        s = struck(s, b, k, e_n)


def sticking(b: Body, s: np.ndarray, mu: float, until: float) -> tuple:
    """Return the time at which Coulomb friction stops a slide, and the state at the end.

    Its last step is of explicit form.
    """
    slides = sliding(lambda v: mu / v)
    stops, s = follow(slides, b, s, until, lambda s, b: np.linalg.norm(lowest(s, b).v) - 1e-9)
    point = lowest(s, b)
    last = -(point.v @ point.v) / (point.v @ point.rates(*slides(point, b.plane[:, 2]))[2])
    s = s + last * motion(slides, b)(0.0, s)
    return stops + last, follow(rolling, b, s, until - stops - last)[1]


def assert_motion(row: Any, b: Body, s: np.ndarray, bound: float) -> None:
    """Check that a row is a state but for differences below a bound: of its place [m], velocity
    [m/s], angular momentum, relative, and axes.
    """
    names = "place [m]", "velocity [m/s]", "angular momentum", "axes of the body"
    pairs = zip(names, split(state_of(row, b)), split(s), strict=True)
    found = {name: np.abs(x - y).max() for name, x, y in pairs}
    found["angular momentum"] /= np.abs(s[6:9]).max()
    assert_below(bound, found, "difference from the motion of Newton and Euler")


def assert_moves(rows: Any, b: Body, force: Callable, bound: float) -> None:
    """Check that the last row follows from the first one under a force, as `assert_motion` does."""
    first, last = rows.isel(time=0), rows.isel(time=-1)
    _, end = follow(force, b, state_of(first, b), float(last.time - first.time))
    assert_motion(last, b, end, bound)


def must_pull(row: Any, b: Body, force: Callable) -> bool:
    """Return whether the plane would have to pull a body in the state of a row to keep it."""
    n = b.plane[:, 2]
    return bool(n @ force(lowest(state_of(row, b), b), n)[0] < 0)


def state_of(row: Any, b: Body) -> np.ndarray:
    """Return the state of a row: place, orientation, L and slip are those of the plane."""
    t = float(row.time)
    P = b.turned(t)
    n = P[:, 2]
    w, x, y, z = row.orientation.values
    Q = P @ Rotation.from_quat([x, y, z, w]).as_matrix()
    inertia = Q @ np.diag(b.inertia) @ Q.T
    L = P @ row.L.values + b.omega * inertia @ n
    centre = b.centre_of_table
    r = centre + P @ [float(row.x) - b.x, float(row.y) - b.y, 0.0]
    s = np.concatenate([r, np.zeros(3), L, Q.ravel(), [t]])
    e = Q[:, 2] - n * (n @ Q[:, 2])
    e = e / np.linalg.norm(e)
    slip = np.zeros(3)
    if "nu_x" in row:
        slip = float(row.nu_x) * e + float(row.nu_y) * cross(n, e)
    rise = float(row.nu_z) if "nu_z" in row else 0.0
    gap = float(row.gap) if "gap" in row else 0.0
    s[:3] += n * (gap - lowest(s, b).gap)
    s[3:6] = slip + rise * n - lowest(s, b).v
    return s
