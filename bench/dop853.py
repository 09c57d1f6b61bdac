"""DOP853 (Dormand and Prince 8(5,3), step control as in SciPy's), compiled with the right-hand side
inside: the loops over the state have a fixed length and the sums of the stages are written out
without their zeros, as one would by hand.
"""

import ctypes

import numpy as np
from scipy.integrate._ivp import dop853_coefficients as table

from .minimal import Minimal, built


STAGES = table.N_STAGES


def source(n: int, slope: str) -> str:
    """The solver for n variables.

    `dop853(y, times, count, tolerance, rows)` gives the number of right-hand sides.
    """
    stages = "\n".join(
        f"    FOR {{ w[i] = y[i] + h * ({_sum(table.A[s, :s])}); }}\n    slope(w, K[{s}]);"
        for s in range(1, STAGES)
    )
    return f"""#include <cmath>
#include <algorithm>
{slope}
#define FOR for (int i = 0; i < {n}; ++i)
extern "C" long dop853(const double* start, const double* times, int count,
                       double tolerance, double* rows) {{
  double y[{n}], w[{n}], K[{STAGES + 1}][{n}];
  double t = times[0], h = 1e-3;
  long calls = 1;
  bool rejected = false;
  FOR {{ y[i] = rows[i] = start[i]; }}
  slope(y, K[0]);
  for (int k = 1; k < count; ++k) {{
    const double end = times[k];
    while (t < end) {{
      const double wanted = h;
      const bool last = t + 1.000001 * h >= end;
      if (last) h = end - t;
{stages}
      FOR {{ w[i] = y[i] + h * ({_sum(table.B)}); }}
      slope(w, K[{STAGES}]);
      calls += {STAGES};
      double five = 0, three = 0;
      FOR {{
        const double scale = tolerance + tolerance * std::max(std::abs(y[i]), std::abs(w[i]));
        const double e5 = ({_sum(table.E5)}) / scale, e3 = ({_sum(table.E3)}) / scale;
        five += e5 * e5;
        three += e3 * e3;
      }}
      const double error = five + three > 0 ? h * five / std::sqrt((five + 0.01 * three) * {n}) : 0;
      if (!std::isfinite(error)) return -1;
      if (error < 1) {{
        double factor = error == 0 ? 10 : std::min(10.0, 0.9 * std::pow(error, -0.125));
        if (rejected) factor = std::min(1.0, factor);
        t = last ? end : t + h;
        FOR {{ y[i] = w[i]; K[0][i] = K[{STAGES}][i]; }}
        h *= factor;
        if (last) h = std::max(h, wanted);
        rejected = false;
      }} else {{
        h *= std::max(0.2, 0.9 * std::pow(error, -0.125));
        rejected = true;
      }}
    }}
    FOR {{ rows[k * {n} + i] = y[i]; }}
  }}
  return calls;
}}
"""


def _sum(weights: np.ndarray) -> str:
    return " + ".join(f"{float(a)!r} * K[{j}][i]" for j, a in enumerate(weights) if a)


class Compiled:
    """The solver of a problem."""

    def __init__(self, minimal: Minimal):
        self.minimal, self.n = minimal, len(minimal.names)
        self.function = built(source(self.n, minimal.source)).dop853
        self.function.restype = ctypes.c_long
        pointer = np.ctypeslib.ndpointer(float, flags="C_CONTIGUOUS")
        self.function.argtypes = [pointer, pointer, ctypes.c_int, ctypes.c_double, pointer]
        self.calls = 0

    def __call__(self, tolerance: float) -> np.ndarray:
        """States at 0 and the samples, (k + 1, n)."""
        minimal = self.minimal
        rows = np.empty((len(minimal.times), self.n))
        self.calls = self.function(
            minimal.start, minimal.times, len(minimal.times), tolerance, rows
        )
        if self.calls < 0:
            raise ArithmeticError("DOP853 came to a state that is not finite.")
        return rows
