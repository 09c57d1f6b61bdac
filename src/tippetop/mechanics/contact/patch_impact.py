"""An impact of a patch that slides and drills: smooth friction, followed through the impact by extrapolation.

As `struck`, with mu f(x) for mu and the torque of drilling beside the force, which couples v_2 and Omega_z. The
variable is v_n, which rises all along. Where slip and drilling stop together, the patch sticks, or slips on where
friction cannot hold it. Numbers of any kind: the results have the digits of the arguments; numba can compile what
follows an impact. [contact 3.3, 5]
"""

import math
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ..disc_friction import drag
from ..operand import Operand, formula, rounding, sqrt
from .body import Touch
from .response import Mobility, Spin, mobility, spin_mobility
from .struck import RESTITUTIONS


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
    v: tuple,
    Omega_z: Any,
    s: Any,
    z: Any,
    b: Touch,
    e_n: Any,
    restitution: str = "energetic",
    room: "Room | None" = None,
    followed: Callable | None = None,
) -> PatchImpact:
    """The impact of a patch that arrives with v = (v_e, v_2, v_n), v_n < 0, and turns with Omega_z about the vertical.

    Parameters
    ----------
    v, Omega_z
        Velocity of the contact point [m/s] and vertical angular velocity [rad/s] before it.
    s, z
        sin(theta), cos(theta).
    b
        The body, under a law with mu and patch, the radius of the patch [m], above 0.
    e_n, restitution
        As for `struck`.
    room, followed
        Where it is followed, and by what: followed() -> as of `follow`, in this room. None: by Python.
    """
    K, spin, mu, patch = mobility(s, z, b), spin_mobility(s, z, b), b.friction.mu, b.friction.patch
    if restitution not in RESTITUTIONS or not 0 <= e_n <= 1 or not v[2] < 0 or not mu * abs(K.ez) < K.zz:
        raise ValueError(f"no impact: v_n = {v[2]}, e_n = {e_n}, mu = {mu}, restitution = {restitution!r}")
    none, eps = 0 * v[2], rounding(v[2])
    room = new_room(np.array([v[2]]).dtype) if room is None else room
    followed = followed or partial(follow, room, eps, MOST_STEPS)
    room.y[:] = [v[0], v[1], Omega_z, *(none,) * 6]
    room.given[:] = [*K, *spin, mu, patch]
    room.at[:] = [v[2], none, 0]
    room.size[0] = abs(v[2]) + _speed(room.y, patch)

    def to(v_n: Any) -> None:
        room.at[UNTIL] = v_n
        if not followed():
            raise ArithmeticError("the impact of a patch did not end: one that hardly turns takes too many steps")

    to(none)
    compression, pressed = room.y[WORK_N], room.y[P_Z]
    goals = {
        "energetic": (WORK_N, (1 - e_n**2) * compression, (2 * e_n**2 * abs(compression) * K.zz) ** 0.5),
        "poisson": (P_Z, (1 + e_n) * pressed, e_n * pressed * K.zz),
        "newton": (None, None, -e_n * v[2]),
    }
    field, goal, v_n = goals[restitution]
    if e_n > 0:
        below = room.y.copy(), room.at.copy()
        to(v_n)
        for _ in range(20 if field is not None else 0):  # Newton: the work rises by v_n, the impulse by 1, per impulse
            lift = K.zz + K.ez * _push(room.y, _patch(room), room.at[STUCK]).e
            missing = (goal - room.y[field]) * lift / (room.at[V_N] if field == WORK_N else 1)
            v_n = room.at[V_N] + missing
            if missing > 0:
                below = room.y.copy(), room.at.copy()
            elif -missing > 4 * eps * abs(v_n):  # never backwards, where what friction brought to rest would grow
                room.y[:], room.at[:] = below
            to(v_n)
            if abs(missing) < 2 * eps * abs(room.at[V_N]):
                break
    v_e, v_2, Omega_z, p_z, p_e, p_2, twist, work_n, work_t = room.y.tolist()
    v_n, _, stuck = room.at.tolist()
    mode = "stick" if stuck else "slip"
    return PatchImpact(p_e, p_2, p_z, twist, v_e, v_2, v_n, Omega_z, work_n, work_t, compression, mode)


P_Z, WORK_N, WORK_T = 3, 7, 8
V_N, UNTIL, STUCK = range(3)
MOST_STEPS, MOST_COMPILED = 20_000, 1_000_000
"""A patch that hardly drills is stiff: thousands of steps, of 2 ms each in Python and 5 us compiled."""


class Room(NamedTuple):
    """What an impact is followed in."""

    given: np.ndarray  # (8,) as `Patch`
    size: np.ndarray  # (1,) what rounding is relative to
    at: np.ndarray  # (3,) v_n, where to follow it, and whether the patch sticks
    y: np.ndarray  # (9,) v_e, v_2, Omega_z; impulses p_z, p_e, p_2, twist; works of normal force and friction
    first: np.ndarray  # (9,) the rates of y
    rate: np.ndarray
    old: np.ndarray
    new: np.ndarray
    error: np.ndarray
    rows: np.ndarray  # (8, 9) extrapolated: the last is the best


class Patch(NamedTuple):
    """A patch that strikes."""

    K: Mobility
    spin: Spin
    mu: Operand
    radius: Operand


class Push(NamedTuple):
    """Friction along e, across and about the vertical, per normal force."""

    e: Operand
    across: Operand
    about: Operand


def new_room(number: Any) -> Room:
    """Room for an impact in numbers of a kind."""
    shapes = (8,), (1,), (3,), (9,), (9,), (9,), (9,), (9,), (9,), (8, 9)
    return Room(*(np.array(np.zeros(shape), dtype=number) for shape in shapes))


@formula
def _patch(room):
    """The patch that strikes in a room."""
    g = room.given
    return Patch(Mobility(g[0], g[1], g[2], g[3]), Spin(g[4], g[5]), g[6], g[7])


@formula
def _speed(y, patch):
    """How fast the patch slides and turns, at its edge; or the rate of that."""
    return sqrt(y[0] * y[0] + y[1] * y[1]) + patch * abs(y[2])


@formula
def _push(y, p, stuck):
    """Friction in a state."""
    if stuck:
        return Push(-p.K.ez / p.K.ee, 0 * p.mu, 0 * p.mu)
    turn = p.radius * y[2]
    if y[0] == 0 and y[1] == 0 and turn == 0:  # it begins to slip where the normal impulse pushes it
        return Push(-p.mu if p.K.ez > 0 else p.mu, 0 * p.mu, 0 * p.mu)
    by = drag(y[0] * y[0] + y[1] * y[1], turn * turn)
    return Push(-p.mu * by.k * y[0], -p.mu * by.k * y[1], -p.mu * p.radius**2 * by.twist * y[2])


@formula
def _rate(out, v_n, y, p, stuck):
    """The rates of y by v_n."""
    K, spin, push = p.K, p.spin, _push(y, p, stuck)
    per = 1 / (K.zz + K.ez * push.e)  # impulse per v_n
    work = push.e * y[0] + push.across * y[1] + push.about * y[2]
    out[0] = (K.ez + K.ee * push.e) * per
    out[1] = (K.tt * push.across + spin.across * push.about) * per
    out[2] = (spin.across * push.across + spin.about * push.about) * per
    out[P_Z], out[4], out[5], out[6] = per, push.e * per, push.across * per, push.about * per
    out[WORK_N], out[WORK_T] = v_n * per, work * per
    if stuck:
        out[0], out[WORK_T] = 0 * per, 0 * per


@formula
def _extrapolated(room, p, stuck, t, step):
    """One step of the midpoint rule, extrapolated to order 16 (Gragg, Bulirsch, Stoer), and its last addition."""
    y, first, rate, old, new, rows = room.y, room.first, room.rate, room.old, room.new, room.rows
    one = 0 * step + 1
    for k in range(1, 9):
        h = step / (2 * k)
        for f in range(9):
            old[f], new[f] = y[f], y[f] + h * first[f]
        for i in range(1, 2 * k + 1):
            _rate(rate, t + i * h, new, p, stuck)
            if i < 2 * k:
                for f in range(9):
                    before = old[f]
                    old[f], new[f] = new[f], before + 2 * h * rate[f]
        for f in range(9):
            value = (old[f] + new[f] + h * rate[f]) / 2
            for j in range(1, k):
                excess = one * (j * (2 * k - j)) / ((k - j) * (k - j))  # (k/(k - j))^2 - 1
                addition = (value - rows[j - 1, f]) / excess
                rows[j - 1, f] = value
                value = value + addition
                room.error[f] = abs(addition)
            rows[k - 1, f] = value


@formula
def bounded(step, still, change):
    """A step by which a motion that changes at the rate `change` loses at most half: one that reverses friction would
    look exact. From rest there is no bound."""
    return step if change * abs(step) <= still / 2 or still == 0 else step * (still / 2 / (change * abs(step)))


@formula
def excess(room, p, moving, step, eps):
    """The error of a step, of errors that are rounding: of velocities by what is left of them, of the rest by what
    there is."""
    press, most = room.y[P_Z] + abs(step) / p.K.zz, 0.0
    for f in range(9):
        size = moving
        if f == 2:
            size = max(abs(room.y[2]), moving / p.radius)
        elif f == 6:
            size = press * p.radius
        elif f >= WORK_N:
            size = press * room.size[0]
        elif f >= P_Z:
            size = press
        if room.error[f] != 0:  # what sticks has no size, and no error
            ratio = float(room.error[f] / (135 * eps * size))
            if not ratio <= most:
                most = ratio if ratio == ratio else math.inf
    return most


@formula
def follow(room, eps, most):
    """Takes an impact to v_n = room.at[UNTIL], forwards or by roundings backwards. Gives whether it came there in at
    most so many steps."""
    at, y, p, size = room.at, room.y, _patch(room), room.size[0]
    step = at[UNTIL] - at[V_N]
    for _ in range(most):
        left = at[UNTIL] - at[V_N]
        if left == 0:
            return 1
        still = _speed(y, p.radius)
        moves = y[0] != 0 or y[1] != 0 or y[2] != 0  # even where its square is no number
        if not at[STUCK] and moves and still < 450 * eps * size:
            still, y[0], y[1], y[2], step = 0 * size, 0 * size, 0 * size, 0 * size, left
        if not at[STUCK] and still == 0 and abs(p.K.ez) <= p.mu * p.K.ee:
            at[STUCK] = 1
        stuck = bool(at[STUCK])
        _rate(room.first, at[V_N], y, p, stuck)
        change = _speed(room.first, p.radius)
        step = bounded(step, still, change)
        last = abs(step) >= abs(left)
        step = left if last else step
        _extrapolated(room, p, stuck, at[V_N], step)
        error = excess(room, p, max(still, change * abs(step)), step, eps)
        if not error <= 1:
            step = step / 3
            if step != step:  # however short: friction is stiff where hardly anything turns
                return 0
            continue
        for f in range(9):
            y[f] = room.rows[7, f]
        at[V_N] = at[UNTIL] if last else at[V_N] + step
        step = step * (2 if error < 0.1 else 1)
    return 0
