/* The step loop of one run, or of many runs in the lanes of one integrator.

   A step, in all lanes (`loop_drive`):
     begin_step         the longest step that is allowed: up to the end of the run or phase
     step               a Taylor integrator, compiled elsewhere, writes state and coefficients
     advance_time       add the step to the time; take back a step that is not finite
     bound_functions    bound each event function over the step: most have no zero, and are done
     find_events        of one lane: isolate the zeros of the others on their polynomials; the first
                        zero of an event that ends the run or phase shortens what counts of the step
     log_passage        count a zero, keep its time, log it; extremes are found likewise
     write_rows         evaluate the polynomials at the times of rows within the step
   An event never changes a step: it is found on the coefficients after it.
   `loop_run` adds changes of phase for one run, `loop_pools` for many.

   The caller owns all memory and describes it in one structure. There is no global state and no
   allocation, and every number of a lane depends on the steps of that lane alone.

   Stored runs continue bit by bit, so sums are written in a fixed order, and the compiler must not
   change it (-ffp-contract=off, no -ffast-math).

   Loops over lanes write to local arrays first: the compiler then knows that they do not overlap
   with what is read, and uses vectors.

   Names: l, the arrays of one integrator (`Loop`); lane, a place in it, and top, the run there;
   slot, the number of that top, its index in all arrays of tops (0 for a single run); e, the number
   of an event, event its row, f its function; p, n, the ascending coefficients of a polynomial and
   their number, x its variable, the time since the start of the step over h; t, the internal time
   where a step of length h starts; high, low of a clock, a time in double length, high + low; j,
   the jumps of a system; c, a program of one of them, or the Taylor coefficients of a variable; r,
   the registers of the program. */

#include <stdbool.h>
#include <stdint.h>
#include <string.h>
#include <tgmath.h> /* of double and long double numbers */

/* The first argument if the second one is NaN. */
#define MIN(a, b) ((b) < (a) ? (b) : (a))
#define MAX(a, b) ((b) > (a) ? (b) : (a))

typedef double real;
typedef int64_t integer;

enum {
    DEPTH = 20,   /* halvings of an interval: two zeros within 1e-6 of a step are none */
    MOST_COEFFICIENTS = 64, /* of a polynomial, as in engine.loop; quadruple precision has 47 */
    WIDEST = 32,  /* lanes */
    NODES = 9,    /* points of a step: it covers about a radian, so no dip hides between them */
    TIMES = 4,    /* rows made together, in a vector of the processor */
    TOGETHER = 6, /* variables made together: each sum waits for its last addition */
    PATIENCE = 64 /* tiny steps in a row that are a stall */
};

/* Internal time of a step that goes nowhere. */
static const real TINY = 1e-10;

/* The longest step: its powers, up to the 25th, are doubles. At rest a series allows any step. */
static const real LONGEST = 1e12;

/* The last place of a zero in a step, over h: a zero at the very end of a step is a zero in this
   step, because 1 would mean that no event ends it (`Tally.upto`). */
static const real BEFORE_END = 1 - 0x1p-53;

/* --- structures of the caller: `tippetop.engine.loop` makes the same from named tuples, one for
   each group of fields; `filled`, `rows` and `states` there are named after their group here --- */

/* Codes of `engine.status.Status`. ENDED and those of events come in `Event.ends`. */
enum { FINISHED = 1, SETTLED = 4, NON_FINITE, STALLED, RUNNING = 9 };

/* The number that an event keeps of its passages: the time of the first or the last one, or their
   number. */
enum { FIRST, LAST, COUNT };

/* Effects of a passage on the turning of theta that waits to be counted. */
enum { CONFIRMS = 1, WAITS = 2 };

typedef void (*Step)(real *state, const real *pars, const real *time, real *h, real *tc,
                     void *tape);
typedef void (*Dense)(real *out, const real *tc, const real *h);

/* An event, as in `engine.tallies.EventRows`. */
typedef struct {
    integer row, shift;  /* its function: variable `row` (shift 0) or its rate (1), plus `offset` */
    integer direction;   /* of the sign changes that count: +1, -1, or 0 for both */
    integer ends;        /* the status of a run or phase that it ends; 0: it ends none */
    integer sense;       /* of theta, if it is a turning */
    integer first, last; /* the `numbers` that it keeps are first, ..., last - 1 */
    real scale, offset;
    bool lasting, extremes; /* see `mechanics.event.Event`; whether it has `extremes` */
    bool watched, ranged; /* whether its zeros are searched, and its extremes */
} Event;

/* A number that an event keeps: FIRST, LAST or COUNT, of passages in this direction; 0: in both. */
typedef struct {
    integer what, direction;
} Number;

/* The counters of a run, as `LANE_RECORD` in `engine.tallies`: a change of one is a change of both.
   Times are internal. */
typedef struct {
    integer status; /* a code of `engine.status.Status` */
    real t;         /* the time reached */
    integer steps;
    real upto;       /* how far the last step counts, over h: 1, or less at an event that ends it */
    integer tiny,    /* steps in a row that led nowhere */
        waiting;     /* sign of the turning that waits to be counted; 0: none waits */
    real waits_at;   /* theta there */
    integer turnings;
    real theta_min, theta_max, /* of the turnings; NaN: none yet */
        lasts_since; /* when the lasting event happened, while it lasts; 0: at the start; or NaN */
} Tally;

/* The state of an event function: its sign, +1 or -1; 1 if the run starts on a zero of it, -k if
   its first k Taylor coefficients vanish there; its bounds in the present step; its least and
   greatest values, in the scale of the coefficients, and their times (internal). As
   `FUNCTION_RECORD` in `engine.tallies`: a change of one is a change of both. */
typedef struct {
    real sign, on_zero, low, high, extremes[2], times[2];
} Function;

/* A row of the log: a zero of an event function, as `PASSAGE_RECORD` in `engine.tallies`. */
typedef struct {
    real time;    /* internal */
    integer event, sign, /* its number; +1 where the function rises, or -1 */
        phase, lane; /* `in_lane` of the top; its lane, from which `end_step` takes the state */
    bool at_pole; /* whether the axis passes through a pole there */
} Passage;

typedef struct {
    Step step;
    Dense dense;
    integer fused; /* whether `dense` rounds a product and the difference that takes it once */

    /* _Sizes */
    integer width; /* numbers from one state to the next in the log, the samples and the rows */
    integer variables, parameters, size, lanes, tops, events,
        axis, /* number of `axis_rows`: 3, or 0 in a form that does not integrate the axis */
        log_room, sample_room; /* rows; 0: none is written */

    /* Motion */
    real *state, *before, /* (variables, lanes): now, and where the present step began */
        *pars, *tc;       /* (parameters, lanes); (variables, size, lanes) Taylor coefficients */
    /* (lanes,), as all that follow: times, internal; the end of the run or phase, the longest next
       step, and the step: what `begin_step` allows, then what the integrator made. */
    real *high, *low, *start_high, *start_low, *end, *limit, *h;
    /* The top times phases plus the phase, -1 in an empty lane, or the phase of a single run; and
       the slot of the top. */
    integer *in_lane, *slots;
    integer *ended_by;   /* the event that ended the present step; -1: none */
    integer *steps_before; /* steps of a run before those of its tally */

    /* EventRows, Tallies, Log of passages, Log of samples */
    const Event *event_rows;
    const Number *numbers;
    const integer *axis_rows; /* (axis,) the variables ux, uy, uz */

    Tally *tallies; /* (tops,); that of a lane is at its slot, as all that is kept of its top */
    Function *functions; /* (events, tops), by slot */
    real *kept;          /* (numbers, tops), by slot: times, NaN if there was none; or counts */

    integer *logged;     /* (1,) the number of rows in the log */
    Passage *passages;   /* (log_room,) */
    real *logged_states; /* (log_room, width) */

    integer *sampled,      /* (1,) the number of samples */
        *sampled_tops;     /* (sample_room,) `in_lane` of each */
    real *sampled_states;  /* (sample_room, width) */

    real *factors, *out; /* (2, size, lanes); (variables, lanes) a state */
    void *tape;          /* where a step in compact mode works; others ignore it */

    /* Rules */
    real settled_for; /* internal time for which the lasting event must have lasted */
    integer most_steps, /* after which a run has stalled */
        sampled_every, sampled_first; /* a power of two; steps at the start, all sampled */
    real noise_floor, /* theta must come back from a turning by this angle [rad] */
        at_pole, near_pole, on_zero_for; /* see `mechanics.event` */
    integer settled_every; /* steps between two looks whether a run has settled */

    /* Rows */
    real *row_times, *row_states; /* (tops, row_count), and (..., width): a single run is one top */
    integer *row_phases, *rows_made; /* (tops, row_count) `in_lane`; (tops,) rows written */
    integer rows_at_steps, /* whether rows are the ends of steps, whose times are written here */
        row_count;         /* of one top; 0: no rows */
} Loop;

/* Copy n numbers that lie `stride` apart to others that lie `to_stride` apart. */
static void copy(integer n, const real *from, integer stride, real *to, integer to_stride) {
    for (integer i = 0; i < n; i++)
        to[i * to_stride] = from[i * stride];
}

/* --- polynomials on [0, 1], ascending coefficients --- */

/* p(x). */
static real value_at(const real *p, integer n, real x) {
    real sum = 0;
    for (integer k = n - 1; k >= 0; k--)
        sum = sum * x + p[k];
    return sum;
}

/* p(x), p'(x) and p''(x)/2. */
typedef struct {
    real value, slope, curve;
} Jet;

/* The `Jet` of n coefficients at x. Even and odd powers are separate sums, which the processor adds
   at the same time. */
static Jet jet(const real *p, integer n, real x) {
    real y = x * x;
    real even = 0, even1 = 0, even2 = 0, odd = 0, odd1 = 0, odd2 = 0; /* derivatives by y */
    for (integer k = (n - 1) / 2; k >= 0; k--) {
        even2 = even2 * y + even1;
        even1 = even1 * y + even;
        even = even * y + p[2 * k];
        odd2 = odd2 * y + odd1;
        odd1 = odd1 * y + odd;
        odd = odd * y + (2 * k + 1 < n ? p[2 * k + 1] : 0.0);
    }
    return (Jet){
        even + x * odd,
        2 * x * even1 + odd + 2 * y * odd1,
        even1 + 4 * y * even2 + x * (3 * odd1 + 4 * y * odd2),
    };
}

/* The zero of a monotone p on [0, 1], where it ends with the value `end`, by Newton's rule, kept
   between bounds. 0 if rounding hides the zero at the start: both ends then have one sign. p as for
   `jet`. */
static real zero_of(const real *p, integer n, real end) {
    real low = 0, high = 1, x = p[0] / (p[0] - end); /* on the chord */
    if ((p[0] > 0) == (end > 0))
        return low;
    for (int i = 0; i < 60; i++) {
        Jet f = jet(p, n, x);
        if (f.value == 0)
            return x;
        if ((f.value > 0) == (end > 0))
            high = x;
        else
            low = x;
        real before = x;
        x -= f.value / f.slope;
        if (!(low <= x && x <= high))
            x = 0.5 * (low + high);
        if (fabs(x - before) <= 1e-9) /* the next correction is its square */
            break;
    }
    return x;
}

/* The coefficients of p(start + length x). */
static void shift(const real *restrict p, integer n, real start, real length,
                  real *restrict shifted) {
    memcpy(shifted, p, n * sizeof(real));
    for (integer i = n - 2; start > 0 && i >= 0; i--)
        for (integer k = i; k < n - 1; k++) /* upwards: no term waits for the one before it */
            shifted[k] += start * shifted[k + 1];
    real power = 1;
    for (integer k = 1; k < n; k++) {
        power *= length;
        shifted[k] *= power;
    }
}

/* A lower bound of a cubic polynomial on [0, 1]: the least of its Bernstein coefficients. */
static real least(real p0, real p1, real p2, real p3) {
    real first = MIN(p0, p0 + p1 / 3), last = MIN(p0 + (2 * p1 + p2) / 3, p0 + p1 + p2 + p3);
    return MIN(first, last);
}

/* Write the sign changes of p on [0, 1) to `zeros` (n,), ascending, and return their number.
   `positive` is the sign at the end of the last step: a zero that rounding puts between two steps
   counts once. Signs alternate from it: `find_events` and `log_passage` turn them at each zero. */
integer loop_crossings(const real *p, integer n, bool positive, real *zeros) {
    real part[MOST_COEFFICIENTS] = {0}, total = 0;
    for (integer k = 0; k < n; k++)
        total += fabs(p[k]);
    if (total == 0 || !isfinite((real)(n * n) * total)) /* no interval would ever be decided */
        return 0;
    integer count = 0, at = 0, level = 0; /* the interval [at, at + 1]/2^level */
    for (;;) {
        real length = ldexp(1, (int)-level), start = (real)at * length;
        shift(p, n, start, length, part);
        real rest = fabs(part[4]), bend = 0;
        for (integer k = n - 1; k > 4; k--) {
            real size = fabs(part[k]);
            rest += size;
            bend += (real)k * size;
        }
        real p0 = part[0], p1 = part[1], p2 = 2 * part[2], p3 = 3 * part[3], p4 = 4 * part[4];
        bool monotone = least(p1, p2, p3, p4) > bend || least(-p1, -p2, -p3, -p4) > bend;
        bool no_zero = fabs(p0) > fabs(p1) + fabs(p2) / 2 + fabs(p3) / 3 + rest;
        if (!no_zero && !monotone && level < DEPTH) {
            at *= 2;
            level++;
            continue;
        }
        real end = value_at(part, n, 1);
        if ((end > 0) != positive && count < n)
            zeros[count++] = fmin(start + zero_of(part, n, end) * length, BEFORE_END);
        positive = end > 0;
        at++;
        while (at % 2 == 0 && level > 0) { /* up to the next interval */
            at /= 2;
            level--;
        }
        if (level == 0)
            return count;
    }
}

/* Extend `values`, the least and the greatest value so far, by those of p on [0, 1]: Newton's rule
   on the slope from the least and the greatest of some points. Write to `places` (2,) where in the
   step they are, NaN for a value that is the old one. */
void loop_extremes(const real *p, integer n, real *values, real *places) {
    real points[NODES] = {0};
    for (integer k = n - 1; k >= 0; k--)
        for (int i = 0; i < NODES; i++)
            points[i] = points[i] * ((real)i / (NODES - 1)) + p[k];
    for (int side = 0; side < 2; side++) {
        real sign = side ? -1 : 1, before = -1;
        int first = 0;
        for (int i = 1; i < NODES; i++)
            first = sign * points[i] < sign * points[first] ? i : first;
        real x = (real)first / (NODES - 1);
        places[side] = NAN;
        for (int i = 0; i < 7 && fabs(x - before) > 1e-9; i++) {
            Jet f = jet(p, n, x);
            if (sign * f.value < sign * values[side]) {
                values[side] = f.value;
                places[side] = x;
            }
            /* Four times the drop to the vertex of a parabola: where even that reaches no new
               extreme, none is near. */
            real drop = f.slope * f.slope / (sign * f.curve);
            if (!(drop > 0 && sign * f.value - drop < sign * values[side]))
                break;
            before = x;
            x -= f.slope / (2 * f.curve);
            x = MAX(0.0, x);
            x = MIN(1.0, x);
        }
    }
}

/* --- bounds of the event functions over a step, in all lanes --- */

/* The counters of the top in a lane. */
static Tally *tally_of(const Loop *l, integer lane) {
    return l->tallies + l->slots[lane];
}

/* The state of an event function of the top in a lane: `functions` is (events, tops), by slot. */
static Function *function(const Loop *l, integer event, integer lane) {
    return l->functions + event * l->tops + l->slots[lane];
}

/* Bound the event functions that count over the step: by bounds of the cubic part, plus or minus
   the sum of the other coefficients. It also writes `factors`, which `search` needs: the powers of
   h that convert coefficients to time over h. */
static void bound_functions(const Loop *l) {
    integer n = l->lanes, size = l->size;
    real h[WIDEST], power[WIDEST], rest[WIDEST], low[WIDEST], high[WIDEST];
    for (integer i = 0; i < n; i++) {
        h[i] = l->high[i] - l->start_high[i];
        power[i] = 1;
    }
    for (integer k = 0; k < size; k++) /* from time to time over h: of variables, then of rates */
        for (integer i = 0; i < n; i++) {
            l->factors[k * n + i] = power[i];
            l->factors[(size + k) * n + i] = (real)(k + 1) * power[i];
            power[i] *= h[i];
        }
    for (integer e = 0; e < l->events; e++) {
        const Event *event = l->event_rows + e;
        if (!event->watched && !event->ranged && event->ends == 0)
            continue;
        /* Coefficients from number `shift` on, with row `shift` of `factors`: of the variable or of
           its rate. As in `search`; a change of one is a change of both. */
        const real *c = l->tc + (event->row * size + event->shift) * n;
        const real *factor = l->factors + event->shift * size * n;
        for (integer i = 0; i < n; i++)
            rest[i] = 0;
        for (integer k = 4; k < size - event->shift; k++)
            for (integer i = 0; i < n; i++)
                rest[i] += fabs(c[k * n + i] * factor[k * n + i]);
        for (integer i = 0; i < n; i++) {
            real p0 = c[i] + event->offset, p1 = c[n + i] * factor[n + i];
            real p2 = c[2 * n + i] * factor[2 * n + i], p3 = c[3 * n + i] * factor[3 * n + i];
            low[i] = least(p0, p1, p2, p3) - rest[i];
            high[i] = rest[i] - least(-p0, -p1, -p2, -p3);
        }
        for (integer i = 0; i < n; i++) {
            Function *f = function(l, e, i);
            f->low = low[i];
            f->high = high[i];
        }
    }
}

/* --- the events of one lane --- */

/* The multiplicity of the zero of an event function where the first step of a phase begins; 0 in
   later steps.

   A jump leads exactly to such a zero: a flight begins with gap = gap' = 0. The first coefficients
   of the function are then rounding errors, and their signs would be found as an event there: the
   liftoff would be its own landing. They are dropped, which divides the polynomial by x^k: this
   root is gone, and all other zeros in the step remain. */
static integer roots(const Tally *tally, const Function *f) {
    return tally->steps == 0 && f->on_zero < 0 ? -(integer)f->on_zero : 0;
}

/* Whether the bounds of a function show that it has no zero in the step. */
static bool keeps_sign(const Tally *tally, const Function *f) {
    return roots(tally, f) == 0 && (f->sign > 0 ? f->low : -f->high) > 0;
}

/* Write the coefficients of an event function over a step, in time over h, to `p`, which extremes
   use as well, and its sign changes to `zeros`. Return the number of zeros. */
static integer search(const Loop *l, integer e, integer lane, real *p, real *zeros) {
    const Event *event = l->event_rows + e;
    const Function *f = function(l, e, lane);
    integer size = l->size, lanes = l->lanes, shift = event->shift;
    const real *c = l->tc + (event->row * size + shift) * lanes + lane;
    const real *factors = l->factors + shift * size * lanes + lane;
    p[size - 1] = 0; /* a rate has one coefficient less */
    for (integer k = 0; k < size - shift; k++)
        p[k] = c[k * lanes] * factors[k * lanes];
    p[0] += event->offset;
    const Tally *tally = tally_of(l, lane);
    if (!event->watched || keeps_sign(tally, f))
        return 0;
    integer k = roots(tally, f);
    return loop_crossings(p + k, size - k, f->sign > 0, zeros);
}

/* Whether a zero at the internal time `when` is that on which the run starts, which is no event. A
   function with extremes (a force, which must not fall below zero) has none: its zero counts. */
static bool of_start(const Loop *l, const Event *event, const Function *f, real when) {
    return f->on_zero > 0 && when <= l->on_zero_for && !event->extremes;
}

/* Count a turning of theta (sign +1: a minimum, -1: a maximum) once theta has come back from it by
   the noise floor; the end of a run (0) confirms the turning that waits. Return CONFIRMS if the
   turning that waited counts, plus WAITS if this one waits now: small wiggles between do not
   matter, so a true turning that rounding splits into three counts once, and a decay that ends in
   noise not at all. */
static integer count_turning(Tally *tally, real noise_floor, integer sign, real theta) {
    real back = theta - tally->waits_at;
    bool confirmed = tally->waiting != 0 && (real)tally->waiting * back >= noise_floor;
    bool further = sign == tally->waiting && (real)sign * back < 0;
    bool waits = sign != 0 && (confirmed || tally->waiting == 0 || further);
    if (confirmed) {
        real at = tally->waits_at;
        tally->turnings++;
        tally->theta_min = MIN(at, tally->theta_min);
        tally->theta_max = MAX(at, tally->theta_max);
        tally->waiting = 0;
    }
    if (waits) {
        tally->waiting = sign;
        tally->waits_at = theta;
    }
    return (confirmed ? CONFIRMS : 0) + (waits ? WAITS : 0);
}

/* theta of an axis (ux, uy, uz) of any length. */
static real theta_of(const real *axis) {
    return atan2(sqrt(axis[0] * axis[0] + axis[1] * axis[1]), axis[2]);
}

/* theta at the time x after the start of a step (here not over h), and whether the axis passes
   through a pole there, rather than near it. */
static real theta_at(const Loop *l, real x, integer lane, bool *at_pole) {
    integer size = l->size, lanes = l->lanes;
    real u[3] = {0}, rate[3] = {0};
    for (integer k = size - 1; k >= 0; k--)
        for (int i = 0; i < 3; i++) {
            rate[i] = rate[i] * x + u[i];
            u[i] = u[i] * x + l->tc[(l->axis_rows[i] * size + k) * lanes + lane];
        }
    /* `speed` is the square of the speed; `across`, the closest approach times the speed, however
       well x is known. */
    real speed = rate[0] * rate[0] + rate[1] * rate[1], near = l->near_pole;
    real across = fabs(u[0] * rate[1] - u[1] * rate[0]);
    /* `at_pole` and `near_pole` are times, so they bound distances over the speed. */
    *at_pole =
        across < l->at_pole * speed && u[0] * u[0] + u[1] * u[1] < near * near * speed;
    return theta_of(u);
}

/* Keep the numbers of an event of the top in a slot, and append it to the log, if there is one. Its
   state is written by `end_step`, or by the caller of `loop_note`. */
static void keep(const Loop *l, const Event *event, integer slot, const Passage *row) {
    for (integer m = event->first; m < event->last; m++) {
        const Number *number = l->numbers + m;
        real *kept = l->kept + m * l->tops + slot;
        if (number->direction * row->sign < 0) /* a direction of 0 takes both */
            continue;
        if (number->what == COUNT)
            *kept += 1;
        else if (number->what == LAST || isnan(*kept))
            *kept = row->time;
    }
    if (l->logged[0] < l->log_room)
        l->passages[l->logged[0]++] = *row;
}

/* Whether turnings are counted here: in lanes, and without a log. `runs.event_log` counts those of
   one lane with a log, which is a single run; `HybridPools.notes` has one lane and no log. Without
   the axis (`axis` 0) there is no theta. */
static bool counts_turnings(const Loop *l, const Event *event) {
    return event->sense != 0 && l->axis > 0 && (l->log_room == 0 || l->lanes > 1);
}

/* Note event number `e` of the top in a slot, which no step has found, in a state. `note_change`
   and `HybridDriver._note` call it, and write the state to the log themselves. */
void loop_note(const Loop *l, const Event *event, integer e, integer slot, integer sign,
               integer phase, real when, const real *state) {
    Tally *tally = l->tallies + slot;
    const integer *rows = l->axis_rows;
    if (event->lasting) /* unlike in `log_passage`, for any sign */
        tally->lasts_since = when;
    if (counts_turnings(l, event)) {
        real axis[] = {state[rows[0]], state[rows[1]], state[rows[2]]};
        count_turning(tally, l->noise_floor, event->sense * sign, theta_of(axis));
    }
    keep(l, event, slot, &(Passage){when, e, sign, phase, 0, false});
}

/* Keep the numbers of an event at its zero, the time x of a step, and log it. */
static void log_passage(const Loop *l, integer e, integer lane, real t, real h, real x) {
    const Event *event = l->event_rows + e;
    Tally *tally = tally_of(l, lane);
    Function *f = function(l, e, lane);
    /* Zeros in a step alternate, see `loop_crossings`, so each one changes the sign. */
    real when = t + x * h, sign = f->sign = -f->sign;
    if (event->lasting)
        tally->lasts_since = (real)event->direction * sign > 0 ? when : NAN;
    if (of_start(l, event, f, when))
        return;
    bool at_pole = false;
    if (event->sense != 0 && l->axis > 0) {
        real theta = theta_at(l, x * h, lane, &at_pole);
        integer turn = at_pole ? 0 : (integer)((real)event->sense * sign); /* 0 ends a swing */
        if (counts_turnings(l, event))
            count_turning(tally, l->noise_floor, turn, theta);
    }
    Passage row = {when, e, (integer)sign, l->in_lane[lane], lane, at_pole};
    if ((real)event->direction * sign >= 0)
        keep(l, event, l->slots[lane], &row);
}

/* Find the events of a lane in a step. Return how far the step goes: 1 unless an event ends the
   run. Extremes are those up to there. */
static real find_events(const Loop *l, integer lane, real t, real h) {
    integer size = l->size, events = l->events, ending = -1;
    Tally *tally = tally_of(l, lane);
    real upto = 1, p[MOST_COEFFICIENTS], zeros[MOST_COEFFICIENTS];

    for (integer e = 0; e < l->events; e++) { /* first: all events end with the step */
        const Event *event = l->event_rows + e;
        const Function *f = function(l, e, lane);
        if (event->ends == 0 || keeps_sign(tally, f))
            continue;
        real sign = f->sign;
        integer count = search(l, e, lane, p, zeros);
        for (integer k = 0; k < count && zeros[k] < upto; k++) {
            sign = -sign;
            if ((real)event->direction * sign >= 0 && !of_start(l, event, f, t + zeros[k] * h)) {
                tally->status = event->ends;
                upto = zeros[k];
                ending = e;
            }
        }
    }

    l->ended_by[lane] = ending;
    /* The event that ends the run or phase is logged last: callers read the end from the last
       passage. Another one at the same time is left to the next phase. */
    for (integer i = 1; i <= events; i++) {
        integer e = (ending + i) % events;
        const Event *event = l->event_rows + e;
        Function *f = function(l, e, lane);
        bool keeps_range = f->low >= f->extremes[0] && f->high <= f->extremes[1];
        if ((!event->watched || keeps_sign(tally, f)) && (!event->ranged || keeps_range))
            continue;
        integer count = search(l, e, lane, p, zeros);
        /* At `upto` itself only the event that ends the run counts: the next phase finds others. */
        bool ends = event->ends != 0 && e != ending;
        for (integer k = 0; k < count && (ends ? zeros[k] < upto : zeros[k] <= upto); k++)
            log_passage(l, e, lane, t, h, zeros[k]);
        if (!event->ranged)
            continue;
        real power = 1; /* `loop_extremes` takes p on [0, 1]: the part of the step that counts */
        for (integer k = 0; upto < 1 && k < size; k++) {
            p[k] *= power;
            power *= upto;
        }
        real places[2];
        loop_extremes(p, size, f->extremes, places);
        for (int side = 0; side < 2; side++)
            if (places[side] >= 0) /* not NaN */
                f->times[side] = t + places[side] * upto * h;
    }
    return upto;
}

/* --- rows at given times --- */

/* Write the variables of a lane at an internal time within its present step to `out` (variables,
   lanes). The other lanes get theirs at their `limit`, so only this lane counts. It overwrites
   `limit`, which nothing may need after `finish_step`. */
static void state_at(const Loop *l, integer lane, real time, real *out) {
    l->limit[lane] = (time - l->start_high[lane]) - l->start_low[lane];
    l->dense(out, l->tc, l->limit);
}

/* A step that fuses was compiled for this processor, which therefore can do it. */
#ifdef __x86_64__
#define FUSES __attribute__((target("fma")))
#else
#define FUSES
#endif

typedef real Vector __attribute__((vector_size(TIMES * sizeof(real))));

/* Write TIMES rows of the present step of the only lane, from row `at` on. (A top that is alone has
   slot 0, where its rows begin.) The sums are compensated; their bits are those of the dense output
   of a compiled step that fuses: a change of an operation here changes stored rows. The last group
   overlaps the one before it, so there are at least TOGETHER variables. */
FUSES static void sum_rows(const Loop *l, integer at) {
    integer size = l->size, n = l->variables;
    for (integer group = 0; group < n; group += TOGETHER) {
        integer first = MIN(group, n - TOGETHER);
        const real *c = l->tc + first * size;
        Vector sums[TOGETHER], rests[TOGETHER], h, power, zero = {0};
        for (int t = 0; t < TIMES; t++)
            h[t] = (l->row_times[at + t] - l->start_high[0]) - l->start_low[0];
        power = h;
        for (int i = 0; i < TOGETHER; i++) {
            sums[i] = zero + c[i * size];
            rests[i] = zero;
        }
        for (integer k = 1; k < size; k++) {
            for (int i = 0; i < TOGETHER; i++) {
                Vector more = -rests[i];
                for (int t = 0; t < TIMES; t++)
                    more[t] = fma(c[i * size + k], power[t], more[t]);
                Vector sum = sums[i] + more;
                rests[i] = (sum - sums[i]) - more;
                sums[i] = sum;
            }
            power *= h;
        }
        for (int i = 0; i < TOGETHER; i++)
            for (int t = 0; t < TIMES; t++)
                l->row_states[(at + t) * l->width + first + i] = sums[i][t];
    }
}

/* Whether a top has a row before an internal time that is not written yet. */
static bool is_row_before(const Loop *l, integer top, real time) {
    integer count = l->row_count;
    return count > 0 && l->rows_made[top] < count &&
           l->row_times[top * count + l->rows_made[top]] < time;
}

/* Write the rows of a lane that lie in its present step. Return whether all rows of its top are
   written. `moved` is false before the first step of a call: the row at the start of the call was
   written by the call before. A row at the end of a step belongs to the next step; at the end of a
   run or phase, to this one. */
static bool write_rows(const Loop *l, integer lane, bool moved) {
    const Tally *tally = tally_of(l, lane);
    integer count = l->row_count, n = l->lanes, in_lane = l->in_lane[lane];
    if (count == 0 || in_lane < 0)
        return false;
    integer top = l->slots[lane];
    integer *made = l->rows_made + top, *phases = l->row_phases + top * count, end = *made;
    real *times = l->row_times + top * count, *states = l->row_states + top * count * l->width;
    bool is_good = tally->status != NON_FINITE;
    if (l->rows_at_steps && moved && tally->upto == 1 && is_good) {
        times[*made] = l->high[lane];
        copy(l->variables, l->state + lane, n, states + *made * l->width, 1);
        phases[(*made)++] = in_lane;
    }
    if (!l->rows_at_steps && tally->steps > 0 && is_good) {
        bool runs = tally->status == RUNNING;
        for (; end < count; end++) {
            if (runs ? times[end] >= tally->t : times[end] > tally->t)
                break;
            phases[end] = in_lane;
        }
        bool fuses = l->fused && n == 1 && l->variables >= TOGETHER;
        for (; fuses && *made + TIMES <= end; *made += TIMES)
            sum_rows(l, *made);
        for (; *made < end; ++*made) { /* a stepper in Python sees which row it makes */
            state_at(l, lane, times[*made], l->out);
            copy(l->variables, l->out + lane, n, states + *made * l->width, 1);
        }
    }
    return *made == count;
}

/* --- steps --- */

/* Set `limit` to the longest next step of each lane, up to the end of its run or phase, and `h` to
   the same, at most LONGEST; both are 0 in a lane that has ended. `finish_step` takes a step of the
   length `limit` for the last one. */
static void begin_step(const Loop *l) {
    memcpy(l->before, l->state, l->variables * l->lanes * sizeof(real));
    for (integer lane = 0; lane < l->lanes; lane++) {
        bool runs = tally_of(l, lane)->status == RUNNING;
        l->start_high[lane] = l->high[lane];
        l->start_low[lane] = l->low[lane];
        l->limit[lane] = runs ? (l->end[lane] - l->high[lane]) - l->low[lane] : 0;
        l->h[lane] = MIN(l->limit[lane], LONGEST);
    }
}

/* Add the step to the time, in double length. A step that is not finite, or leads to such a state,
   is taken back, and ends the run. `h` stays as it is: `finish_step` compares it with `limit`, in
   lanes that are still RUNNING. */
static void advance_time(const Loop *l) {
    integer n = l->lanes, variables = l->variables;
    /* 0, otherwise NaN: a sum of products with 0, which has no branch for each number. */
    real finite[WIDEST];
    for (integer lane = 0; lane < n; lane++)
        finite[lane] = 0.0 * l->h[lane];
    for (integer i = 0; i < variables; i++)
        for (integer lane = 0; lane < n; lane++)
            finite[lane] += 0.0 * l->state[i * n + lane];
    for (integer lane = 0; lane < n; lane++) {
        real a = l->high[lane], b = l->h[lane], sum = a + b, part = sum - a;
        real rest = l->low[lane] + ((a - (sum - part)) + (b - part));
        if (finite[lane] == 0) {
            l->high[lane] = sum + rest;
            l->low[lane] = rest - (l->high[lane] - sum);
        } else {
            /* The time is unchanged, and `begin_step` has saved the state in `before`. */
            tally_of(l, lane)->status = NON_FINITE;
            copy(variables, l->before + lane, n, l->state + lane, n);
        }
    }
}

/* Whether a run that has made so many steps may have settled. The caller decides: it computes
   whether the top stays so (`ensembles.lanes`). */
static bool has_settled(const Loop *l, const Tally *tally, integer steps, real when) {
    return when - tally->lasts_since > l->settled_for && steps % l->settled_every == 0;
}

/* Find what happens in the step of a lane, and sample its end. End a run that goes nowhere, has
   settled, or is at its end. Return whether the run has ended. */
static bool finish_step(const Loop *l, integer lane) {
    Tally *tally = tally_of(l, lane);
    real t = l->start_high[lane], h = l->high[lane] - t;
    if (!(l->limit[lane] > 0)) /* the lane had ended before the step */
        return false;
    if (tally->status != RUNNING) /* it is not finite */
        return true;
    tally->tiny = h < TINY ? tally->tiny + 1 : 0;
    integer every_step = l->steps_before[lane] + tally->steps + (h > 0);
    if (h > 0) { /* the step moves a double */
        real upto = find_events(l, lane, t, h);
        tally->upto = upto;
        tally->t = upto < 1 ? t + upto * h : l->high[lane];
        tally->steps++;
        bool at_start = tally->steps <= l->sampled_first;
        /* A power of two, so the mask is the remainder. */
        bool sampled = at_start || (every_step & (l->sampled_every - 1)) == 0;
        if (l->sample_room > 0 && upto == 1 && sampled) {
            integer at = l->sampled[0]++;
            l->sampled_tops[at] = l->in_lane[lane];
            copy(l->variables, l->state + lane, l->lanes, l->sampled_states + at * l->width, 1);
        }
    }
    if (tally->status != RUNNING)
        return true;
    if (tally->steps >= l->most_steps || tally->tiny >= PATIENCE)
        tally->status = STALLED;
    else if (l->h[lane] == l->limit[lane]) { /* the integrator made the longest step allowed */
        tally->status = FINISHED;
        tally->t = l->end[lane]; /* exactly: the sum of the steps is rounded */
    } else if (has_settled(l, tally, every_step, t + h))
        tally->status = SETTLED;
    return tally->status != RUNNING;
}

/* --- the loop --- */

/* Whether the log or the samples may have no room for those of the next step: each coefficient of
   each function may give a zero, and each lane a sample. `Driver.allocate_tallies` and `PoolOfOne`
   make more room than that. */
static bool is_full(const Loop *l) {
    return (l->log_room > 0 && l->logged[0] + l->events * l->size * l->lanes > l->log_room) ||
           (l->sample_room > 0 && l->sampled[0] + l->lanes > l->sample_room);
}

/* Put the events of a step, from number `first` of the log on, in the order of their times. Equal
   times keep their order, so that the event that ends a run stays the last one. */
static void sort_log(const Loop *l, integer first) {
    for (integer k = first + 1; k < l->logged[0]; k++) {
        Passage row = l->passages[k];
        integer at = k;
        for (; at > first && l->passages[at - 1].time > row.time; at--)
            l->passages[at] = l->passages[at - 1];
        l->passages[at] = row;
    }
}

/* Add the step that was made, in all lanes, to times, tallies and the log. Return whether a run has
   ended. */
static bool end_step(const Loop *l) {
    integer first = l->logged[0];
    bool ended = false;
    advance_time(l);
    bound_functions(l);
    for (integer lane = 0; lane < l->lanes; lane++)
        ended = finish_step(l, lane) || ended;
    sort_log(l, first);
    for (integer k = first; k < l->logged[0]; k++)
    {
        integer lane = l->passages[k].lane;
        state_at(l, lane, l->passages[k].time, l->out);
        copy(l->variables, l->out + lane, l->lanes, l->logged_states + k * l->width, 1);
    }
    return ended;
}

/* Make at most `most` steps of all lanes, until the caller must look: a run has ended, all rows of
   a single run are written, or there is no room. Return the number of steps. */
integer loop_drive(const Loop *l, integer most) {
    /* The integrator keeps vectors on the stack: lanes are slower where it is not aligned. */
    _Alignas(64) volatile bool runs = false;
    for (integer lane = 0; lane < l->lanes; lane++)
        runs = runs || tally_of(l, lane)->status == RUNNING;
    for (integer steps = 0;; steps++) {
        bool stops = !runs || is_full(l) || steps >= most;
        for (integer lane = 0; lane < l->lanes; lane++)
            stops = (write_rows(l, lane, steps > 0) && l->lanes == 1) || stops;
        if (stops)
            return steps;
        begin_step(l);
        l->step(l->state, l->pars, l->start_high, l->h, l->tc, l->tape);
        runs = !end_step(l);
    }
}

/* --- changes of phase, by programs of jumps --- */

/* Write the register after those of the lines before: an operation on registers a and b. */
typedef struct {
    integer what, a, b;
} Line;

/* The operations of arithmetic, in the order of `mechanics.lines.OPERATIONS`, and their results, of
   a and b; UNIT needs an int `exponent`. A jump by Python must have the same bits. */
#define ARITHMETIC(X)            \
    X(ADD, a + b)                \
    X(SUBTRACT, a - b)           \
    X(MULTIPLY, a * b)           \
    X(DIVIDE, a / b)             \
    X(POWER, pow(a, b))          \
    X(NEGATIVE, -a)              \
    X(SQRT, sqrt(a))             \
    X(ABSOLUTE, fabs(a))         \
    X(MAXIMUM, MAX(a, b))        \
    X(EXP, exp(a))               \
    X(LOG, log(a))               \
    X(ARCTAN2, atan2(a, b))      \
    X(SIN, sin(a))               \
    X(COS, cos(a))               \
    X(LESS, a < b)               \
    X(LESS_EQUAL, a <= b)        \
    X(EQUAL, a == b)             \
    X(UNIT, (frexp(a, &exponent), ldexp(1, exponent)))

#define NAME(operation, result) operation,
#define WRITE(operation, result) case operation: *to = result; break;
#define WRITE_COLUMNS(operation, result)                                         \
    case operation:                                                              \
        for (integer i = 0; i < n; i++) { a = x[i]; b = y[i]; to[i] = result; }  \
        break;

/* A program ends where a comparison is not as expected. MOTION follows that of loop b; its inputs
   begin at register a, and its results are this and the following lines. */
enum { ARITHMETIC(NAME) EXPECT, MOTION, RESULT };

/* The program of a jump, which all runs share. Registers begin with the inputs: the numbers of the
   body, the time and the time left, the signs of event functions and the state. Constants and the
   results of lines follow. From `out` on they are what phase `next` begins with (see
   `begin_functions`), after the event functions in the time that the change takes; from `after` on,
   the time that the phase lasts, that time, and the numbers of tables. */
typedef struct Program {
    const Line *lines;
    const real *constants;
    const integer *events; /* that it logs, that happen in it, and whose extremes may be in it */
    const struct Program *other; /* to be tried next, if a comparison is not as expected */
    integer length, result, out, after, next, number, logged, passed, ranged;
} Program;

/* Points of time in a change at which event functions are known, its ends included, as in
   `engine.jump_programs.jump_times`. */
enum { JUMP_PARTS = 8, POINTS = JUMP_PARTS + 1 };

/* Jumps of the tops of a system. */
typedef struct {
    const Loop *const *loops;     /* of phases, then of motions; NULL where none is compiled */
    /* (phases + 1, events + 1): the last column by the clock, the last row of the start; or none */
    const Program *const *programs;
    const Event *events;
    real *registers; /* of the program that is executed */
    /* (changes, width) of a run: time, event, number of the program, its registers from `after` on;
       NULL in pools. `JumpPrograms.drive` reads it. */
    real *made;
    real chatter; /* the shortest phase, over its start or 1, as `CHATTER` of `jump_programs` */
    integer length, width, numbers; /* changes made; their numbers; those of a body */
} Jumps;

/* A top: its clock, the ends of the run, of the phase and of the next steps, and the start of the
   phase, internal; the event at the end of the next steps; the phase, and the event that ended it,
   or BY_STALL or NO_EXIT; steps before those of its tally; phases in a row that were too short. As
   `TOP_RECORD` of `engine.jump_programs`: a change of one is a change of both. */
typedef struct {
    real high, low, end, until, stop, began;
    integer stops_by, phase, event, steps, short_phases;
    real *state;      /* of a top that is in no lane */
    const real *body; /* (Jumps.numbers,) of its body and contact */
} Top;

/* How a phase ends that no event ends: by a stall; or the run ends, or goes on. */
enum { BY_STALL = -1, NO_EXIT = -2 };

/* Begin a phase or a motion: set signs and zeros of its event functions, which are at `start`, and
   the counts of steps to 0. Return the place of its state, which follows them. */
static const real *begin_functions(const Loop *l, integer lane, const real *start) {
    Tally *tally = tally_of(l, lane);
    integer events = l->events;
    for (integer e = 0; e < events; e++) {
        function(l, e, lane)->sign = start[e];
        function(l, e, lane)->on_zero = start[events + e];
    }
    tally->steps = tally->tiny = 0;
    return start + 2 * events;
}

/* Begin steps in a lane at a time (high + low) in a state, up to `end`. The counts are those that
   `begin_functions` has set, or of a top that continues. */
static void begin_lane(const Loop *l, integer lane, real high, real low, real end,
                       const real *state) {
    Tally *tally = tally_of(l, lane);
    copy(l->variables, state, 1, l->state + lane, l->lanes);
    l->high[lane] = high;
    l->low[lane] = low;
    l->end[lane] = end;
    tally->status = end > high ? RUNNING : FINISHED;
    tally->upto = 1;
    tally->t = high;
}

/* Follow a motion to its end or to an event. Its inputs are its end, the most steps, signs and
   zeros of its event functions, state and parameters; its results: status, steps, event, state.
   They are those of `ImpactMotions.piece`, in its order; a change of one is a change of both. */
static void follow_motion(const Loop *l, const real *in, real *results) {
    const Tally *tally = l->tallies;
    const real *state = begin_functions(l, 0, in + 2);
    begin_lane(l, 0, 0, 0, in[0], state);
    copy(l->parameters, state + l->variables, 1, l->pars, 1);
    /* emptied, as only the last passage is read */
    l->logged[0] = l->sampled[0] = 0;
    results[1] = (real)loop_drive(l, (integer)in[1]);
    bool within = tally->upto < 1;
    integer last = l->logged[0] - 1;
    results[0] = (real)tally->status;
    results[2] = within ? (real)l->passages[last].event : -1;
    copy(l->variables, within ? l->logged_states + last * l->width : l->state, 1, results + 3, 1);
}

/* Execute a program. Return whether comparisons are as expected, no number is divided by 0 (where
   Python may raise), and the loops of its motions are known. */
static bool execute(const Jumps *j, const Program *c) {
    real *r = j->registers, *to = r + c->result;
    for (const Line *line = c->lines; line < c->lines + c->length; line++, to++) {
        real a = r[line->a], b = r[line->b];
        int exponent;
        if ((line->what == DIVIDE && b == 0) || (line->what == EXPECT && (a != 0) != (b != 0)))
            return false;
        switch (line->what) {
        ARITHMETIC(WRITE)
        case MOTION:
            if (j->loops[(integer)b] == NULL)
                return false;
            follow_motion(j->loops[(integer)b], r + line->a, to);
            break;
        }
    }
    return true;
}

/* Execute lines, as `execute`, on n columns of 80-bit numbers; `first` is the register of the first
   line's result. Return the number of lines executed: those before a MOTION, or all. Return -1 if a
   comparison is not as expected. */
integer loop_columns(integer length, integer first, integer n, const Line *lines, long double *r) {
    long double *to = r + first * n, a, b;
    int exponent;
    for (const Line *line = lines; line < lines + length; line++, to += n) {
        const long double *x = r + line->a * n, *y = r + line->b * n;
        switch (line->what) {
        ARITHMETIC(WRITE_COLUMNS)
        case MOTION:
            return line - lines;
        case EXPECT:
            for (integer i = 0; i < n; i++)
                if ((x[i] != 0) != (y[i] != 0))
                    return -1;
            break;
        }
    }
    return length;
}

/* Execute the first program of a change whose comparisons are as expected, in a state of a lane.
   Return it; NULL if there is none, as for a stall, or what follows is not finite. The inputs have
   the order of `JumpPrograms._traced`; a change of one is a change of both. */
static const Program *execute_first(const Jumps *j, const Top *t, const Loop *l, integer lane,
                                    const real *state) {
    integer events = l->events, numbers = j->numbers;
    if (j->programs == NULL || t->event < 0)
        return NULL;
    const Program *c = j->programs[t->phase * (events + 1) + t->event];
    real *r = j->registers, *signs = r + numbers + 2, *constants = signs + events + l->variables;
    memcpy(r, t->body, numbers * sizeof(real));
    r[numbers] = t->high;
    r[numbers + 1] = t->end - t->high;
    for (integer e = 0; e < events; e++)
        signs[e] = function(l, e, lane)->sign;
    copy(l->variables, state, 1, signs + events, 1);
    for (; c != NULL; c = c->other) {
        copy(r + c->result - constants, c->constants, 1, constants, 1);
        if (j->loops[c->next] != NULL && execute(j, c))
            break;
    }
    if (c == NULL)
        return NULL;
    real finite = 0; /* otherwise NaN, as in `advance_time` */
    for (integer k = c->out; k < c->after; k++)
        finite += 0.0 * r[k];
    return finite == 0 && r[c->after + 1] >= 0 ? c : NULL;
}

/* Note what a change from a state logs, and what happens in it from `when` until `time`, as
   `HybridDriver._enter`; a change of one is a change of both. */
static void note_change(const Jumps *j, const Loop *l, integer lane, const Program *c, real when,
                        real time, const real *state) {
    /* The functions in the time of the change are before `out`, see `Program`. */
    const real *signs = j->registers + c->out, *ranges = signs - c->ranged * POINTS;
    for (integer k = 0; k < c->logged + c->passed; k++) {
        integer e = c->events[k], sign = k < c->logged ? 1 : (integer)signs[e];
        if (l->log_room > 0)
            copy(l->variables, state, 1, l->logged_states + l->logged[0] * l->width, 1);
        loop_note(l, j->events + e, e, l->slots[lane], sign, l->in_lane[lane], when, state);
    }
    for (integer k = 0; k < c->ranged; k++, ranges += POINTS) {
        integer e = c->events[c->logged + c->passed + k];
        Function *f = function(l, e, lane);
        for (int i = 0; i < POINTS; i++) {
            real value = ranges[i] * j->events[e].scale;
            for (int side = 0; side < 2; side++)
                if (side ? value > f->extremes[1] : value < f->extremes[0]) {
                    f->extremes[side] = value;
                    f->times[side] = when + (time - when) * i / (POINTS - 1);
                }
        }
    }
}

/* Change the phase of the top in a lane in the state where the phase ended, as
   `HybridDriver._change` and `_enter`; a change of one is a change of both. Return the state in
   which the next phase begins. Return NULL, with nothing changed, if Python must do it: a phase
   that was too short, a jump without a program, a full log, or a row within the jump. */
static const real *change(Jumps *j, Top *t, const Loop *l, integer lane, const real *state) {
    /* As in `HybridDriver._change`: a phase that was to last no time is not too short. */
    bool lasts = t->until > t->began;
    if (lasts && t->high - t->began < j->chatter * fmax(t->began, 1))
        return NULL;
    const Program *c = execute_first(j, t, l, lane, state);
    if (c == NULL)
        return NULL;
    const real *more = j->registers + c->after; /* `lasts` and `delay` of the Next, then numbers */
    real when = t->high, time = MIN(t->end, when + more[1]);
    bool full = l->log_room > 0 && l->logged[0] + c->logged + c->passed > l->log_room;
    if (full || (time > when && is_row_before(l, l->slots[lane], time)))
        return NULL;
    note_change(j, l, lane, c, when, time, state);
    if (j->made != NULL) {
        real *made = j->made + j->length++ * j->width;
        made[0] = when;
        made[1] = (real)t->event;
        made[2] = (real)c->number;
        copy(j->width - 3, more, 1, made + 3, 1);
    }
    t->phase = c->next;
    t->high = t->began = time;
    t->until = t->stop = MIN(t->end, time + more[0]);
    t->stops_by = l->events; /* the clock, as in the table of programs */
    t->short_phases = lasts ? 0 : t->short_phases;
    return begin_functions(l, lane, j->registers + c->out);
}

/* A phase ends in this last part of a run only where the run does; as in `engine.hybrid`. */
static const real AT_END = 0x1p-50;

/* Take the time of a top, and the event by which its phase ends, from its lane. Return whether the
   phase ends. */
static bool ends_phase(Top *t, const Loop *l, integer lane) {
    const Tally *tally = tally_of(l, lane);
    bool within = tally->upto < 1, by_clock = tally->status == FINISHED && t->stop < t->end;
    bool goes_on = tally->status == SETTLED || tally->status == RUNNING;
    t->high = tally->t;
    t->low = goes_on ? l->low[lane] : 0; /* an end is a double */
    t->event = within ? l->ended_by[lane] : by_clock ? t->stops_by : NO_EXIT;
    if (tally->status == STALLED)
        t->event = BY_STALL;
    return t->event != NO_EXIT;
}

/* Is a phase that ends now the last: is at most AT_END of the run left? */
static bool is_at_end(const Top *t) {
    return t->end - t->high <= AT_END * t->end;
}

/* Change the phase of a run where it has ended. Return false if the caller must do it: the log then
   ends with the event that ended the phase, as `HybridDriver.run` needs it. */
static bool change_phase(Jumps *j, Top *t) {
    const Loop *l = j->loops[t->phase];
    bool within = l->tallies->upto < 1;
    bool full = l->row_count > 0 && l->rows_made[0] == l->row_count;
    if (!ends_phase(t, l, 0) || full || is_at_end(t))
        return false;
    /* The event that ended the phase leaves the log: `change` notes those that its jump logs. Its
       state remains in its row; if the caller must make the jump, the event is put back. */
    integer last = l->logged[0] -= within;
    const real *state = within ? l->logged_states + last * l->width : l->state;
    state = change(j, t, l, 0, state);
    if (state == NULL) {
        l->logged[0] += within;
        return false;
    }
    begin_lane(j->loops[t->phase], 0, t->high, 0, t->until, state);
    return true;
}

/* Make at most `most` steps of a run, in its present phase and in those after it, until `changes`
   changes are `made`. Return the number of steps. */
integer loop_run(Jumps *j, Top *t, integer most, integer changes) {
    integer steps = 0;
    do
        steps += loop_drive(j->loops[t->phase], most - steps);
    while (steps < most && change_phase(j, t) && j->length < changes);
    return steps;
}

/* --- many tops in lanes: a pool of lanes for each phase, with a queue of tops --- */

/* As `POOL_RECORD` of `engine.pools`: a change of one is a change of both. */
typedef struct {
    const Loop *loop;          /* NULL in a phase that no top has entered */
    const integer *parameters; /* (Loop.parameters,) index of each one in the numbers of a body */
    integer by_steps;          /* whether the caller sets the end of each step */
    integer first, count;      /* of the queue, a ring: place of its first top, number of tops */
    integer occupied;          /* tops in lanes */
} Pool;

typedef struct {
    Jumps jumps;
    Pool *pools;     /* (phases,) */
    integer *queues; /* (phases, room) rings of slots */
    Top *tops;       /* by slot */
    integer *called; /* slots of tops in no queue: the caller looks at their status and event */
    integer phases,
        room;      /* of a ring, for all tops; also the slot of empty lanes, see `Pools.empty` */
    integer calls; /* number of tops in `called` */
} Pools;

/* Append a top to the queue of its phase, where it waits for a lane. If it may have settled where
   this phase begins, append it to `called` instead, for the caller to look at; it pushes the top
   again with the status SETTLED, which means that it has looked. */
void loop_push(Pools *p, integer top) {
    const Top *t = p->tops + top;
    Pool *pool = p->pools + t->phase;
    Tally *tally = pool->loop->tallies + top;
    bool begins = tally->status != SETTLED && tally->steps == 0;
    if (begins && has_settled(pool->loop, tally, t->steps, t->high)) {
        tally->status = SETTLED;
        p->called[p->calls++] = top;
    } else
        p->queues[t->phase * p->room + (pool->first + pool->count++) % p->room] = top;
}

/* Put the next top of the queue of a phase into a lane, which is empty. */
static void enter_lane(const Pools *p, integer phase, integer lane) {
    Pool *pool = p->pools + phase;
    const Loop *l = pool->loop;
    integer top = p->queues[phase * p->room + pool->first], n = l->lanes;
    const Top *t = p->tops + top;
    pool->first = (pool->first + 1) % p->room;
    pool->count--;
    pool->occupied++;
    l->slots[lane] = top;
    for (integer k = 0; k < l->parameters; k++)
        l->pars[k * n + lane] = t->body[pool->parameters[k]];
    l->in_lane[lane] = top * p->phases + phase;
    l->steps_before[lane] = t->steps;
    begin_lane(l, lane, t->high, t->low, t->stop, t->state);
}

/* Change the phase of a top in a lane, whose state is known. Return whether a program could. */
static bool change_top(Jumps *j, Top *t, const Loop *l, integer lane) {
    const real *next = change(j, t, l, lane, t->state);
    if (next != NULL)
        copy(j->loops[t->phase]->variables, next, 1, t->state, 1);
    return next != NULL;
}

/* Begin the first phase of a top, whose jump is noted by a loop (`HybridPools.notes`). Return
   whether a program could; otherwise Python makes the jump, and pushes the top. */
integer loop_start(Pools *p, const Loop *l, integer top) {
    l->slots[0] = top;
    bool is_changed = change_top(&p->jumps, p->tops + top, l, 0);
    if (is_changed)
        loop_push(p, top);
    return is_changed;
}

/* Take a top out of its lane, and change its phase if that has ended; append it to `called` if that
   needs the caller, or if it ends. Its state and time are kept in its `Top` first: the lane is then
   free. */
static void leave_lane(Pools *p, integer phase, integer lane) {
    Pool *pool = p->pools + phase;
    const Loop *l = pool->loop;
    integer top = l->slots[lane];
    Top *t = p->tops + top;
    Tally *tally = tally_of(l, lane);
    bool within = tally->upto < 1, ends = ends_phase(t, l, lane);
    if (within)
        state_at(l, lane, tally->t, l->out);
    copy(l->variables, (within ? l->out : l->state) + lane, l->lanes, t->state, 1);
    bool is_changed = false;
    if (ends && is_at_end(t)) {
        tally->status = FINISHED;
        tally->t = t->end;
        t->event = NO_EXIT;
    } else if (ends) {
        t->steps += tally->steps;
        tally->steps = 0;
        is_changed = change_top(&p->jumps, t, l, lane);
    }
    l->in_lane[lane] = -1;
    l->slots[lane] = p->room; /* of empty lanes, as `Pools.empty` */
    pool->occupied--;
    if (is_changed)
        loop_push(p, top);
    else
        p->called[p->calls++] = top;
}

/* Return the phase in which most tops are; -1 without a top. */
static integer fullest(const Pools *p) {
    integer best = -1, most = 0;
    for (integer k = 0; k < p->phases; k++) {
        integer count = p->pools[k].count + p->pools[k].occupied;
        if (count > most) {
            most = count;
            best = k;
        }
    }
    return best;
}

/* Make at most `most` steps of lanes, in one phase after another, until a top waits for the caller.
   Return the number of steps. */
integer loop_pools(Pools *p, integer most) {
    integer steps = 0, phase = fullest(p);
    while (phase >= 0 && steps < most && p->calls == 0) {
        Pool *pool = p->pools + phase;
        const Loop *l = pool->loop;
        for (integer lane = 0; lane < l->lanes; lane++)
            while (l->in_lane[lane] < 0 && pool->count > 0 && p->calls == 0) {
                enter_lane(p, phase, lane);
                if (tally_of(l, lane)->status != RUNNING) /* a phase that ends where it begins */
                    leave_lane(p, phase, lane);
            }
        steps += loop_drive(l, pool->by_steps ? 1 : most - steps);
        for (integer lane = 0; lane < l->lanes; lane++)
            if (l->in_lane[lane] >= 0 && (pool->by_steps || tally_of(l, lane)->status != RUNNING))
                leave_lane(p, phase, lane);
        if (is_full(l)) /* the caller makes room */
            break;
        if (pool->count + pool->occupied < l->lanes)
            phase = fullest(p);
    }
    return steps;
}

/* --- for the binding and for tests --- */

/* Count turnings, and write what each does: CONFIRMS, WAITS or their sum. */
void loop_count_turnings(Tally *tally, real noise_floor, integer n, const integer *signs,
                         const real *thetas, integer *effects) {
    for (integer k = 0; k < n; k++)
        effects[k] = count_turning(tally, noise_floor, signs[k], thetas[k]);
}

#ifndef DIGEST
#define DIGEST ""
#endif

/* A digest of this file when it was compiled, which `engine.loop.library` compares with that of the
   source; "" if the build did not define it. */
const char *loop_digest(void) {
    return DIGEST;
}

/* The size of the structure `Loop`, which a test compares with that of `engine.loop`. */
integer loop_structure_size(void) {
    return sizeof(Loop);
}
