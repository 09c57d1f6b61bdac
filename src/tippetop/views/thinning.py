"""Which samples a page keeps: those between which the interpolated attitude stays within a small angle of all others.

`attitude` is the interpolation of motion.js, written for arrays: the axis is a cubic through its samples with their
velocities, and the turn about it another.
"""

import numpy as np

from .samples import OMEGA, ORIENTATION, _third


WITHIN = np.radians(0.1)  # of attitude that leaving out a row may cost; rows themselves add what lies between them
FEW = 20_000  # samples that are kept whatever they are


def attitude(p: np.ndarray, wp: np.ndarray, q: np.ndarray, wq: np.ndarray, h: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Attitudes (n, 4) at the fraction s of intervals of length h, between p and q (n, 4) with the angular velocities
    wp and wq (n, 3)."""
    u, v = _third(p).T, _third(q).T
    du, dv = h[:, None] * np.cross(wp, u), h[:, None] * np.cross(wq, v)
    rest = _after(q, _inverse(_after(_swing(u, v), p)))
    some = 2 * np.arctan2((rest[:, 1:] * v).sum(axis=1), rest[:, 0])
    first, last = h * (wp * u).sum(axis=1), h * (wq * v).sum(axis=1)
    whole = some + 2 * np.pi * np.round(((first + last) / 2 - some) / (2 * np.pi))
    axis = _cubic(u, du, v, dv, s[:, None])
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    angle = _cubic(np.zeros_like(whole), first, whole, last, s) / 2
    turn = np.concatenate([np.cos(angle)[:, None], np.sin(angle)[:, None] * axis], axis=1)
    return _after(turn, _after(_swing(u, axis), p))


def apart(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """The angles (n,) by which attitudes differ [rad]."""
    difference = _after(p, _inverse(q))
    return 2 * np.arctan2(np.linalg.norm(difference[:, 1:], axis=1), np.abs(difference[:, 0]))


def kept(times: np.ndarray, samples: np.ndarray, enough: int = FEW) -> np.ndarray:
    """Indices of the samples to keep, ascending, the first and the last among them: all, where they are few; else every
    so manieth, and more where the attitude of the others asks for it."""
    n = len(times)
    if n <= enough:
        return np.arange(n)
    keep = np.unique(np.append(np.arange(0, n, max(2, n // enough)), n - 1))
    while True:
        wrong = missed(times, samples, keep) > WITHIN
        more = np.unique((keep[:-1][wrong] + keep[1:][wrong]) // 2)
        if not wrong.any():
            return keep
        keep = np.union1d(keep, more)


def missed(times: np.ndarray, samples: np.ndarray, keep: np.ndarray) -> np.ndarray:
    """The largest angle, in each interval between samples that are kept, by which the attitude of another is missed."""
    left_out = np.setdiff1d(np.arange(len(times)), keep, assume_unique=True)
    interval = np.searchsorted(keep, left_out) - 1
    a, b = keep[interval], keep[interval + 1]
    h = times[b] - times[a]
    ends = [samples[i][:, part] for i in (a, b) for part in (ORIENTATION, OMEGA)]
    between_ends = attitude(*ends, h, (times[left_out] - times[a]) / h)  # type: ignore[call-arg]
    worst = np.zeros(len(keep) - 1)
    np.maximum.at(worst, interval, apart(between_ends, samples[left_out][:, ORIENTATION]))
    return worst


def between(times: np.ndarray, samples: np.ndarray) -> float:
    """By how much the attitude between the rows themselves may be missed [rad]: an eighth of what is missed of every
    second row, if the others are kept; the cubics' error falls with the third power of the step or faster."""
    if len(times) < 5:
        return 0.0
    keep = np.unique(np.append(np.arange(0, len(times), 2), len(times) - 1))
    return float(missed(times, samples, keep).max()) / 8


def _cubic(a: np.ndarray, da: np.ndarray, b: np.ndarray, db: np.ndarray, s: np.ndarray) -> np.ndarray:
    r = 1 - s
    return r * r * (a * (1 + 2 * s) + da * s) + s * s * (b * (3 - 2 * s) - db * r)


def _after(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    w, x, y, z = a.T
    d, e, f, g = b.T
    return np.stack(
        [
            w * d - x * e - y * f - z * g,
            w * e + x * d + y * g - z * f,
            w * f - x * g + y * d + z * e,
            w * g + x * f - y * e + z * d,
        ],
        axis=1,
    )


def _inverse(q: np.ndarray) -> np.ndarray:
    return q * (1, -1, -1, -1)


def _swing(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """The smallest rotations that take unit vectors u to v."""
    q = np.concatenate([1 + (u * v).sum(axis=1)[:, None], np.cross(u, v)], axis=1)
    return q / np.linalg.norm(q, axis=1)[:, None]
