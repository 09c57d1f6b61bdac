"""Sentences on the numbers of problems: keys that vary, contradictions, starts, user formulas.

`Problems.checked` and `scenario.build` call these functions; they return sentences for InputError.
`refuse` raises it for what has no derivatives.
"""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError, owner, suggestion
from ..mechanics.contact.surroundings import RULES, TABLES
from ..mechanics.friction import PARTS
from ..mechanics.moment import moment
from ..mechanics.units import METRE_PER_SECOND, SECOND_PER_METRE
from ..mechanics.variables import INTEGRAL_SCALE


if TYPE_CHECKING:
    from .batch import Problems
    from .problem import Problem


Fault = tuple[str, np.ndarray]
"""A sentence, and the runs on which it is, (n,) of bool."""

LARGEST = 1e150
"""Of quantities at the start, in internal units: the square of a larger one overflows."""

PLACES = [(v2, z) for v2 in (0.0, 1e-6, 1e-4, 1e-2, 1.0) for z in (1.0, 0.0, -1.0)]
"""|v_A|^2 [m^2/s^2] and cos(theta) at which a law of the user is tried."""

SAME = 1e-6
"""Relative difference that a constant which keeps a root from 0 may cause: sqrt(v2 + 1e-20)."""


def key_faults(base: "Problem", keys: Collection[str], known: Collection[str]) -> list[str]:
    """Return sentences on varying these keys of a problem.

    Parameters
    ----------
    base
        The problem that varies.
    keys
        Dotted keys like `friction.mu`.
    known
        Names that may vary.

    Returns
    -------
    list of str
        Empty if all may vary together.
    """
    faults = []
    for key in keys:
        if key not in known:
            table, _, name = key.rpartition(".")
            hint = suggestion(name, [k.rpartition(".")[2] for k in known])
            if table == "friction" and name in PARTS:
                hint = f" Give the scenario a `{key}`, 0 at least."
            if name in RULES.get(table, {}):
                hint = f" Give the scenario a `{key}`."
            faults.append(f"`{key}` must be one of {', '.join(known)}, but is not.{hint}")
    varied = [key.partition(".")[2] for key in keys if key.startswith("initial.")]
    start = base.system.replaced(base.initial, dict.fromkeys(varied))
    return faults + base.system.clashes(start, "varies")


def refuse(problem: "Problem", wrt: Sequence[str]) -> None:
    """Raise InputError for a run that has no derivatives, and for wrong names.

    `wrt` are dotted keys of the numbers by which a run is differentiated.
    """
    if problem.precision != "double":
        raise InputError(
            '`run.precision` must be "double" for derivatives and fits, but is '
            f'"{problem.precision}".'
        )
    if problem.origin is not None:
        raise InputError(
            "`initial.from` must not be given for derivatives and fits, which begin at a start."
        )
    added = {name.partition(".")[2]: 0.0 for name in wrt if name.startswith("initial.")}
    known = [key for key in problem.rules if not key.startswith("run.")]
    faults = key_faults(problem, wrt, known)
    if faults := faults or problem.system.clashes({**problem.initial, **added}):
        raise InputError(faults)


def variation_faults(base: "Problem", columns: Mapping[str, Any]) -> list[str]:
    """Return sentences on the keys and the shapes of columns.

    Parameters
    ----------
    base
        The problem that varies.
    columns
        Arrays by dotted key; they must have one shape (n,), n > 0.

    Returns
    -------
    list of str
        Empty if nothing is wrong.
    """
    if not columns:
        return ["`variations` must vary something, but is empty."]
    faults = key_faults(base, columns, base.rules)
    shapes = {key: np.shape(values) for key, values in columns.items() if key in base.rules}
    if len({*shapes.values()}) > 1 or any(len(s) != 1 or not s[0] for s in shapes.values()):
        sizes = ", ".join(f"{key} {shape}" for key, shape in shapes.items())
        faults.append(f"`variations` must be arrays of one length and dimension, but are {sizes}.")
    return faults


def contradictions(problems: "Problems", valid: np.ndarray) -> list[tuple[int, str]]:
    """Return the first sentence on parameters that contradict each other, by number of the run."""
    given = problems.given("parameters")
    faults = []
    rows = np.broadcast_arrays(np.zeros(problems.n), *given.values())[1:]
    for i in np.flatnonzero(valid).tolist():
        row = {name: float(column[i]) for name, column in zip(given, rows, strict=True)}
        faults += [(i, sentence) for sentence in problems.base.system.checks(row)[:1]]
    return faults


def start_faults(problems: "Problems") -> list[Fault]:
    """Return sentences on the starts: numbers that overflow together, or no motion from there.

    `Problems.checked` reports the first one on each run, so causes come before consequences.
    """
    base = problems.base
    n = problems.n
    variables = problems.variables
    domains = base.form.domains
    plain = np.float64 if base.precision == "double" else np.longdouble
    start, pars = (a.astype(float).astype(plain) for a in (problems.start, problems.pars))
    which = 0 if n == 1 else slice(None)  # numbers are faster than arrays of one
    body = problems.body_of_pars(pars[:, which])
    state = moment(base.form, *variables.split(start[:, which]), body)

    def values(formulas: Iterable[Callable]) -> np.ndarray:
        """Return the values of formulas(state, body) at the starts, (formulas, n), internal."""
        rows = [np.broadcast_to(formula(state, body), n) for formula in formulas]
        return np.array(rows, float).reshape(-1, n)

    weights = np.array(problems.weights, dtype=float).reshape(len(start), -1)
    finite = np.isfinite(np.concatenate([pars, start * weights])).all(axis=0)
    faults = _law_faults(problems)
    own: list[Any] = [*base.system.quantities, *base.system.events]
    if base.system.contact is not None:  # they may read the reaction, which is not known yet
        own = []
    limits = [domain.formula for domain in domains]
    for formula in filter(owner, [*limits, *(one.formula for one in own)]):
        (found,) = values([formula])
        if (bad := finite & ~np.isfinite(found)).any():
            words = f"must be finite at the start, but is {found[bad][0]}."
            faults.append((f"the formula of {owner(formula)} {words}", bad))
    numbers = [f"`{name}`" for name in ("parameters", "friction", *TABLES) if name in base.tables]
    together = f"{', '.join(numbers)} and `initial` must stay finite together, but they overflow."
    known = values(limits)
    ours = values(q.formula for q in base.system.quantities if not owner(q.formula))
    # not where a domain is left by a finite amount: that is the cause then, and is reported below
    overflows = ~finite | ~(abs(ours) < LARGEST).all(axis=0)
    faults.append((together, overflows & ~((known <= 0) & (known > -LARGEST)).any(axis=0)))
    large = abs(start[variables.moving :]) > 1
    for i in _rows(large):
        name = variables.names[variables.moving + i]
        sentence = (
            f"`initial` must keep {name} within {1 / INTEGRAL_SCALE:.2g} of its unit (R, rad), but "
            "it is so large that it would decide how long the steps are."
        )
        faults.append((sentence, large[i]))
    outside = ~(known > 0)
    for i in _rows(outside):
        sentence = f"`initial` must allow a motion, but {domains[i].meaning}."
        faults.append((sentence, outside[i]))
    return faults


def _rows(bad: np.ndarray) -> Iterable[int]:
    """Return the indices of the rows of `bad` (rows, n) that are true somewhere, ascending."""
    return dict.fromkeys(np.nonzero(bad)[0].tolist())


def _law_faults(problems: "Problems") -> list[Fault]:
    """Return the first fault of a friction law of the user.

    Its coefficient must be finite, not negative, smooth at rest, and the same in all units.
    """
    kind = type(problems.base.friction)
    n = problems.n
    if not (of := owner(kind.coefficient)):
        return []
    law = kind._make(np.zeros(n) + number for number in problems.given("friction").values())

    def coefficient(v2: Any, z: float, law: Any) -> np.ndarray:
        """Return k [s/m] of the law of each problem, (n,), as a function of v2 and z, numbers."""
        return kind.coefficient(np.zeros(n) + v2, np.full(n, z), law) + np.zeros(n)

    def fault(must: str, found: str, bad: np.ndarray) -> list[Fault]:
        """Return a fault for the problems in which k is bad, (n,) of bool."""
        return [(f"the coefficient k of {of} must {must}, but {found}.", bad)]

    for v2, z in PLACES:
        k = coefficient(v2, z, law)
        if (bad := ~(np.isfinite(k) & (k >= 0))).any():
            must = (
                "be at least 0, or friction feeds energy" if np.isfinite(k[bad][0]) else "be finite"
            )
            at = f"is {k[bad][0]:g} s/m at |v_A| = {v2**0.5:g} m/s, cos(theta) = {z:g}"
            return fault(must, at, bad)
    for z in (1.0, 0.0, -1.0):
        if (bad := _has_no_slope(lambda v2, z=z: coefficient(v2, z, law))).any():
            must = "be smooth in v2 = |v_A|^2 at rest (sqrt(v2 + v_0^2) for |v_A|)"
            return fault(must, f"its slope is infinite there, at cos(theta) = {z:g}", bad)
    units = problems.base.law.units()
    scaled = kind._make(v / problems.unit(u) for v, u in zip(law, units, strict=True))
    speed, slowness = map(problems.unit, (METRE_PER_SECOND, SECOND_PER_METRE))
    # without the three places at rest, where a constant that keeps a root from 0 decides
    for v2, z in PLACES[3:]:
        k = coefficient(v2, z, law)
        again = coefficient(v2 / speed**2, z, scaled) * slowness
        if (bad := ~(abs(k - again) <= SAME * abs(k))).any():
            found = (
                f"at |v_A| = {v2**0.5:g} m/s it is {k[bad][0]:g} s/m, and {again[bad][0]:g} s/m in "
                "those of the run: a number that has a unit must be a parameter of the law"
            )
            return fault("be the same in all units", found, bad)
    return []


def _has_no_slope(k: Callable) -> np.ndarray:
    """Return where k(v2) rises from v2 = 0 as a power below 1, (n,) of bool.

    By its imaginary part at imaginary v2, without the rounding of a difference; of powers of two,
    so that the rounding of both is the same where the slope is 0.
    """
    try:
        with np.errstate(all="ignore"):
            far, near = (np.abs(np.imag(k(1j * v2))) for v2 in (2.0**-166, 2.0**-332))
    except InputError as error:
        if isinstance(error.__cause__, TypeError):  # atan2 takes no complex numbers
            return np.zeros(1, bool)
        raise
    return (far > 0) & (far < 0.9 * 2.0**166 * near)
