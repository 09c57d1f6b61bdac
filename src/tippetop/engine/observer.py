"""Follows Taylor steps: finds the events of every run and records what is kept of them.

Every number depends on the lane's own steps alone: not on its neighbours, nor on where slices end. What an event does
is data (`EventRows`): nothing here knows one kind from another.
"""

import numpy as np

from tippetop_kernels.jit import apart, entry, inlined, kernel
from tippetop_kernels.polynomials import crossings, extremes, ranges

from ..mechanics.events import AT_POLE, NEAR_POLE, ON_ZERO_FOR, hysteresis
from .status import Status
from .tallies import COUNT, HIGH, LAST, LEAST, LOW, MOST, ON_ZERO, SIGN, STEADY, T_LEAST, T_MOST


RUNNING, STALLED, SETTLED = Status.RUNNING.code, Status.STALLED.code, Status.SETTLED.code
TINY = 1e-10  # internal time: a step that leads nowhere
PATIENCE = 64  # tiny steps in a row that are a stall


@entry
def follow(times, tcs, rows, rules, tallies, log, scratch):
    """Takes in a slice of steps: times (n + 1, lanes), Taylor coefficients tcs (n, variables, order + 1, lanes).

    The tally of a run that ended says in which step and where in it: later ones are not looked at.
    """
    for i in range(len(tcs)):
        take_step(i, tcs[i], times[i], times[i + 1], rows, rules, tallies, log, scratch)


@inlined
def take_step(i, tc, start, stop, rows, rules, tallies, log, scratch):
    """Takes in a step of every lane, from `start` to `stop` (lanes,): the i-th of a slice."""
    events, known = rows.events, tallies.functions
    _factors(start, stop, scratch.factors, scratch.h)
    _bound(tc, events, scratch.factors, known, scratch.sums)
    _silence(events, known, scratch.quiet)
    for lane in range(len(start)):
        tally = tallies.lane[lane]
        if not stop[lane] > start[lane] or tally.status != RUNNING:
            continue
        upto = 1.0
        if not scratch.quiet[lane] >= 0:
            upto = _events(i, tc, start[lane], stop[lane], lane, rows, rules, tallies, log, scratch)
        beyond = rules.lasting >= 0 and rules.way * known[SIGN, rules.lasting, lane] > 0
        _step_made(tally, i, start[lane], stop[lane], upto, beyond, rules)


@kernel
def _events(i, tc, t, end, lane, rows, rules, tallies, log, scratch):
    """The events of a lane in a step; gives how far the step goes, 1 unless an event ends the run."""
    events, known, tally = rows.events, tallies.functions, tallies.lane[lane]
    h, upto = end - t, 1.0
    p, zeros, work = scratch.polynomial, scratch.zeros, scratch.work
    for e in range(len(events)):  # the first ending is the end of the step for all events
        event = events[e]
        if event.ends != 0 and not _keeps_sign(e, known, lane):
            _polynomial(tc, event, lane, scratch.factors, p)
            count, _ = crossings(p, known[SIGN, e, lane] > 0, zeros, work, known[STEADY, e, lane] > 0)
            upto = _ending(e, event, t, h, zeros, count, upto, tally, known, lane)
    for e in range(len(events)):
        event = events[e]
        keeps = not event.watched or _keeps_sign(e, known, lane)
        if keeps and (not event.ranged or _inside(e, known, lane)):
            continue
        _polynomial(tc, event, lane, scratch.factors, p)
        if not keeps:
            count, _ = crossings(p, known[SIGN, e, lane] > 0, zeros, work, known[STEADY, e, lane] > 0)
            for k in range(count):
                if zeros[k] > upto:
                    break
                _passage(i, tc, e, event, t, h, zeros[k], lane, rows, rules, tallies, log)
        if event.ranged:
            _extremes(e, p, t, h, upto, known, lane, scratch.nodes)
    return upto


# --- over all lanes ---------------------------------------------------------------------------------------------------


@inlined
def _factors(start, end, factors, h):
    """What turns Taylor coefficients in time into those in time over h: of variables, and of rates."""
    if len(start) == 1:
        factor, h[0] = 1.0, end[0] - start[0]
        for k in range(factors.shape[1]):
            factors[0, k, 0], factors[1, k, 0] = factor, (k + 1) * factor
            factor *= h[0]
        return
    for lane in range(len(start)):
        factors[0, 0, lane] = factors[1, 0, lane] = 1.0
        h[lane] = end[lane] - start[lane]
    for k in range(1, factors.shape[1]):
        _next_factors(k, factors[0, k - 1], h, factors[0, k], factors[1, k])


@apart
def _next_factors(k, before, h, of_variables, of_rates):
    for lane in range(len(h)):
        of_variables[lane] = before[lane] * h[lane]
        of_rates[lane] = (k + 1) * (before[lane] * h[lane])


@inlined
def _bound(tc, events, factors, known, sums):
    """Bounds of the event functions over a step, by sums of their coefficients, or by their rates."""
    for e in range(len(events)):
        event = events[e]
        if event.leader < 0 and event.bounded:
            low, high, steady = known[LOW, e], known[HIGH, e], known[STEADY, e]
            ranges(tc[event.row], event.shift, factors[event.shift], low, high, steady, sums)
            if event.offset != 0.0:
                for lane in range(len(low)):
                    low[lane] += event.offset
                    high[lane] += event.offset
    for e in range(len(events)):
        event = events[e]
        if event.leader >= 0 and event.bounded:
            rate = event.leader
            _led(
                tc[event.row, 0], event.offset, factors[0, 1], known[LOW, rate], known[HIGH, rate],
                known[LOW, e], known[HIGH, e], known[STEADY, e],
            )  # fmt: skip


@apart
def _led(start, offset, h, low, high, led_low, led_high, led_steady):
    """Bounds of a variable plus `offset` by those of its rate."""
    for lane in range(len(start)):
        led_low[lane] = start[lane] + offset + h[lane] * min(0.0, low[lane])
        led_high[lane] = start[lane] + offset + h[lane] * max(0.0, high[lane])
        led_steady[lane] = 1.0 if (low[lane] > 0) | (high[lane] < 0) else 0.0


@inlined
def _silence(events, known, quiet):
    """Not negative for lanes in whose step no function says anything new."""
    for lane in range(len(quiet)):
        quiet[lane] = 1.0
    for e in range(len(events)):
        if events[e].watched:
            _silent_signs(known[SIGN, e], known[LOW, e], known[HIGH, e], quiet)
        if events[e].ranged:
            _silent_ranges(known[LOW, e], known[HIGH, e], known[LEAST, e], known[MOST, e], quiet)


@apart
def _silent_signs(sign, low, high, quiet):
    """`_keeps_sign` in every lane."""
    for lane in range(len(quiet)):
        within = low[lane] if sign[lane] > 0 else -high[lane]
        quiet[lane] = quiet[lane] if within > 0 else -1.0


@apart
def _silent_ranges(low, high, least, most, quiet):
    """`_inside` in every lane."""
    for lane in range(len(quiet)):
        quiet[lane] = quiet[lane] if (low[lane] >= least[lane]) & (high[lane] <= most[lane]) else -1.0


@inlined
def _keeps_sign(e, known, lane):
    """Whether a function keeps its sign over a step."""
    return (known[LOW, e, lane] if known[SIGN, e, lane] > 0 else -known[HIGH, e, lane]) > 0


@inlined
def _inside(e, known, lane):
    """Whether a function stays within its extremes."""
    return known[LOW, e, lane] >= known[LEAST, e, lane] and known[HIGH, e, lane] <= known[MOST, e, lane]


# --- one lane ---------------------------------------------------------------------------------------------------------


@kernel
def _polynomial(tc, event, lane, factors, p):
    """The coefficients of an event function over a step, in time over h, into p."""
    size, row, shift = len(p), event.row, event.shift
    p[size - 1] = 0.0
    for k in range(size - shift):
        p[k] = tc[row, k + shift, lane] * factors[shift, k, lane]
    p[0] += event.offset


@kernel
def _of_start(e, event, when, known, lane):
    """Whether a zero is that of the start; a function that must not fall below zero is let through there too."""
    return known[ON_ZERO, e, lane] > 0 and when <= ON_ZERO_FOR and not event.extremes


@kernel
def _ending(e, event, t, h, zeros, count, upto, tally, known, lane):
    """Where the step ends, `upto` or before: at the first of the zeros by which this event ends the top."""
    sign = known[SIGN, e, lane]
    for k in range(count):
        sign = -sign
        if zeros[k] >= upto:
            break
        if event.direction * sign >= 0 and not _of_start(e, event, t + zeros[k] * h, known, lane):
            tally.status = event.ends
            return zeros[k]
    return upto


@kernel
def _passage(i, tc, e, event, t, h, x, lane, rows, rules, tallies, log):
    """A zero at x of a step: what the event keeps of it, and its line in the log."""
    numbers, axis, known, kept, tally = rows.numbers, rows.axis, tallies.functions, tallies.kept, tallies.lane[lane]
    when = t + x * h
    known[SIGN, e, lane] = sign = -known[SIGN, e, lane]
    if _of_start(e, event, when, known, lane):
        return
    if e == rules.lasting and rules.way * sign > 0:
        tally.lasts_since = when
    at_pole = False
    if event.sense != 0 and len(axis) > 0:
        theta, at_pole = _axis(tc, x * h, lane, axis)
        take_turning(tally, 0 if at_pole else int(event.sense * sign), theta)  # 0: it ends a swing, no more
    for m in range(event.first, event.last):
        number = numbers[m]
        if number.direction * sign < 0 or event.direction * sign < 0:
            continue
        if number.what == COUNT:
            kept[m, lane] += 1
        elif number.what == LAST or np.isnan(kept[m, lane]):
            kept[m, lane] = when
    if log.filled[0] < len(log.time) and event.direction * sign >= 0:
        at = log.filled[0]
        log.time[at], log.event[at], log.sign[at], log.at_pole[at], log.step[at] = when, e, sign, at_pole, i
        log.filled[0] += 1


@kernel
def _extremes(e, p, t, h, upto, known, lane, nodes):
    """Least and greatest value of a function and when, up to where the run ends. Changes p."""
    if upto < 1.0:
        power = 1.0
        for k in range(len(p)):
            p[k] *= power
            power *= upto
    known[LEAST, e, lane], known[MOST, e, lane], at_least, at_most = extremes(
        p, known[LEAST, e, lane], known[MOST, e, lane], nodes, known[STEADY, e, lane] > 0
    )
    if at_least >= 0:
        known[T_LEAST, e, lane] = t + at_least * upto * h
    if at_most >= 0:
        known[T_MOST, e, lane] = t + at_most * upto * h


@kernel
def take_turning(tally, sign, theta):
    """Takes in a turning of theta (sign +1 a minimum, -1 a maximum), or the end of the run (0)."""
    confirmed, waits = hysteresis(tally.waiting, tally.waits_at, sign, theta)
    if confirmed:
        at = tally.waits_at
        tally.turnings += 1
        tally.theta_min = at if np.isnan(tally.theta_min) else min(at, tally.theta_min)
        tally.theta_max = at if np.isnan(tally.theta_max) else max(at, tally.theta_max)
        tally.waiting = 0
    if waits:
        tally.waiting, tally.waits_at = sign, theta


@kernel
def _axis(tc, x, lane, axis):
    """theta at the time x of a step, and whether the axis passes through a pole there, rather than near it."""
    a, b, c, a_rate, b_rate = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(tc.shape[1] - 1, -1, -1):
        a_rate, b_rate = a_rate * x + a, b_rate * x + b
        a = a * x + tc[axis[0], k, lane]
        b = b * x + tc[axis[1], k, lane]
        c = c * x + tc[axis[2], k, lane]
    speed = a_rate * a_rate + b_rate * b_rate
    across = abs(a * b_rate - b * a_rate)  # closest approach times speed: it does not depend on how well x is known
    at_pole = across < AT_POLE * speed and a * a + b * b < NEAR_POLE * NEAR_POLE * speed
    return np.arctan2(np.sqrt(a * a + b * b), c), at_pole


@inlined
def _step_made(tally, i, t, end, upto, beyond, rules):
    """Counts a step, and ends a top that leads nowhere, or has settled: `beyond` the zero of its lasting event."""
    h = end - t
    tally.steps += 1
    tally.tiny = tally.tiny + 1 if h < TINY else 0
    if tally.status == RUNNING:
        if tally.steps >= rules.most_steps or tally.tiny >= PATIENCE:
            tally.status = STALLED
        elif beyond and t + h - tally.lasts_since > rules.settled_for and tally.lasts_since != tally.doubted:
            tally.status = SETTLED
    tally.t = t + upto * h if upto < 1.0 else end
    tally.step, tally.upto = i, upto
