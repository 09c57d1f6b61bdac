"""An impact of a patch that slides and drills: smooth friction, followed through the impact by extrapolation.

As `struck`, with mu f(x) for mu and the torque of drilling beside the force, which couples v_2 and Omega_z. The
variable is v_n, which rises all along. Where slip and drilling stop together, the patch sticks. Numbers of any kind:
the results have the digits of the arguments. [contact 3.3, 5]
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..operand import Operand, formula, rounding, sqrt
from .ball import Ball, Mobility, mobility
from .drilling import drag
from .struck import RESTITUTIONS


class Spin(NamedTuple):
    """What a torque about the vertical does: to v_2 and to Omega_z [1/(kg m), 1/(kg m^2)]."""

    across: Operand
    about: Operand


@formula
def spin_mobility(s, z, ball):
    """By sin(theta), cos(theta); an impulse along 2hat gives Omega_z as much as the torque gives v_2."""
    excess = 1 / ball.I3 - 1 / ball.I1
    return Spin(s * (ball.offset / ball.I1 + ball.radius * z * excess), s**2 / ball.I1 + z**2 / ball.I3)


class PatchImpact(NamedTuple):
    """Impulse [N s], impulse of the torque [N m s]; velocity and Omega_z after it; works [J]; how it ended."""

    p_e: Any
    p_2: Any
    p_z: Any
    twist: Any
    v_e: Any
    v_2: Any
    v_n: Any
    Omega_z: Any
    work_n: Any
    work_t: Any
    compression: Any
    mode: str  # "slip" or "stick"

    @property
    def energy(self) -> Any:
        """What the impact adds to the energy [J]."""
        return self.work_n + self.work_t

    @property
    def makes_energy(self) -> bool:
        """Whether it adds more than rounding does."""
        return bool(self.energy > 1e-12 * abs(self.compression))


def patch_struck(
    v: tuple, Omega_z: Any, s: Any, z: Any, ball: Ball, patch: Any, e_n: Any, restitution: str = "energetic"
) -> PatchImpact:
    """The impact of a patch that arrives with v = (v_e, v_2, v_n), v_n < 0, and turns with Omega_z about the vertical.

    Parameters
    ----------
    v, Omega_z
        Velocity of the contact point [m/s] and vertical angular velocity [rad/s] before it.
    s, z
        sin(theta), cos(theta).
    ball
        The ball, with mu.
    patch
        Radius of the patch [m].
    e_n, restitution
        As for `struck`.
    """
    K, spin = mobility(s, z, ball), spin_mobility(s, z, ball)
    if restitution not in RESTITUTIONS or not 0 <= e_n <= 1 or not v[2] < 0 or not ball.mu * abs(K.ez) < K.zz:
        raise ValueError(f"no impact: v_n = {v[2]}, e_n = {e_n}, mu = {ball.mu}, restitution = {restitution!r}")
    none = 0 * v[2]
    way = _Way(K, spin, ball.mu, patch, np.array([v[0], v[1], Omega_z, *(none,) * 6]), v[2])
    way.follow(none)
    compression, pressed = way.y[WORK_N], way.y[P_Z]
    goals = {
        "energetic": (WORK_N, (1 - e_n**2) * compression, (2 * e_n**2 * abs(compression) * K.zz) ** 0.5),
        "poisson": (P_Z, (1 + e_n) * pressed, e_n * pressed * K.zz),
        "newton": (None, None, -e_n * v[2]),
    }
    field, goal, v_n = goals[restitution]
    if e_n > 0:
        way.follow(v_n)
        for _ in range(20 if field is not None else 0):  # Newton: the work rises by v_n, the impulse by 1, per impulse
            missing = (goal - way.y[field]) * way.lift() / (way.v_n if field == WORK_N else 1)
            way.follow(way.v_n + missing)
            if abs(missing) < 2 * way.eps * abs(way.v_n):
                break
    v_e, v_2, Omega_z, p_z, p_e, p_2, twist, work_n, work_t = way.y.tolist()
    mode = "stick" if way.stuck else "slip"
    return PatchImpact(p_e, p_2, p_z, twist, v_e, v_2, way.v_n, Omega_z, work_n, work_t, compression, mode)


P_Z, WORK_N = 3, 7

MOST_STEPS = 20_000
"""A patch that hardly drills is stiff: thousands of steps, of 2 ms each."""


class _Way:
    """v_e, v_2, Omega_z; impulses p_z, p_e, p_2, twist; works of normal force and friction: y, by v_n."""

    def __init__(self, K: Mobility, spin: Spin, mu: Any, patch: Any, y: np.ndarray, v_n: Any) -> None:
        self.K, self.spin, self.mu, self.patch, self.y, self.v_n = K, spin, mu, patch, y, v_n
        self.stuck, self.eps = False, rounding(v_n)
        self.size = abs(v_n) + self.speed(y)

    def speed(self, y: np.ndarray) -> Any:
        """How fast the patch slides and turns, at its edge; or the rate of that."""
        return sqrt(y[0] * y[0] + y[1] * y[1]) + self.patch * abs(y[2])

    def push(self, y: np.ndarray) -> tuple:
        """Friction along e, across and about the vertical, per normal force."""
        if self.stuck:
            return -self.K.ez / self.K.ee, 0.0, 0.0
        v_e, v_2, Omega_z = y[:3].tolist()
        k, twist = drag(v_e**2 + v_2**2, (self.patch * Omega_z) ** 2)
        return -self.mu * k * v_e, -self.mu * k * v_2, -self.mu * self.patch**2 * twist * Omega_z

    def lift(self) -> Any:
        """What v_n gains per normal impulse."""
        return self.K.zz + self.K.ez * self.push(self.y)[0]

    def rate(self, v_n: Any, y: np.ndarray) -> np.ndarray:
        K, spin = self.K, self.spin
        e, t, about = self.push(y)
        along, across = K.ez + K.ee * e, K.tt * t + spin.across * about
        turn = spin.across * t + spin.about * about
        work_t = e * y[0] + t * y[1] + about * y[2]
        if self.stuck:
            along, work_t = 0.0, 0.0
        return np.array([along, across, turn, 1, e, t, about, v_n, work_t]) / (K.zz + K.ez * e)

    def follow(self, until: Any) -> None:
        """To v_n = until, forwards or a little backwards."""
        step = until - self.v_n
        for _ in range(MOST_STEPS):
            if self.v_n == until:
                return
            still = self.speed(self.y)
            if not self.stuck and still < 450 * self.eps * self.size and abs(self.K.ez) <= self.mu * self.K.ee:
                self.stuck, self.y[:3], step = True, 0.0, until - self.v_n
            change = self.speed(self.rate(self.v_n, self.y))
            if change * abs(step) > still / 2 > 0:  # a step that reverses friction would look exact
                step = still / (2 * change) * (1 if step > 0 else -1)
            last = abs(step) >= abs(until - self.v_n)
            step = until - self.v_n if last else step
            y, error = extrapolated(self.rate, self.v_n, self.y, step)
            excess = float(np.max(error.astype(float) / self.tolerated(still, step)))
            if not excess <= 1 and abs(step) > 4 * self.eps * self.size:
                step = step / 3
                continue
            self.y, self.v_n = y, until if last else self.v_n + step
            step = step * (2 if excess < 0.1 else 1)
        raise ArithmeticError(f"the impact of a patch did not end in {MOST_STEPS} steps")

    def tolerated(self, still: Any, step: Any) -> np.ndarray:
        """Errors of a step that are rounding: of velocities by what is left of them, of the rest by what there is."""
        p = self.y[P_Z] + abs(step) / self.K.zz
        turn = max(abs(self.y[2]), still / self.patch if self.patch else still + 1)
        twist = p * (self.patch or 1.0)
        sizes = np.array([*map(float, (still, still, turn, p, p, p, twist, p * self.size, p * self.size))])
        return 135 * self.eps * sizes + 1e-14 * self.eps


def extrapolated(rate: Callable, t: Any, y: np.ndarray, step: Any) -> tuple[np.ndarray, np.ndarray]:
    """One step of the midpoint rule, extrapolated to order 16 (Gragg, Bulirsch, Stoer), and its last addition."""
    first, one = rate(t, y), 0 * step + 1
    rows: list[list[np.ndarray]] = []
    for k in range(1, 9):
        n = 2 * k
        h = step / n
        old, new = y, y + h * first
        for i in range(1, n):
            old, new = new, old + 2 * h * rate(t + i * h, new)
        row = [(old + new + h * rate(t + step, new)) / 2]
        for j in range(1, k):
            excess = one * (j * (2 * k - j)) / (k - j) ** 2  # (k/(k - j))^2 - 1
            row.append(row[-1] + (row[-1] - rows[-1][j - 1]) / excess)
        rows.append(row)
    return rows[-1][-1], np.abs(rows[-1][-1] - rows[-1][-2])
