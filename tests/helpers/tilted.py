"""A rigid body in air on a plane that is tilted, vibrates or turns, by Newton and Euler in a frame
at rest with gravity along -z.

No formula of the package is used: the body is a rotation matrix, a momentum and an ellipsoid (a
sphere, or a tip), the plane has a normal, and the force of the contact is solved for numerically.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation


SOON = 1e-5
"""Time [s] after a start in which no event is looked for."""

TIGHT = {"method": "DOP853", "rtol": 2.3e-14, "atol": 1e-16}


class Body(NamedTuple):
    """A body with its surroundings, SI."""

    m: float
    inertia: Any  # principal moments
    centre: Any  # of its ellipsoid, body axes
    half: Any  # axes of its ellipsoid; (0, 0, 0): a tip
    g: float
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
        across = np.array([-np.sin(self.azimuth), np.cos(self.azimuth), 0.0])
        return Rotation.from_rotvec(self.tilt * across).as_matrix()

    def height(self, t: float) -> tuple[float, float, float]:
        """Height, velocity and acceleration of the plane along its normal."""
        rate = 2 * np.pi * self.frequency
        now = rate * t + self.phase
        a = self.amplitude
        return -a * np.cos(now), a * rate * np.sin(now), a * rate**2 * np.cos(now)

    def turned(self, t: float) -> np.ndarray:
        """The axes of the plane at this time as columns."""
        return self.plane @ Rotation.from_rotvec([0, 0, self.omega * t]).as_matrix()

    @property
    def centre_of_table(self) -> np.ndarray:
        """The axis of turning."""
        return self.plane @ [self.x, self.y, 0.0]


def split(s: np.ndarray) -> tuple[np.ndarray, ...]:
    """Place, velocity, momentum, axes."""
    return s[:3], s[3:6], s[6:9], s[9:18].reshape(3, 3)


class Point(NamedTuple):
    """The lowest point of a body, its velocity from the plane, and accelerations by forces there.

    The last of `rates` is that from the plane.
    """

    arm: np.ndarray
    omega: np.ndarray
    gap: float
    v: np.ndarray
    rates: Callable  # rates(F, T=0) -> v', L', v_A'


def lowest(s: np.ndarray, b: Body) -> Point:
    """Return the lowest point of a body in a state."""
    r, v, L, Q = split(s)
    n = b.plane[:, 2]
    inverse = Q @ np.diag(1 / np.array(b.inertia)) @ Q.T
    w = inverse @ L
    twist = Rotation.from_rotvec([0, 0, b.turn]).as_matrix()
    A = twist @ np.diag(np.square(b.half)) @ twist.T
    nb, nb_dot = Q.T @ n, Q.T @ np.cross(n, w)
    h = np.sqrt(nb @ A @ nb) or 1.0
    p = np.array(b.centre) - A @ nb / h
    p_dot = -A @ nb_dot / h + A @ nb * (nb @ A @ nb_dot) / h**3
    a = Q @ p
    a_dot = np.cross(w, a) + Q @ p_dot
    height, speed, lift = b.height(s[18])
    at = r + a - b.centre_of_table
    carries = speed * n + b.omega * np.cross(n, at)
    carries_dot = lift * n + b.omega * np.cross(n, v + a_dot)
    air = -(b.c1 + b.c2 * np.linalg.norm(w)) * w

    def rates(F: Any, T: Any = 0.0) -> tuple[np.ndarray, ...]:
        L_dot = np.cross(a, F) + air + T
        w_dot = inverse @ (L_dot - np.cross(w, L))
        v_dot = np.asarray(F) / b.m - [0, 0, b.g]
        G = v_dot + np.cross(w_dot, a) + np.cross(w, a_dot)
        return v_dot, L_dot, G - carries_dot

    return Point(a, w, n @ (r + a) - height, v + np.cross(w, a) - carries, rates)


def pressed(point: Point, push: np.ndarray, n: np.ndarray, twist: Any = 0.0) -> np.ndarray:
    """Return the force along `push` that keeps the contact point on the plane."""
    none = n @ point.rates(np.zeros(3))[2]
    one = n @ point.rates(push, twist)[2]
    return -none / (one - none) * push


def sliding(k: Callable) -> Callable:
    """Return force(s, b) of friction -k(|v|) N v."""

    def force(s: np.ndarray, b: Body) -> np.ndarray:
        point, n = lowest(s, b), b.plane[:, 2]
        slip = point.v - n * (n @ point.v)
        return pressed(point, n - k(np.linalg.norm(slip)) * slip, n)

    return force


def rolling(s: np.ndarray, b: Body) -> np.ndarray:
    """Return the force of a contact at rest."""
    point = lowest(s, b)
    none = point.rates(np.zeros(3))[2]
    K = np.array([point.rates(e)[2] - none for e in np.eye(3)]).T
    return -np.linalg.solve(K, none)


def flying(s: np.ndarray, b: Body) -> np.ndarray:
    """Return no force."""
    return np.zeros(3)


def motion(force: Callable, b: Body) -> Callable:
    """Return the right-hand side of the equations."""

    def rates(t: float, s: np.ndarray) -> np.ndarray:
        v_dot, L_dot, _ = lowest(s, b).rates(force(s, b))
        _, v, L, Q = split(s)
        w = Q @ ((Q.T @ L) / b.inertia)
        return np.concatenate([v, v_dot, L_dot, np.cross(w, Q.T).T.ravel(), [1.0]])

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
        return np.concatenate([0 * n, push / b.m, np.cross(point.arm, push), np.zeros(10)])

    def ends(p: float, s: np.ndarray) -> float:
        return n @ lowest(s, b).v + e_n * rises

    ends.terminal = True
    found = solve_ivp(rates, (0, 10 * b.m * abs(rises)), s, events=ends, **TIGHT)
    return found.y_events[0][0]


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
        slip = float(row.nu_x) * e + float(row.nu_y) * np.cross(n, e)
    rise = float(row.nu_z) if "nu_z" in row else 0.0
    gap = float(row.gap) if "gap" in row else 0.0
    s[:3] += n * (gap - lowest(s, b).gap)
    s[3:6] = slip + rise * n - lowest(s, b).v
    return s
