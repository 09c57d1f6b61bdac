"""An impact from its beginning to its end: slip that turns, stops, sticks or reverses, and
restitution. [contact 3.3]

Slip in a direction that stays, and what follows a stop, is linear in the normal impulse: closed
form. Slip that turns is followed in sigma, dp = w dsigma, by Taylor series, in variables that are
polynomials of each other and keep their digits: the cosine C of the direction is side (1 - b) with
b small near the plane of the axis. Numbers of any kind: float, longdouble, mpmath; the results have
the digits of the arguments.
"""

import math
from operator import mul
from typing import Any, NamedTuple

from ..operand import Vector, rounding
from .response import Mobility


RESTITUTIONS = ("energetic", "poisson", "newton")


class Impact(NamedTuple):
    """Impulse [N s] and velocity of the contact point after it [m/s] along e, 2hat, zhat; works
    [J]; how it ended.
    """

    p_e: Any
    p_2: Any
    p_z: Any
    v_e: Any
    v_2: Any
    v_n: Any
    work_n: Any  # of the normal impulse
    work_t: Any  # of friction, never positive
    compression: Any  # work of the normal impulse until v_n = 0
    mode: str  # "slip": it never stopped; "stick" or "reverse": what followed the stop
    twist: Any = Vector(0.0, 0.0, 0.0)  # impulse of the torque [N m s]
    Omega_z: Any = 0  # of a disc after it [rad/s]

    @property
    def energy(self) -> Any:
        """What the impact adds to the energy [J]: p.(v- + v+)/2."""
        return self.work_n + self.work_t

    @property
    def makes_energy(self) -> bool:
        """Whether it adds more than rounding does; only restitution = newton can, and that is no
        model of an impact.
        """
        return bool(self.energy > 1e-12 * abs(self.compression))


class _Moment(NamedTuple):
    """Where an impact stands: direction (side, b), slip w, v_n; and what a stage has added up since
    it began.
    """

    side: int
    b: Any
    w: Any
    v_n: Any
    p_e: Any  # of the impact so far
    p_2: Any
    impulse: Any  # normal
    work_n: Any
    slid: Any  # the integral of w over the impulse


class _Stage(NamedTuple):
    """Compression, or restitution by a law: it ends where a field of the moment, which rises,
    reaches a value.
    """

    field: str
    value: Any


def struck(
    v_e: Any, v_2: Any, v_n: Any, K: Mobility, mu: Any, e_n: Any, restitution: str = "energetic"
) -> Impact:
    """The impact of a contact point that arrives with v_n < 0.

    Parameters
    ----------
    v_e, v_2, v_n
        Velocity of the contact point before it, along e, 2hat, zhat [m/s].
    K
        Mobility of the contact.
    mu, e_n
        Coulomb's coefficient, below Painleve's bound K.zz/|K.ez|, and the coefficient of
        restitution in [0, 1].
    restitution
        "energetic" (Stronge): the work of restitution is e_n^2 that of compression; "poisson": so
        are the impulses, with e_n; "newton": so are the normal velocities, which can make energy.

    Returns
    -------
    Impact
        After it.
    """
    numbers = [float(x) if isinstance(x, (int, float)) else x for x in (v_e, v_2, v_n, mu, e_n, *K)]
    v_e, v_2, v_n, mu, e_n = numbers[:5]
    slip = _Slip(Mobility(*numbers[5:]), mu, abs(v_n), 1 if v_2 >= 0 else -1)
    if (
        restitution not in RESTITUTIONS
        or not 0 <= e_n <= 1
        or not v_n < 0
        or not mu * abs(slip.K.ez) < slip.K.zz
    ):
        raise ValueError(
            f"no impact: v_n = {v_n}, e_n = {e_n}, mu = {mu}, restitution = {restitution!r}"
        )
    w = (v_e * v_e + v_2 * v_2) ** 0.5
    none = 0 * w
    b = v_2 * v_2 / (w * (w + abs(v_e))) if w else none
    start = _Moment(1 if v_e >= 0 else -1, b, w, v_n, *(none,) * 5)
    at = pressed = slip.followed(start, _Stage("v_n", none))
    if e_n > 0:
        field, value = {
            "energetic": ("work_n", -(e_n**2) * pressed.work_n),
            "poisson": ("impulse", e_n * pressed.impulse),
            "newton": ("v_n", -e_n * v_n),
        }[restitution]
        at = slip.followed(
            pressed._replace(impulse=none, work_n=none, slid=none), _Stage(field, value)
        )
        total = (pressed.impulse + at.impulse, pressed.work_n + at.work_n, pressed.slid + at.slid)
        at = at._replace(impulse=total[0], work_n=total[1], slid=total[2])
    if mu == 0:
        v_e = v_e + slip.K.ez * at.impulse
        return Impact(
            none, none, at.impulse, v_e, v_2, at.v_n, at.work_n, none, pressed.work_n, "slip"
        )
    after = (at.side * (1 - at.b) * at.w, slip.turn * (at.b * (2 - at.b)) ** 0.5 * at.w, at.v_n)
    works = (at.work_n, -mu * at.slid, pressed.work_n)
    return Impact(at.p_e, at.p_2, at.impulse, *after, *works, slip.mode)


class _Slip:
    """The contact during one impact."""

    def __init__(self, K: Mobility, mu: Any, speed: Any, turn: int) -> None:
        self.K, self.mu, self.turn, self.mode = K, mu, turn, "slip"  # turn: the sign of v_2
        eps = rounding(speed)
        self.stopped_below = eps * speed * min(1, mu) / 1000
        self.order = max(20, math.ceil(-0.56 * math.log(eps)))
        self.straight_below = eps**2 / 100  # v_2 is sqrt(2 b) w
        self.share = eps / 10  # of a value: the terms that a series leaves out
        self.most = 0 * speed  # the greatest w so far
        D = mu * (K.ee - K.tt)
        turns = (
            K.ez**2 / (4 * D) if abs(K.ez) < 2 * D else 0
        )  # the rate of log w is K_ez C - D C^2 - mu K_tt
        self.decays = abs(K.ez) < mu * K.ee and turns < mu * K.tt

    def followed(self, at: _Moment, stage: _Stage) -> _Moment:
        """The moment at which the stage ends."""
        K, mu, ended = self.K, self.mu, False
        while not ended:
            pull = at.side * K.ez
            if mu == 0:
                at, ended = _linear(at, stage, K.zz, 0, 0)
            elif self.mode == "slip" and at.w <= self.stopped_below:
                self.mode = "stick" if abs(K.ez) <= mu * K.ee else "reverse"
                at = at._replace(side=1 if K.ez > 0 else -1, b=0 * at.b, w=0 * at.w)
            elif self.mode == "stick":
                at, ended = _linear(at, stage, K.zz - K.ez**2 / K.ee, 0, -K.ez / K.ee)
            elif (
                at.b <= self.straight_below and pull > mu * (K.ee - K.tt)
            ) or at.b == 0:  # on e, to which slip turns
                at = at._replace(b=0 * at.b)
                at, ended = _linear(at, stage, K.zz - mu * pull, pull - mu * K.ee, -mu * at.side)
            else:
                at, ended = self.turned(at, stage)
        return at

    def turned(self, at: _Moment, stage: _Stage) -> tuple[_Moment, bool]:
        """One step of slip that turns; and whether the stage ends in it."""
        series = self.series(at)
        step = self.step(series)
        if ended := bool(_sum(series[stage.field], step) >= stage.value):
            step = _root(series[stage.field], stage.value, step)
        after = _Moment(at.side, **{field: _sum(series[field], step) for field in series})
        if ended:
            after = after._replace(**{stage.field: stage.value})
        return after if after.b <= 1 else after._replace(side=-after.side, b=2 - after.b), ended

    def series(self, at: _Moment) -> dict[str, list]:
        """Taylor coefficients by sigma of every field but the side: b, w and the rest are
        polynomials of each other.
        """
        K, mu, side = self.K, self.mu, at.side
        D = mu * (K.ee - K.tt)
        q = K.ez - side * D  # of K_ez - D C = q + side D b
        b, w, v_n = [at.b], [at.w], [at.v_n]
        x, y = (
            [side * (1 - at.b) * at.w],
            self.turn * (at.b * (2 - at.b)) ** 0.5 * at.w,
        )  # the slip along e, along 2hat
        p_e, p_2, impulse, work_n, slid = ([x] for x in at[4:])
        g, P = [], []  # 1 - C^2 = 2 b - b^2, and the rate of log w
        for n in range(self.order):
            b2 = _term(b, b)
            g.append(2 * b[n] - b2)
            P.append((D - side * q) * b[n] - D * b2)
            if n == 0:
                P[0] += side * q - mu * K.tt
            b.append(-(side * q * g[n] + D * _term(g, b)) / (n + 1))
            x.append((K.ez * w[n] - mu * K.ee * x[n]) / (n + 1))
            v_n.append((K.zz * w[n] - mu * K.ez * x[n]) / (n + 1))
            p_e.append(-mu * x[n] / (n + 1))
            p_2.append(-mu * y / (n + 1))
            y = -mu * K.tt * y / (n + 1)
            impulse.append(w[n] / (n + 1))
            work_n.append(_term(w, v_n[:-1]) / (n + 1))
            slid.append(_term(w, w) / (n + 1))
            w.append(_term(w, P) / (n + 1))
        return dict(zip(at._fields[1:], (b, w, v_n, p_e, p_2, impulse, work_n, slid), strict=True))

    def step(self, series: dict[str, list]) -> Any:
        """How far the series hold, to rounding: of what the whole impact adds up, where w only
        falls.
        """
        K, mu, w = self.K, self.mu, series["w"][0]
        self.most = max(self.most, w)
        share = min(self.share * (self.most / w if self.decays else 1), 1e-3)
        h = 20 / (mu * (K.ee + K.tt) + abs(K.ez))
        for field, first in (("b", 0), ("w", 0), ("work_n", 1), ("slid", 1)):
            a = series[field]
            size = abs(a[first]) + (
                abs(a[2]) * h if first else 0
            )  # the first term of work_n vanishes with v_n
            for n in (self.order - 1, self.order):
                if a[n]:
                    h = min(h, float(share * size / abs(a[n])) ** (1 / (n - first)))
        return h


def _term(a: list, b: list) -> Any:
    """The last Taylor coefficient of a product of series of the same length."""
    return sum(map(mul, a, b[::-1]))


def _sum(a: list, h: Any) -> Any:
    total = a[-1]
    for c in a[-2::-1]:
        total = total * h + c
    return total


def _root(a: list, value: Any, high: Any) -> Any:
    """Where the series a, which rises, reaches the value before `high`: Newton, halves where it
    leaves the bracket.
    """
    slope = [n * c for n, c in enumerate(a)][1:]
    low, h = 0 * high, high
    for _ in range(300):
        excess, rate = _sum(a, h) - value, _sum(slope, h)
        low, high = (h, high) if excess < 0 else (low, h)
        newer = h - excess / rate if rate > 0 else low
        if not low < newer < high:
            newer = (low + high) / 2 if excess else h
        if newer in (h, low, high):
            break
        h = newer
    return h


def _linear(at: _Moment, stage: _Stage, lift: Any, pull: Any, drag: Any) -> tuple[_Moment, bool]:
    """To the end of the stage, or of slip: v_n, w and p_e grow by `lift`, `pull` and `drag` per
    normal impulse.
    """
    rest = stage.value - getattr(at, stage.field)
    if stage.field == "v_n":
        p = rest / lift
    elif stage.field == "work_n":
        p = 2 * rest / (at.v_n + (at.v_n**2 + 2 * lift * rest) ** 0.5)
    else:
        p = rest
    stops = bool(pull < 0 and at.w < -pull * p)
    if stops:
        p = -at.w / pull
    after = at._replace(
        w=0 * at.w if stops else at.w + pull * p,
        v_n=at.v_n + lift * p,
        p_e=at.p_e + drag * p,
        impulse=at.impulse + p,
        work_n=at.work_n + p * (at.v_n + lift * p / 2),
        slid=at.slid + p * (at.w + pull * p / 2),
    )
    return (after, False) if stops else (after._replace(**{stage.field: stage.value}), True)
