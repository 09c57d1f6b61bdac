/* The step loop of one run, or of many runs in the lanes of one integrator.

   A Taylor integrator, compiled elsewhere, makes each step. Its coefficients are the polynomials on
   which events are found after the step: an event never changes a step. The caller owns all memory
   and describes it in one structure. There is no global state and no allocation, and every number
   of a lane depends on the steps of that lane alone.

   Stored runs continue bit by bit, so sums are written in a fixed order, and the compiler must not
   change it (-ffp-contract=off, no
   -ffast-math). */

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

/* The first argument if the second one is NaN. */
#define MIN(a, b) ((b) < (a) ? (b) : (a))
#define MAX(a, b) ((b) > (a) ? (b) : (a))

/* Formulas, and loops over lanes that are compiled for a known number of them. */
#define INLINED static inline __attribute__((always_inline))

typedef double real;
typedef int64_t integer;

enum {
    DEPTH = 20,   /* halvings of an interval: two zeros within 1e-6 of a step are none */
    MOST = 64,    /* coefficients of a polynomial; quadruple precision has 47 */
    HALVES = 32,  /* rows of the table of (1/2 + x/2)^j */
    NODES = 9,    /* points of a step: it covers about a radian, so no dip hides between them */
    TIMES = 8,    /* rows made together, which fill the processor's vectors */
    TOGETHER = 4, /* variables made together: each sum waits for its last addition */
    FEW = 2       /* rows in a step that are made one by one */
};

/* --- what the caller provides: `tippetop.engine.loop` makes the same structures --- */

/* What is known of an event function: its sign, +1 or -1; its least and greatest values; 1 if the
   run starts on a zero of it; in the present step its bounds, and 1 if it is monotone; the times of
   its least and greatest values. */
enum { SIGN, LEAST, GREATEST, ON_ZERO, LOW, HIGH, STEADY, T_LEAST, T_GREATEST, KNOWN };

/* What an event keeps of its passages: the time of the first or the last one, or their number. */
enum { FIRST, LAST, COUNT };

/* What a passage does to the turning of theta that waits to be counted. */
enum { CONFIRMS = 1, WAITS = 2 };

/* How compiled code rounds a product and the difference that takes it. */
enum { UNKNOWN, SEPARATE, FUSED };

typedef void (*Step)(real *state, const real *pars, const real *time, real *h, real *tc);
typedef void (*Dense)(real *out, const real *tc, const real *h);

typedef struct {
    integer variables, parameters, size, lanes, events, numbers, axis, log, samples;
} Sizes;

typedef struct {
    real *state, *before, *pars, *tc, *high, *low, *start_high, *start_low, *end, *limit, *h;
} Motion;

typedef struct {
    integer row, shift, leader, direction, ends, sense, first, last;
    real scale, offset;
    bool extremes, watched, ranged, bounded;
} Event;

typedef struct {
    integer what, direction;
} Number;

typedef struct {
    const Event *events;
    const Number *numbers;
    const integer *axis;
} EventRows;

typedef struct {
    integer status;
    real t;
    integer steps;
    real upto;
    integer tiny, waiting;
    real waits_at;
    integer turnings;
    real theta_min, theta_max, lasts_since, doubted;
} Tally;

typedef struct {
    Tally *lane;
    real *functions, *kept;
} Tallies;

typedef struct {
    integer *filled;
    real *time;
    integer *event, *sign;
    bool *at_pole;
    real *states;
} Log;

typedef struct {
    integer *filled, *in_lane, *top;
    real *states;
} Samples;

typedef struct {
    real *factors, *sums, *quiet, *h, *out;
} Scratch;

typedef struct {
    integer lasting, way;
    real settled_for;
    integer most_steps, every, first;
} StopRules;

typedef struct {
    integer running, finished, non_finite, stalled, settled;
} Codes;

typedef struct {
    real noise_floor, at_pole, near_pole, on_zero_for, tiny;
    integer patience;
} Thresholds;

typedef struct {
    const real *halves, *powers; /* (HALVES, HALVES), (MOST, NODES) */
} Tables;

typedef struct {
    real *times, *states;
    integer *filled;
    integer steps, rounding, count, variables, vector;
} Rows;

typedef struct {
    const real *start, *pars, *until;
    const int8_t *signs, *on_zero;
    Tally *lane;
    real *functions, *kept, *final;
} Tops;

typedef struct {
    const integer *tops;
    integer *waiting, *ended;
} Queue;

typedef struct {
    Tops tops;
    Queue queue;
    Tallies fresh;
    integer count, variables;
} Ensemble;

typedef struct {
    Step step;
    Dense dense;
    Sizes sizes;
    Motion motion;
    EventRows rows;
    Tallies tallies;
    Log log;
    Samples samples;
    Scratch scratch;
    StopRules rules;
    Codes codes;
    Thresholds thresholds;
    Tables tables;
    Rows output;
    Ensemble ensemble;
} Loop;

/* --- polynomials on [0, 1], ascending coefficients --- */

INLINED real value_at(const real *p, integer n, real x) {
    real sum = 0;
    for (integer k = n - 1; k >= 0; k--)
        sum = sum * x + p[k];
    return sum;
}

/* p(1), with the bits of `value_at`, in half the time. */
INLINED real value_at_end(const real *p, integer n) {
    real sum = 0;
    for (integer k = n - 1; k >= 0; k--)
        sum += p[k];
    return sum;
}

/* An upper bound of |p(x) - p(0)|. Two sums, which the processor adds at the same time. */
INLINED real reach(const real *p, integer n) {
    real even = 0, odd = 0;
    for (integer k = 1; k < n - 1; k += 2) {
        even += fabs(p[k]);
        odd += fabs(p[k + 1]);
    }
    return n % 2 ? even + odd : even + odd + fabs(p[n - 1]);
}

typedef struct {
    real value, slope, curve;
} Jet;

/* p(x), p'(x) and p''(x)/2. Even and odd powers are separate chains, for the same reason. */
INLINED Jet jet(const real *p, integer n, real x) {
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

/* The zero of a monotone p on [low, high], where it has the values `start` and `end`: Newton's rule
   from the secant, kept between bounds. The lower end if rounding hides the zero there. */
static real zero_of(const real *p, integer n, real low, real high, real start, real end) {
    bool rising = end > 0;
    if ((start > 0) == rising)
        return low;
    real x = low + (high - low) * (start / (start - end));
    for (int i = 0; i < 60; i++) {
        Jet f = jet(p, n, x);
        if (f.value == 0)
            return x;
        if ((f.value > 0) == rising)
            high = x;
        else
            low = x;
        real after = f.slope != 0 ? x - f.value / f.slope : 0.5 * (low + high);
        if (!(low <= after && after <= high))
            after = 0.5 * (low + high);
        if (fabs(after - x) <= 1e-9) /* the next correction is its square */
            return after;
        x = after;
    }
    return x;
}

/* Where p, with at most one turn on [-1, 1], turns. -1 if it has none there, or goes less far
   beyond zero than two zeros that are as near as intervals are small. */
static real turn_of(const real *p, integer n, real radius) {
    real x = 0, low = -1, high = 1;
    for (int i = 0; i < 60; i++) {
        Jet f = jet(p, n, x);
        if ((f.slope > 0) == (p[2] > 0))
            high = x;
        else
            low = x;
        real before = x;
        x = before - f.slope / (2 * f.curve);
        if (!(low <= x && x <= high))
            x = 0.5 * (low + high);
        if (fabs(x - before) <= 1e-9)
            break;
    }
    Jet f = jet(p, n, x);
    real least = fabs(f.curve) * 0.25 / pow(4.0, DEPTH);
    bool beyond = f.value * f.curve < 0 && fabs(f.value) * radius * radius > least;
    return beyond && -1 < x && x < 1 ? x : -1;
}

/* The coefficients of p(middle + radius x). */
static void shift(const real *restrict p, integer n, real middle, real radius, const Tables *tables,
                  real *restrict shifted) {
    if (radius == 0.5 &&
        n <= HALVES) { /* nearly always: as a product with a matrix, three times as fast */
        for (integer k = 0; k < n; k++)
            shifted[k] = 0;
        for (integer j = 0; j < n; j++) {
            real factor = p[j];
            const real *restrict row = tables->halves + j * HALVES;
            for (integer k = 0; k < n; k++)
                shifted[k] += row[k] * factor;
        }
        return;
    }
    memcpy(shifted, p, n * sizeof(real));
    for (integer i = 0; i < n - 1; i++)
        for (integer k = n - 2; k >= i; k--)
            shifted[k] += middle * shifted[k + 1];
    real power = 1;
    for (integer k = 1; k < n; k++) {
        power *= radius;
        shifted[k] *= power;
    }
}

/* Write the sign changes of p on [0, 1) to `zeros` (n,), ascending, and return their number.
   `positive` is the sign at the end of the last step: a zero that rounding puts between two steps
   counts once. `monotone`: p is known to be. */
static integer crossings(const real *p, integer n, bool positive, bool monotone,
                         const Tables *tables, real *zeros) {
    if (monotone) {
        real end = value_at_end(p, n);
        if ((end > 0) == positive)
            return 0;
        zeros[0] = zero_of(p, n, 0, 1, p[0], end);
        return 1;
    }
    real radius = reach(p, n);
    if (!isfinite((real)(n * n) * (radius + fabs(p[0])))) /* no interval would ever be decided */
        return 0;
    if (fabs(p[0]) > radius || radius == 0) { /* away from zero, or zero, all along */
        bool now = p[0] != 0 ? p[0] > 0 : positive;
        zeros[0] = 0;
        return now != positive;
    }
    real part[MOST];
    integer count = 0, at = 0, level = 0; /* the interval [at, at + 1]/2^level */
    for (;;) {
        radius = ldexp(0.5, (int)-level);
        real middle = (real)(2 * at + 1) * radius;
        shift(p, n, middle, radius, tables, part);
        real rest = 0, bend = 0, curl = 0;
        for (integer k = n - 1; k > 2; k--) {
            real size = fabs(part[k]);
            rest += size;
            bend += (real)k * size;
            curl += (real)(k * (k - 1)) * size;
        }
        rest += fabs(part[1]) + fabs(part[2]);
        bend += 2 * fabs(part[2]);
        bool one_zero = fabs(part[0]) > rest || fabs(part[1]) > bend || level == DEPTH;
        bool one_turn = 2 * fabs(part[2]) > curl;
        if (!one_zero && !one_turn) {
            at *= 2;
            level++;
            continue;
        }
        real ends[] = {one_zero ? -1 : turn_of(part, n, radius), 1}, low = -1;
        for (int i = 0; i < 2; i++) {
            real high = ends[i];
            if (!(high > low))
                continue;
            real end = value_at(part, n, high);
            if ((end > 0) != positive && count < n) {
                real x = zero_of(part, n, low, high, value_at(part, n, low), end);
                zeros[count++] = ((real)(2 * at + 1) + x) * radius;
            }
            positive = end > 0;
            low = high;
        }
        at++;
        while (at % 2 == 0 && level > 0) { /* up to the next interval */
            at /= 2;
            level--;
        }
        if (level == 0)
            return count;
    }
}

/* The least value of sign*p near x, at most `best`, and its place: Newton's rule on the slope, kept
   in [0, 1]. */
static real polished(const real *p, integer n, real sign, real x, real best, real *at) {
    *at = x;
    for (int i = 0; i < 6; i++) {
        Jet f = jet(p, n, x);
        if (sign * f.value < best) {
            best = sign * f.value;
            *at = x;
        }
        if (!(sign * f.curve > 0))
            return best;
        real after = x - f.slope / (2 * f.curve);
        after = MAX(0.0, after);
        after = MIN(1.0, after);
        if (fabs(after - x) <= 1e-9) /* the value is flat to 1e-18 there */
            return best;
        x = after;
    }
    real last = sign * value_at(p, n, x);
    if (last < best) {
        *at = x;
        return last;
    }
    return best;
}

typedef struct {
    real least, greatest, at_least, at_greatest; /* places; NaN if the value is the one before */
} Extremes;

/* Extend the least and greatest values by those of p on [0, 1]. */
static Extremes extremes(const real *p, integer n, real least, real greatest, bool monotone,
                         const Tables *tables) {
    Extremes found = {least, greatest, NAN, NAN};
    if (monotone) {
        real start = p[0], end = value_at_end(p, n);
        if (MIN(start, end) < least) {
            found.least = start <= end ? start : end;
            found.at_least = start <= end ? 0 : 1;
        }
        if (MAX(start, end) > greatest) {
            found.greatest = start >= end ? start : end;
            found.at_greatest = start >= end ? 0 : 1;
        }
        return found;
    }
    real samples[NODES] = {0};
    for (integer k = 0; k < n; k++)
        for (int i = 1; i < NODES; i++)
            samples[i] += p[k] * tables->powers[k * NODES + i];
    samples[0] = p[0];
    int under = 0, over = 0;
    for (int i = 1; i < NODES; i++) {
        under = samples[i] < samples[under] ? i : under;
        over = samples[i] > samples[over] ? i : over;
    }
    real bend = 0; /* between two nodes p goes no further beyond them */
    for (integer k = 2; k < n; k++)
        bend += (real)(k * (k - 1)) * fabs(p[k]);
    bend /= 8 * (NODES - 1) * (NODES - 1);
    real at;
    if (samples[under] - bend < least) {
        real best = polished(p, n, 1, under / (NODES - 1.0), samples[under], &at);
        if (best < least) {
            found.least = best;
            found.at_least = at;
        }
    }
    if (samples[over] + bend > greatest) {
        real best = -polished(p, n, -1, over / (NODES - 1.0), -samples[over], &at);
        if (best > greatest) {
            found.greatest = best;
            found.at_greatest = at;
        }
    }
    return found;
}

/* --- bounds of the event functions over a step, in all lanes --- */

INLINED real *known(const Loop *l, integer what, integer event) {
    return l->tallies.functions + (what * l->sizes.events + event) * l->sizes.lanes;
}

INLINED void next_factors(integer n, real k, const real *restrict before, const real *restrict h,
                          real *restrict of_variables, real *restrict of_rates) {
    for (integer i = 0; i < n; i++) {
        of_variables[i] = before[i] * h[i];
        of_rates[i] = (k + 1) * (before[i] * h[i]);
    }
}

INLINED void add_power(integer n, real k, const real *restrict c, const real *restrict factor,
                       real *restrict rest, real *restrict end, real *restrict bend) {
    for (integer i = 0; i < n; i++) {
        real a = c[i] * factor[i];
        end[i] += a;
        rest[i] += fabs(a);
        bend[i] += k * fabs(a);
    }
}

/* Bounds of polynomials, from their lowest powers c (5, n) times factors, and the sums of the
   others. The Bernstein coefficients of the cubic part, plus or minus the sum of the other
   coefficients, bound a polynomial; those of its slope show whether it is monotone: then it lies
   between its ends. */
INLINED void bound(integer n, const real *restrict c, const real *restrict factor,
                   const real *restrict rest, const real *restrict end, const real *restrict bend,
                   real *restrict low, real *restrict high, real *restrict steady) {
    for (integer i = 0; i < n; i++) {
        real p0 = c[i], p1 = c[n + i] * factor[n + i], p2 = c[2 * n + i] * factor[2 * n + i];
        real p3 = c[3 * n + i] * factor[3 * n + i], p4 = c[4 * n + i] * factor[4 * n + i];
        real b1 = p0 + p1 / 3, b2 = p0 + (2 * p1 + p2) / 3, b3 = p0 + p1 + p2 + p3;
        real s1 = p1 + 2 * p2 / 3, s2 = p1 + (4 * p2 + 3 * p3) / 3,
             s3 = p1 + 2 * p2 + 3 * p3 + 4 * p4;
        real slow1 = MIN(p1, s1), slow2 = MIN(s2, s3), slow = MIN(slow1, slow2);
        real fast1 = MAX(p1, s1), fast2 = MAX(s2, s3), fast = MAX(fast1, fast2);
        bool monotone = (slow > bend[i]) | (fast < -bend[i]);
        real last = b3 + p4 + end[i], beyond = fabs(p4) + rest[i];
        real low1 = MIN(p0, b1), low2 = MIN(b2, b3), high1 = MAX(p0, b1), high2 = MAX(b2, b3);
        steady[i] = monotone ? 1.0 : 0.0;
        low[i] = monotone ? MIN(p0, last) : MIN(low1, low2) - beyond;
        high[i] = monotone ? MAX(p0, last) : MAX(high1, high2) + beyond;
    }
}

/* Write bounds of c[k + shift]*factors[k], (size, n) each, to low, high and steady (n,). `sums` has
   room for (3, n). */
INLINED void ranges(integer n, integer size, integer shift, const real *c, const real *factors,
                    real *sums, real *low, real *high, real *steady) {
    real *rest = sums, *end = sums + n, *bend = sums + 2 * n;
    c += shift * n;
    if (n == 1) { /* in registers */
        real total = 0, absolute = 0, steep = 0;
        for (integer k = 5; k < size - shift; k++)
            add_power(1, (real)k, c + k, factors + k, &absolute, &total, &steep);
        *rest = absolute;
        *end = total;
        *bend = steep;
    } else {
        for (integer i = 0; i < 3 * n; i++)
            sums[i] = 0;
        for (integer k = 5; k < size - shift; k++)
            add_power(n, (real)k, c + k * n, factors + k * n, rest, end, bend);
    }
    bound(n, c, factors, rest, end, bend, low, high, steady);
}

/* Bounds of a variable plus `offset` by those of its rate. */
INLINED void led(integer n, const real *restrict start, real offset, const real *restrict h,
                 const real *restrict rate_low, const real *restrict rate_high, real *restrict low,
                 real *restrict high, real *restrict steady) {
    for (integer i = 0; i < n; i++) {
        low[i] = start[i] + offset + h[i] * MIN(0.0, rate_low[i]);
        high[i] = start[i] + offset + h[i] * MAX(0.0, rate_high[i]);
        steady[i] = ((rate_low[i] > 0) | (rate_high[i] < 0)) ? 1.0 : 0.0;
    }
}

INLINED void silent_sign(integer n, const real *restrict sign, const real *restrict low,
                         const real *restrict high, real *restrict quiet) {
    for (integer i = 0; i < n; i++) {
        real within = sign[i] > 0 ? low[i] : -high[i];
        quiet[i] = within > 0 ? quiet[i] : -1.0;
    }
}

INLINED void silent_range(integer n, const real *restrict low, const real *restrict high,
                          const real *restrict least, const real *restrict greatest,
                          real *restrict quiet) {
    for (integer i = 0; i < n; i++)
        quiet[i] = ((low[i] >= least[i]) & (high[i] <= greatest[i])) ? quiet[i] : -1.0;
}

/* Bound every event function over the step from `start` to `stop` (n,). `scratch.quiet` becomes 1
   in lanes in which no function does anything new, -1 in the others. */
INLINED void bound_functions(const Loop *l, integer n, const real *tc, const real *start,
                             const real *stop) {
    integer size = l->sizes.size;
    real *factors = l->scratch.factors, *h = l->scratch.h, *quiet = l->scratch.quiet;
    const Event *events = l->rows.events;

    for (integer i = 0; i < n; i++) { /* from time to time over h: of variables, then of rates */
        factors[i] = factors[size * n + i] = 1;
        h[i] = stop[i] - start[i];
        quiet[i] = 1;
    }
    for (integer k = 1; k < size; k++)
        next_factors(n, (real)k, factors + (k - 1) * n, h, factors + k * n,
                     factors + (size + k) * n);

    for (integer e = 0; e < l->sizes.events; e++) {
        const Event *event = events + e;
        if (event->leader >= 0 || !event->bounded)
            continue;
        real *low = known(l, LOW, e), *high = known(l, HIGH, e);
        ranges(n, size, event->shift, tc + event->row * size * n, factors + event->shift * size * n,
               l->scratch.sums, low, high, known(l, STEADY, e));
        if (event->offset != 0)
            for (integer i = 0; i < n; i++) {
                low[i] += event->offset;
                high[i] += event->offset;
            }
    }
    for (integer e = 0; e < l->sizes.events; e++) {
        const Event *event = events + e;
        if (event->leader >= 0 && event->bounded)
            led(n, tc + event->row * size * n, event->offset, factors + n,
                known(l, LOW, event->leader), known(l, HIGH, event->leader), known(l, LOW, e),
                known(l, HIGH, e), known(l, STEADY, e));
    }
    for (integer e = 0; e < l->sizes.events; e++) {
        if (events[e].watched)
            silent_sign(n, known(l, SIGN, e), known(l, LOW, e), known(l, HIGH, e), quiet);
        if (events[e].ranged)
            silent_range(n, known(l, LOW, e), known(l, HIGH, e), known(l, LEAST, e),
                         known(l, GREATEST, e), quiet);
    }
}

/* --- the events of one lane --- */

INLINED bool keeps_sign(const Loop *l, integer e, integer lane) {
    return (known(l, SIGN, e)[lane] > 0 ? known(l, LOW, e)[lane] : -known(l, HIGH, e)[lane]) > 0;
}

INLINED bool keeps_range(const Loop *l, integer e, integer lane) {
    return known(l, LOW, e)[lane] >= known(l, LEAST, e)[lane] &&
           known(l, HIGH, e)[lane] <= known(l, GREATEST, e)[lane];
}

/* The coefficients of an event function over a step, in time over h. */
static void polynomial(const Loop *l, const real *tc, const Event *event, integer lane, real *p) {
    integer size = l->sizes.size, lanes = l->sizes.lanes, shift = event->shift;
    const real *c = tc + (event->row * size + shift) * lanes + lane;
    const real *factors = l->scratch.factors + shift * size * lanes + lane;
    p[size - 1] = 0;
    for (integer k = 0; k < size - shift; k++)
        p[k] = c[k * lanes] * factors[k * lanes];
    p[0] += event->offset;
}

/* Whether a zero is that of the start. A function that must not fall below zero is let through
   there too. */
INLINED bool of_start(const Loop *l, integer e, real when, integer lane) {
    return known(l, ON_ZERO, e)[lane] > 0 && when <= l->thresholds.on_zero_for &&
           !l->rows.events[e].extremes;
}

/* Count a turning of theta (sign +1: a minimum, -1: a maximum) once theta has come back from it by
   the noise floor; the end of a run (0) confirms the turning that waits. Return CONFIRMS if the
   turning that waited counts, plus WAITS if this one waits now: small wiggles between do not
   matter, so a true turning that rounding splits into three counts once, and a decay that ends in
   noise not at all. */
static integer take_turning(Tally *tally, real noise_floor, integer sign, real theta) {
    real back = theta - tally->waits_at;
    bool confirmed =
        tally->waiting != 0 && (real)tally->waiting * back >= noise_floor;
    bool further = sign == tally->waiting && (real)sign * back < 0;
    bool waits = sign != 0 && (confirmed || tally->waiting == 0 || further);
    if (confirmed) {
        real at = tally->waits_at;
        tally->turnings++;
        tally->theta_min = isnan(tally->theta_min) ? at : MIN(at, tally->theta_min);
        tally->theta_max = isnan(tally->theta_max) ? at : MAX(at, tally->theta_max);
        tally->waiting = 0;
    }
    if (waits) {
        tally->waiting = sign;
        tally->waits_at = theta;
    }
    return (confirmed ? CONFIRMS : 0) + (waits ? WAITS : 0);
}

/* theta at the time x of a step, and whether the axis passes through a pole there, rather than near
   it. */
static real theta_at(const Loop *l, const real *tc, real x, integer lane, bool *at_pole) {
    integer size = l->sizes.size, lanes = l->sizes.lanes;
    const real *axis[3];
    for (int i = 0; i < 3; i++)
        axis[i] = tc + l->rows.axis[i] * size * lanes + lane;
    real a = 0, b = 0, c = 0, a_rate = 0, b_rate = 0;
    for (integer k = size - 1; k >= 0; k--) {
        a_rate = a_rate * x + a;
        b_rate = b_rate * x + b;
        a = a * x + axis[0][k * lanes];
        b = b * x + axis[1][k * lanes];
        c = c * x + axis[2][k * lanes];
    }
    real speed = a_rate * a_rate + b_rate * b_rate, near = l->thresholds.near_pole;
    real across =
        fabs(a * b_rate - b * a_rate); /* closest approach times speed, however well x is known */
    *at_pole = across < l->thresholds.at_pole * speed && a * a + b * b < near * near * speed;
    return atan2(sqrt(a * a + b * b), c);
}

/* Keep what the event asks for of its zero at x of a step, and log it. */
static void take_passage(const Loop *l, const real *tc, integer e, real t, real h,
                         real x, integer lane) {
    const Event *event = l->rows.events + e;
    Tally *tally = l->tallies.lane + lane;
    real when = t + x * h, sign = -known(l, SIGN, e)[lane];
    known(l, SIGN, e)[lane] = sign;
    if (of_start(l, e, when, lane))
        return;
    if (e == l->rules.lasting && (real)l->rules.way * sign > 0)
        tally->lasts_since = when;
    bool at_pole = false;
    if (event->sense != 0 && l->sizes.axis > 0) {
        real theta = theta_at(l, tc, x * h, lane, &at_pole);
        if (l->sizes.log == 0) /* of a logged run the caller counts them, from the states of the log */
            take_turning(tally, l->thresholds.noise_floor,
                         at_pole ? 0 : (integer)((real)event->sense * sign), theta);
    }
    if ((real)event->direction * sign < 0)
        return;
    for (integer m = event->first; m < event->last; m++) {
        const Number *number = l->rows.numbers + m;
        real *kept = l->tallies.kept + m * l->sizes.lanes + lane;
        if ((real)number->direction * sign < 0)
            continue;
        if (number->what == COUNT)
            *kept += 1;
        else if (number->what == LAST || isnan(*kept))
            *kept = when;
    }
    const Log *log = &l->log;
    integer at = log->filled[0];
    if (at == l->sizes.log)
        return;
    log->time[at] = when;
    log->event[at] = e;
    log->sign[at] = (integer)sign;
    log->at_pole[at] = at_pole;
    log->filled[0]++;
}

/* Where the step ends, `upto` or before: at the first zero by which the event ends the run. */
static real ending(const Loop *l, const real *tc, integer e, real t, real h, integer lane,
                   real upto) {
    const Event *event = l->rows.events + e;
    real p[MOST], zeros[MOST], sign = known(l, SIGN, e)[lane];
    polynomial(l, tc, event, lane, p);
    integer count =
        crossings(p, l->sizes.size, sign > 0, known(l, STEADY, e)[lane] > 0, &l->tables, zeros);
    for (integer k = 0; k < count && zeros[k] < upto; k++) {
        sign = -sign;
        if ((real)event->direction * sign >= 0 && !of_start(l, e, t + zeros[k] * h, lane)) {
            l->tallies.lane[lane].status = event->ends;
            return zeros[k];
        }
    }
    return upto;
}

/* Find the events of a lane in a step. Return how far the step goes: 1 unless an event ends the
   run. */
static real take_events(const Loop *l, const real *tc, real t, real end, integer lane) {
    integer size = l->sizes.size;
    real h = end - t, upto = 1, p[MOST], zeros[MOST];

    for (integer e = 0; e < l->sizes.events;
         e++) /* the first ending is the end of the step for all events */
        if (l->rows.events[e].ends != 0 && !keeps_sign(l, e, lane))
            upto = ending(l, tc, e, t, h, lane, upto);

    for (integer e = 0; e < l->sizes.events; e++) {
        const Event *event = l->rows.events + e;
        bool keeps = !event->watched || keeps_sign(l, e, lane),
             monotone = known(l, STEADY, e)[lane] > 0;
        if (keeps && (!event->ranged || keeps_range(l, e, lane)))
            continue;
        polynomial(l, tc, event, lane, p);
        if (!keeps) {
            integer count =
                crossings(p, size, known(l, SIGN, e)[lane] > 0, monotone, &l->tables, zeros);
            for (integer k = 0; k < count && !(zeros[k] > upto); k++)
                take_passage(l, tc, e, t, h, zeros[k], lane);
        }
        if (!event->ranged)
            continue;
        if (upto < 1) {
            real power = 1;
            for (integer k = 0; k < size; k++) {
                p[k] *= power;
                power *= upto;
            }
        }
        real *least = known(l, LEAST, e) + lane, *greatest = known(l, GREATEST, e) + lane;
        Extremes found = extremes(p, size, *least, *greatest, monotone, &l->tables);
        *least = found.least;
        *greatest = found.greatest;
        if (found.at_least >= 0)
            known(l, T_LEAST, e)[lane] = t + found.at_least * upto * h;
        if (found.at_greatest >= 0)
            known(l, T_GREATEST, e)[lane] = t + found.at_greatest * upto * h;
    }
    return upto;
}

/* Count a step that was made. End a run that goes nowhere, or has settled. */
static void count_step(const Loop *l, real t, real end, integer lane, real upto) {
    const StopRules *rules = &l->rules;
    Tally *tally = l->tallies.lane + lane;
    real h = end - t;
    tally->steps++;
    tally->tiny = h < l->thresholds.tiny ? tally->tiny + 1 : 0;
    if (tally->status == l->codes.running) {
        bool lasts =
            rules->lasting >= 0 && (real)rules->way * known(l, SIGN, rules->lasting)[lane] > 0;
        if (tally->steps >= rules->most_steps || tally->tiny >= l->thresholds.patience)
            tally->status = l->codes.stalled;
        else if (lasts && t + h - tally->lasts_since > rules->settled_for &&
                 tally->lasts_since != tally->doubted)
            tally->status = l->codes.settled;
    }
    tally->t = upto < 1 ? t + upto * h : end;
    tally->upto = upto;
}

/* Take in a step from `start` to `stop` (lanes,). */
static void take_step(const Loop *l, const real *tc, const real *start,
                      const real *stop) {
    if (l->sizes.lanes == 1)
        bound_functions(l, 1, tc, start, stop);
    else if (l->sizes.lanes == 8)
        bound_functions(l, 8, tc, start, stop);
    else
        bound_functions(l, l->sizes.lanes, tc, start, stop);
    for (integer lane = 0; lane < l->sizes.lanes; lane++) {
        if (!(stop[lane] > start[lane]) || l->tallies.lane[lane].status != l->codes.running)
            continue;
        bool quiet = l->scratch.quiet[lane] >= 0;
        real upto = quiet ? 1 : take_events(l, tc, start[lane], stop[lane], lane);
        count_step(l, start[lane], stop[lane], lane, upto);
    }
}

/* --- rows at given times --- */

/* Define a function that writes the states of the first lane at the TIMES times `when` after the
   beginning of the step to out (variables, TIMES). The sums are compensated, and have the bits of
   those that the compiled step makes of one time. WIDTH: numbers in a vector of the processor. */
#define SUM_ROWS(NAME, WIDTH, MORE)                                                \
    static void NAME(const Loop *l, const real *when, real *out) {                 \
        typedef real Vector __attribute__((vector_size(WIDTH * sizeof(real))));    \
        integer size = l->sizes.size, last = l->output.variables - 1;              \
        for (integer first = 0; first <= last; first += TOGETHER) {                \
            for (int group = 0; group < TIMES; group += WIDTH) {                   \
                const real *c[TOGETHER];                                           \
                Vector sums[TOGETHER], rests[TOGETHER], h, power, zero = {0};      \
                memcpy(&h, when + group, sizeof h);                                \
                power = h;                                                         \
                for (int i = 0; i < TOGETHER; i++) {                               \
                    c[i] = l->motion.tc + MIN(last, first + i) * size;             \
                    sums[i] = zero + c[i][0];                                      \
                    rests[i] = zero;                                               \
                }                                                                  \
                for (integer k = 1; k < size; k++) {                               \
                    for (int i = 0; i < TOGETHER; i++) {                           \
                        Vector factor = zero + c[i][k], minus = -rests[i], more;   \
                        for (int t = 0; t < WIDTH; t++)                            \
                            more[t] = MORE(factor[t], power[t], minus[t]);         \
                        Vector sum = sums[i] + more;                               \
                        rests[i] = (sum - sums[i]) - more;                         \
                        sums[i] = sum;                                             \
                    }                                                              \
                    power *= h;                                                    \
                }                                                                  \
                for (int i = 0; i < TOGETHER && first + i <= last; i++)            \
                    memcpy(out + (first + i) * TIMES + group, sums + i, sizeof h); \
            }                                                                      \
        }                                                                          \
    }

#define SEPARATELY(a, b, c) ((a) * (b) + (c))

SUM_ROWS(sum_rows_separate, 2, SEPARATELY)

/* A step that fuses was compiled for this processor, which therefore can do it. */
#ifdef __x86_64__
__attribute__((target("avx512f,fma")))
SUM_ROWS(sum_rows_512, 8, fma)
__attribute__((target("fma")))
SUM_ROWS(sum_rows_256, 4, fma)
#else
SUM_ROWS(sum_rows_256, 2, fma)
#define sum_rows_512 sum_rows_256
#endif

    /* Write the state of a lane at a time within the step to `scratch.out`. */
static void state_at(const Loop *l, integer lane, real time) {
    const Motion *m = &l->motion;
    m->limit[lane] = (time - m->start_high[lane]) - m->start_low[lane];
    l->dense(l->scratch.out, m->tc, m->limit);
}

/* Write rows `at` to `at + count` of the present step. */
static void write_rows(const Loop *l, integer at, integer count) {
    const Rows *rows = &l->output;
    if (count <= FEW || rows->rounding == UNKNOWN) {
        for (integer k = 0; k < count; k++) {
            state_at(l, 0, rows->times[at + k]);
            for (integer i = 0; i < rows->variables; i++)
                rows->states[i * rows->count + at + k] = l->scratch.out[i];
        }
        return;
    }
    real when[TIMES], out[rows->variables * TIMES];
    for (integer k = 0; k < TIMES; k++) {
        real time = rows->times[at + (k < count ? k : count - 1)];
        when[k] = (time - l->motion.start_high[0]) - l->motion.start_low[0];
    }
    if (rows->rounding == SEPARATE)
        sum_rows_separate(l, when, out);
    else if (rows->vector == 8)
        sum_rows_512(l, when, out);
    else
        sum_rows_256(l, when, out);
    for (integer i = 0; i < rows->variables; i++)
        memcpy(rows->states + i * rows->count + at, out + i * TIMES, count * sizeof(real));
}

/* Write the rows that lie in the present step of the first lane. Return whether all are written.
   `moved`: this call has made a step; the end of one that was made before it has its row. */
static bool take_rows(const Loop *l, bool moved) {
    const Rows *rows = &l->output;
    const Tally *tally = l->tallies.lane;
    if (rows->count == 0)
        return false;
    integer at = rows->filled[0];
    if (rows->steps) {
        if (moved && tally->upto == 1 && tally->status != l->codes.non_finite) {
            rows->times[at] = l->motion.high[0];
            for (integer i = 0; i < rows->variables; i++)
                rows->states[i * rows->count + at] = l->motion.state[i * l->sizes.lanes];
            rows->filled[0] = ++at;
        }
        return at == rows->count;
    }
    if (tally->status == l->codes.non_finite || tally->steps == 0)
        return false;
    bool ended = tally->status != l->codes.running;
    integer count;
    do {
        for (count = 0; count < TIMES && at + count < rows->count; count++) {
            real time = rows->times[at + count];
            if (!(time < tally->t || (ended && time <= tally->t)))
                break;
        }
        write_rows(l, at, count);
        at += count;
    } while (count == TIMES);
    rows->filled[0] = at;
    return at == rows->count;
}

/* --- steps --- */

/* Allow the next step up to the end of each run; 0 in a lane that has ended. */
void loop_begin_step(const Loop *l) {
    const Motion *m = &l->motion;
    memcpy(m->before, m->state, l->sizes.variables * l->sizes.lanes * sizeof(real));
    for (integer lane = 0; lane < l->sizes.lanes; lane++) {
        bool runs = l->tallies.lane[lane].status == l->codes.running;
        m->start_high[lane] = m->high[lane];
        m->start_low[lane] = m->low[lane];
        m->limit[lane] = runs ? (m->end[lane] - m->high[lane]) - m->low[lane] : 0;
        m->h[lane] = m->limit[lane];
    }
}

/* Add steps to times, in double length. `finite` becomes 0, or NaN where a time is not finite. */
static void add_steps(integer n, const real *restrict h, real *restrict high, real *restrict low,
                      real *restrict finite) {
    for (integer i = 0; i < n; i++) {
        real a = high[i], b = h[i], sum = a + b, part = sum - a;
        real rest = low[i] + ((a - (sum - part)) + (b - part));
        high[i] = sum + rest;
        low[i] = rest - (high[i] - sum);
        finite[i] = 0.0 * high[i];
    }
}

static void add_values(integer n, const real *restrict values, real *restrict finite) {
    for (integer i = 0; i < n; i++)
        finite[i] += 0.0 * values[i];
}

/* Take in the step that was made. Return whether a run has ended. */
static bool take_motion(const Loop *l) {
    const Motion *m = &l->motion;
    integer n = l->sizes.lanes, variables = l->sizes.variables;
    real *finite = l->scratch.quiet;

    add_steps(n, m->h, m->high, m->low, finite);
    for (integer i = 0; i < variables; i++)
        add_values(n, m->state + i * n, finite);
    for (integer lane = 0; lane < n; lane++) {
        if (finite[lane] == 0)
            continue;
        l->tallies.lane[lane].status = l->codes.non_finite;
        for (integer i = 0; i < variables; i++)
            m->state[i * n + lane] = m->before[i * n + lane];
        m->high[lane] = m->start_high[lane];
        m->low[lane] = m->start_low[lane];
    }
    take_step(l, m->tc, m->start_high, m->high);

    bool ended = false;
    const Samples *samples = &l->samples;
    for (integer lane = 0; lane < n; lane++) {
        Tally *tally = l->tallies.lane + lane;
        if (!(m->limit[lane] > 0))
            continue;
        if (tally->status == l->codes.running && m->h[lane] == m->limit[lane])
            tally->status = l->codes.finished;
        ended = ended || tally->status != l->codes.running;
        bool sampled = tally->steps <= l->rules.first || (tally->steps & (l->rules.every - 1)) == 0;
        if (l->sizes.samples == 0 || tally->upto < 1 || !sampled)
            continue;
        integer at = samples->filled[0]++;
        samples->top[at] = samples->in_lane[lane];
        for (integer i = 0; i < variables; i++)
            samples->states[at * variables + i] = m->state[i * n + lane];
    }
    return ended;
}

/* --- lanes that take tops from a queue --- */

static const int AT_END[] = {SIGN, LEAST,
                             GREATEST}; /* what is kept of the event functions of a top */

/* Put a top into a lane. Integrals of event functions, which its start does not contain, begin at
   zero. */
static void take_top(const Loop *l, integer lane, integer top) {
    const Tops *tops = &l->ensemble.tops;
    const Tallies *fresh = &l->ensemble.fresh;
    const Motion *m = &l->motion;
    integer n = l->sizes.lanes, count = l->ensemble.count, events = l->sizes.events;
    for (integer i = 0; i < l->sizes.variables; i++)
        m->state[i * n + lane] = i < l->ensemble.variables ? tops->start[i * count + top] : 0;
    for (integer i = 0; i < l->sizes.parameters; i++)
        m->pars[i * n + lane] = tops->pars[i * count + top];
    m->high[lane] = m->low[lane] = 0;
    m->end[lane] = tops->until[top];
    l->tallies.lane[lane] = fresh->lane[0];
    for (integer e = 0; e < events; e++) {
        for (integer what = 0; what < KNOWN; what++)
            known(l, what, e)[lane] = fresh->functions[what * events + e];
        known(l, SIGN, e)[lane] = tops->signs[top * events + e];
        known(l, ON_ZERO, e)[lane] = tops->on_zero[top * events + e];
    }
    for (integer k = 0; k < l->sizes.numbers; k++)
        l->tallies.kept[k * n + lane] = fresh->kept[k];
}

/* Keep how a top has ended, perhaps within a step. The end may confirm the turning that waits. */
static void put_down(const Loop *l, integer lane, integer top) {
    const Tops *tops = &l->ensemble.tops;
    const Motion *m = &l->motion;
    Tally *tally = l->tallies.lane + lane;
    integer n = l->sizes.lanes, count = l->ensemble.count;
    real *out = l->scratch.out;
    if (tally->upto == 1) {
        for (integer i = 0; i < l->sizes.variables; i++)
            out[i * n + lane] = m->state[i * n + lane];
    } else {
        state_at(l, lane, tally->t);
    }
    for (integer i = 0; i < l->ensemble.variables; i++)
        tops->final[i * count + top] = out[i * n + lane];
    real axis[3];
    for (int i = 0; i < 3; i++)
        axis[i] = out[l->rows.axis[i] * n + lane];
    take_turning(tally, l->thresholds.noise_floor, 0,
                 atan2(sqrt(axis[0] * axis[0] + axis[1] * axis[1]), axis[2]));
    if (tally->status == l->codes.finished)
        tally->t = tops->until[top];
    tops->lane[top] = *tally;
    for (integer e = 0; e < l->sizes.events; e++)
        for (int i = 0; i < 3; i++)
            tops->functions[(i * l->sizes.events + e) * count + top] = known(l, AT_END[i], e)[lane];
    for (integer k = 0; k < l->sizes.numbers; k++)
        tops->kept[k * count + top] = l->tallies.kept[k * n + lane];
}

/* Put down the tops that have ended, and, if `settled`, those that have settled. Take others.
   Return whether the caller must look: a lane is empty, or a top has settled. */
static bool change(const Loop *l, bool settled) {
    const Queue *queue = &l->ensemble.queue;
    bool looks = false;
    for (integer lane = 0; lane < l->sizes.lanes; lane++) {
        integer status = l->tallies.lane[lane].status, *top = l->samples.in_lane + lane;
        if (*top >= 0 && status != l->codes.running) {
            if (status == l->codes.settled && !settled) {
                looks = true;
                continue;
            }
            put_down(l, lane, *top);
            queue->ended[0]++;
            *top = -1;
        }
        if (*top >= 0)
            continue;
        if (queue->waiting[0] == 0) {
            looks = true;
            continue;
        }
        *top = queue->tops[--queue->waiting[0]];
        take_top(l, lane, *top);
    }
    return looks;
}

/* --- the loop --- */

/* Whether there may be no room for what the next step finds. */
static bool is_full(const Loop *l) {
    const Sizes *n = &l->sizes;
    return (n->log > 0 && l->log.filled[0] + n->events * n->size > n->log) ||
           (n->samples > 0 && l->samples.filled[0] + n->lanes > n->samples);
}

/* Fill the lanes. Return whether no step is possible: no run is under way, or there is no room. */
bool loop_begin(const Loop *l) {
    if (l->ensemble.count > 0)
        change(l, true);
    bool runs = false;
    for (integer lane = 0; lane < l->sizes.lanes; lane++)
        runs = runs || l->tallies.lane[lane].status == l->codes.running;
    bool filled = take_rows(l, false);
    return !runs || filled || is_full(l);
}

/* Take in the step that was made. Return whether the caller must look: a run has ended and has no
   successor, a top has settled, all rows are written, or there is no room. */
bool loop_end_step(const Loop *l) {
    integer first = l->log.filled[0];
    bool ended = take_motion(l);
    for (integer k = first; k < l->log.filled[0]; k++) {
        state_at(l, 0, l->log.time[k]);
        memcpy(l->log.states + k * l->sizes.variables, l->scratch.out,
               l->sizes.variables * sizeof(real));
    }
    bool filled = take_rows(l, true);
    if (ended && l->ensemble.count > 0)
        ended = change(l, false);
    return ended || filled || is_full(l);
}

/* Make at most `most` steps of all lanes, until the caller must look. Return their number. The next
   call puts down tops that have settled, unless their status is that of a running one again. */
integer loop_drive(const Loop *l, integer most) {
    const Motion *m = &l->motion;
    /* The integrator keeps vectors on the stack: where that is not aligned, lanes are slower by 30 %. */
    _Alignas(64) volatile bool stops = loop_begin(l);
    integer steps = 0;
    for (; steps < most && !stops; steps++) {
        loop_begin_step(l);
        l->step(m->state, m->pars, m->start_high, m->h, m->tc);
        stops = loop_end_step(l);
    }
    return steps;
}

/* --- for the binding and for tests --- */

#ifndef DIGEST
#define DIGEST ""
#endif

/* A digest of this file when it was compiled. */
const char *loop_digest(void) {
    return DIGEST;
}

integer loop_structure_size(void) {
    return sizeof(Loop);
}

integer loop_crossings(const real *p, integer n, bool positive, bool monotone, const Tables *tables,
                       real *zeros) {
    return crossings(p, n, positive, monotone, tables, zeros);
}

void loop_extremes(const real *p, integer n, real least, real greatest, bool monotone,
                   const Tables *tables, Extremes *found) {
    *found = extremes(p, n, least, greatest, monotone, tables);
}

/* Count turnings, and write what each does: CONFIRMS, WAITS or their sum. */
void loop_count_turnings(Tally *tally, real noise_floor, integer n, const integer *signs,
                         const real *thetas, integer *effects) {
    for (integer k = 0; k < n; k++)
        effects[k] = take_turning(tally, noise_floor, signs[k], thetas[k]);
}

void loop_ranges(integer n, integer size, integer shift, const real *c, const real *factors,
                 real *sums, real *low, real *high, real *steady) {
    ranges(n, size, shift, c, factors, sums, low, high, steady);
}
