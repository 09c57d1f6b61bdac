"""An impact under a friction law that is smooth in the sliding velocity: F_h = -k(|v|^2) g_n v, so dp_h = -k v dpi.

The equations of `contact.struck`, whose law has a corner at v = 0, without one. The vertical velocity v_n, which rises
all along, is the time: compression ends at v_n = 0 exactly. Steps are Picard's, on Chebyshev's nodes. Numbers of any
kind; for doubles it is compiled.
"""

import math
from functools import lru_cache, partial
from typing import Any, NamedTuple

import numpy as np

from tippetop_kernels.compilation import entry

from ...mechanics.contact.body import Touch
from ...mechanics.contact.impact import Struck, after_impact, arrival
from ...mechanics.contact.response import Mobility
from ...mechanics.contact.struck import RESTITUTIONS, Impact
from ...mechanics.friction import slip_coefficient
from ...mechanics.operand import Vector, formula


SWEEPS = 60
UNRESOLVED, SMALL = 18.0, 2.0  # roundings of the largest value: last coefficients of a step too long; a last correction
MOST_PARTS = 40  # halvings of a step
MOST_TRIES = 12  # of the end of an impact
V_E, V_2, IMPULSE, WORK_N, WORK_T = range(5)
ENDED, UNSOLVED, STIFF = range(3)
MEANT = {
    UNSOLVED: "friction jams the contact within an impact, or is not finite: it has no solution",
    STIFF: "friction within an impact is too stiff to be followed",
}
ENERGETIC, POISSON, NEWTON = range(3)


class Nodes(NamedTuple):
    """Chebyshev's nodes in [0, 1], (n,); matrices that, multiplied from the right, integrate from 0 to each of them,
    (n, n), and give the last two coefficients, (n, 2)."""

    x: np.ndarray
    integral: np.ndarray
    last: np.ndarray


class Room(NamedTuple):
    """What an impact works in."""

    given: np.ndarray  # (9,) v_e, v_2, v_n, K, z and e_n
    result: np.ndarray  # (7,) the five numbers of a state, v_n after it, and the work of compression
    state: np.ndarray  # (5,)
    values: np.ndarray  # (5, n)
    slopes: np.ndarray
    row: np.ndarray  # (n,)
    ends: np.ndarray  # (MOST_PARTS + 1,)


def new_room(nodes: int, number: Any) -> Room:
    """Room for so many nodes."""
    shapes = (9,), (7,), (5,), (5, nodes), (5, nodes), (nodes,), (MOST_PARTS + 1,)
    return Room(*(np.array(np.zeros(shape), dtype=number) for shape in shapes))


@lru_cache
def new_nodes(count: int, number: Any) -> Nodes:
    """So many nodes, in numbers of a kind."""
    pi = number(4) * np.arctan(number(1))
    k = np.array([number(i) for i in range(count)])
    angle = pi * k / (count - 1)
    x = (1 - np.cos(angle)) / 2
    ends = np.array([number(2) if i in (0, count - 1) else number(1) for i in range(count)])
    of_values = np.cos(pi * (k[:, None] * (count - 1 - k)) / (count - 1)) * 2 / (count - 1) / ends / ends[:, None]
    integrals = np.zeros((count, count), dtype=x.dtype)  # of T_k, from the first node to each
    for i in range(count):
        above = np.cos((k[i] + 1) * (pi - angle)) / (k[i] + 1)
        below = np.cos((k[i] - 1) * (pi - angle)) / (k[i] - 1) if i > 1 else 0 * above
        integrals[i] = above if i == 0 else above / 2 - below / 2
        integrals[i] = (integrals[i] - integrals[i, 0]) / 2
    return Nodes(x, np.ascontiguousarray(of_values.T @ integrals), np.ascontiguousarray(of_values.T[:, -2:]))


@formula
def _slopes(room, K, z, law, at, k):
    """Rates of the state by v_n at a node; `at` is v_n there."""
    values, slopes = room.values, room.slopes
    v_e, v_2 = values[V_E, k], values[V_2, k]
    pull = slip_coefficient(v_e * v_e + v_2 * v_2, z, law)
    along, sideways = pull * v_e, pull * v_2
    per = 1 / (K.zz - K.ez * along)  # impulse per v_n
    slopes[V_E, k], slopes[V_2, k], slopes[IMPULSE, k] = (K.ez - K.ee * along) * per, -(K.tt * sideways) * per, per
    slopes[WORK_N, k], slopes[WORK_T, k] = at * per, -(along * v_e + sideways * v_2) * per


@formula
def _sizes(h, speed, impulse, work):
    """What rounding is relative to, of the largest values of a step: velocities to the largest of them, impulse, works
    to the larger."""
    speed = max(speed, abs(h))
    return speed + 1e-300, impulse + 1e-300, max(work, abs(h) * impulse) + 1e-300


@formula
def _sweep_in_loops(room, nodes, K, z, start, h, law):
    """`_sweep`, for numba."""
    n, values, slopes, row = len(nodes.x), room.values, room.slopes, room.row
    least, change, last = math.inf, 0.0, 0.0
    speed, impulse, work = 0 * h, 0 * h, 0 * h
    for k in range(n):
        _slopes(room, K, z, law, start + h * nodes.x[k], k)
        least = min(least, float(slopes[IMPULSE, k]))
        speed = max(speed, abs(values[V_E, k]), abs(values[V_2, k]))
        impulse = max(impulse, abs(values[IMPULSE, k]))
        work = max(work, abs(values[WORK_N, k]), abs(values[WORK_T, k]))
    sizes = _sizes(h, speed, impulse, work)
    for f in range(5):
        size = sizes[0] if f < IMPULSE else sizes[1] if f == IMPULSE else sizes[2]
        for k in range(n):
            row[k] = 0 * h
        for i in range(n):
            slope, part = slopes[f, i], nodes.integral[i]
            for k in range(n):
                row[k] = row[k] + slope * part[k]
        for k in range(n):
            value = room.state[f] + h * row[k]
            change = _greater(change, float(abs(value - values[f, k]) / size))
            values[f, k] = value
        for j in range(2):
            total = 0 * h
            for i in range(n):
                total = total + values[f, i] * nodes.last[i, j]
            last = _greater(last, float(abs(total) / size))
    return change, least, last


def _sweep(room, nodes, K, z, start, h, law):
    """One more approximation of a step, into room.values. Gives the largest change, relative to `_sizes`, the least
    impulse per v_n, and the largest of the last two coefficients."""
    values = room.values
    _slopes(room, K, z, law, start + h * nodes.x, slice(None))
    most = np.max(np.abs(values), axis=1)
    sizes = _sizes(h, max(most[:IMPULSE]), most[IMPULSE], max(most[WORK_N:]))
    size = np.array([sizes[0], sizes[0], sizes[1], sizes[2], sizes[2]])[:, None]
    newer = room.state[:, None] + h * (room.slopes @ nodes.integral)
    change = float(np.max(np.abs(newer - values) / size))
    values[:] = newer
    return change, float(np.min(room.slopes[IMPULSE])), float(np.max(np.abs(values @ nodes.last) / size))


_sweep.for_numba = lambda law: _sweep_in_loops  # type: ignore[attr-defined]  # numbers of other kinds have no numba
formula(_sweep)


@formula
def _swept(room, nodes, K, z, law, start, h, eps):
    """One step from room.state: its values at the nodes, in room.values. Gives how it went."""
    before = math.inf
    for f in range(5):
        for k in range(len(nodes.x)):
            room.values[f, k] = room.state[f]
    for _ in range(SWEEPS):
        change, least, last = _sweep(room, nodes, K, z, start, h, law)
        if not 0 < room.slopes[IMPULSE, 0] < math.inf:
            return UNSOLVED
        if change <= SMALL * eps or (change < 50 * eps and change >= before):
            return ENDED if least > 0 and last <= UNRESOLVED * eps else STIFF
        if not change < 1e3 * max(before, 1e-3):
            return STIFF
        before = change
    return STIFF


@formula
def _greater(a, b):
    """The greater of two numbers; b if it is none."""
    return a if b <= a else b


@formula
def _integrated(room, nodes, K, z, law, start, end, eps):
    """Takes room.state from v_n = start to v_n = end, by steps that are halved where they are too long. Gives how it
    went."""
    room.ends[0], waiting, at = end, 1, start
    while waiting > 0:
        upto = room.ends[waiting - 1]
        how = _swept(room, nodes, K, z, law, at, upto - at, eps)
        if how == ENDED:
            for f in range(5):
                room.state[f] = room.values[f, len(nodes.x) - 1]
            at, waiting = upto, waiting - 1
        elif how == UNSOLVED or waiting == len(room.ends):
            return how
        else:
            room.ends[waiting] = at + (upto - at) / 2
            waiting += 1
    return ENDED


@formula
def _strike(room, nodes, law, restitution, eps):
    """The impact that room.given says, into room.result. Gives how it went."""
    v_e, v_2, v_n, z, e_n = room.given[0], room.given[1], room.given[2], room.given[7], room.given[8]
    K = Mobility(room.given[3], room.given[4], room.given[5], room.given[6])
    none, state, result, how, after = 0 * v_n, room.state, room.result, ENDED, 0 * v_n
    field, value, start = IMPULSE if restitution == POISSON else WORK_N, none, v_n
    result[0], result[1], result[2], result[3], result[4], result[6] = v_e, v_2, none, none, none, none
    for attempt in range(MOST_TRIES):  # compression; then as far as the law of restitution says
        for f in range(5):
            state[f] = result[f]
        how = _integrated(room, nodes, K, z, law, start, after, eps)
        if how != ENDED:
            return how
        if attempt == 0:
            for f in range(5):
                result[f] = state[f]
            result[6] = state[WORK_N]
            value = (1 + e_n) * state[IMPULSE] if restitution == POISSON else (1 - e_n * e_n) * state[WORK_N]
            start, after = none, -(e_n * v_n)
            if e_n == 0:
                break
            continue
        if restitution == NEWTON:
            break
        change = (value - state[field]) / room.slopes[field, len(nodes.x) - 1]
        if abs(change) <= 4 * eps * after:
            state[field] = value
            break
        after = after + change
    for f in range(5):
        result[f] = state[f]
    result[5] = after
    return how


@formula
def _impulses(room, v_e, v_2, K):
    """The impulse along e and 2hat of the impact that is done, of the slip before and after it."""
    result = room.result
    return (result[V_E] - v_e - K.ez * result[IMPULSE]) / K.ee, (result[V_2] - v_2) / K.tt


@entry
def strike(room, nodes, law, restitution):
    """`_strike` in doubles."""
    return _strike(room, nodes, law, restitution, 2.0**-52)


@entry
def hit(numbers, room, nodes, law, restitution):
    """The impact of a body of which numbers[:16] are axis, L, velocity, the numbers of its Touch, e_n; gives how it
    went. After them come the velocity of the contact before, `Struck`, and the impulses along e and 2hat; room.result
    has the rest."""
    u, L = Vector(numbers[0], numbers[1], numbers[2]), Vector(numbers[3], numbers[4], numbers[5])
    velocity = Vector(numbers[6], numbers[7], numbers[8])
    body = Touch(numbers[9], numbers[10], numbers[11], numbers[12], numbers[13], numbers[14], (), (), ())
    a = arrival(u, L, velocity, body)
    room.given[0], room.given[1], room.given[2] = a.along, a.sideways, a.v.z
    room.given[3], room.given[4], room.given[5], room.given[6] = a.K.ee, a.K.zz, a.K.ez, a.K.tt
    room.given[7], room.given[8] = u.z, numbers[15]
    how = _strike(room, nodes, law, restitution, 2.0**-52)
    p_e, p_2 = _impulses(room, a.along, a.sideways, a.K)
    b = after_impact(u, L, velocity, a, p_e, p_2, room.result[IMPULSE], 0.0, body)
    numbers[16], numbers[17], numbers[18] = a.v.x, a.v.y, a.v.z
    numbers[19], numbers[20], numbers[21] = b.p.x, b.p.y, b.p.z
    numbers[22], numbers[23], numbers[24] = b.L.x, b.L.y, b.L.z
    numbers[25], numbers[26], numbers[27] = b.velocity.x, b.velocity.y, b.velocity.z
    numbers[28], numbers[29], numbers[30] = b.v.x, b.v.y, b.v.z
    numbers[31], numbers[32], numbers[33] = b.gained, p_e, p_2
    return how


class SmoothImpacts:
    """Impacts under one friction law.

    Parameters
    ----------
    law
        The record of a law, with its numbers.
    restitution
        As of `contact.struck.struck`.
    number
        The type of numbers.
    """

    def __init__(self, law: Any, restitution: str, number: Any = np.float64):
        count, self.eps = {np.float64: (20, 2.0**-52), np.longdouble: (24, 2.0**-63)}.get(number, (40, 2.0**-112))
        self.law, self.restitution, self.number = law, RESTITUTIONS.index(restitution), number
        self.room, self.nodes = new_room(count, number), new_nodes(count, number)
        self.compiled = number is np.float64
        if self.compiled:
            self.numbers, given = np.zeros(34), (self.room, self.nodes, law, self.restitution)
            self.strike, self.hit = partial(strike, *given), partial(hit, self.numbers, *given)

    def struck(self, v_e: Any, v_2: Any, v_n: Any, K: Mobility, z: Any, e_n: Any) -> Impact:
        """The impact of a contact point that arrives with v_n < 0.

        Parameters
        ----------
        v_e, v_2, v_n
            Velocity of the contact point before it, along e, 2hat, zhat.
        K
            Mobility of the contact.
        z
            cos(theta), which a law may depend on.
        e_n
            Coefficient of restitution.

        Returns
        -------
        Impact
            After it.

        Raises
        ------
        ArithmeticError
            If the law is too stiff to be followed, or jams the contact.
        """
        room = self.room
        room.given[:] = [self.number(x) for x in (v_e, v_2, v_n, *K, z, e_n)]
        how = self.strike() if self.compiled else _strike(room, self.nodes, self.law, self.restitution, self.eps)
        if how != ENDED:
            raise ArithmeticError(MEANT[how])
        return self._impact(*_impulses(room, v_e, v_2, K))

    def body_struck(
        self, u: Vector, L: Vector, velocity: Vector, b: Touch, e_n: float
    ) -> tuple[Vector, Impact, Struck]:
        """The impact of a body in doubles, from its axis, momentum and velocity: the velocity of its lowest point
        before it, the impact, the body after it. Raises ArithmeticError, as `struck` does."""
        self.numbers[:16] = (*u, *L, *velocity, *b[:6], e_n)
        how = self.hit()
        if how != ENDED:
            raise ArithmeticError(MEANT[how])
        n = self.numbers[16:].tolist()
        v, p, newer, moves, after = (Vector(*n[k : k + 3]) for k in range(0, 15, 3))
        return v, self._impact(n[16], n[17]), Struck(p, newer, moves, after, n[15])

    def _impact(self, p_e: Any, p_2: Any) -> Impact:
        left_e, left_2, p_z, work_n, work_t, after, compression = self.room.result.tolist()
        return Impact(p_e, p_2, p_z, left_e, left_2, after, work_n, work_t, compression, "slip")
