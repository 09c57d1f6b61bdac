"""What is wrong with the numbers of problems, in sentences: keys that vary, what breaks together,
starts, formulas of the user.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError, suggestion
from ..mechanics.contact.restitution import ContactLaw
from ..mechanics.friction import PARTS, SLIP, named
from ..mechanics.inlining import inlined
from ..mechanics.moment import moment
from ..mechanics.system import Form, System
from ..mechanics.units import METRE_PER_SECOND, SECOND_PER_METRE
from ..mechanics.variables import INTEGRAL_SCALE
from ..sampling import EvenTimes, ListedTimes


if TYPE_CHECKING:
    from .many import Problems
    from .one import Problem


_CONTROLS = "but it is so large that it would decide how long the steps are"


def key_faults(
    base: "Problem", keys: Iterable[str], also: Iterable[str] = (), without: tuple[str, ...] = ()
) -> list[str]:
    """What is wrong with varying these keys of a problem, in sentences; `also` are further names
    that may vary.

    Parameters
    ----------
    base
        The problem that varies.
    keys
        Dotted keys like `friction.mu`.
    also
        Names that may vary beside those of the problem.
    without
        Tables whose names may not.

    Returns
    -------
    list of str
        Empty if all may vary together.
    """
    keys, known = list(keys), [*also, *(key for key in base.rules if not key.startswith(without))]
    faults = [
        f"`{key}` must be one of {', '.join(known)}, but is not.{_hint(key, known)}"
        for key in keys
        if key not in base.rules
    ]
    names = [name for table, _, name in (key.partition(".") for key in keys) if table == "initial"]
    return faults + base.system.clashes(
        given_names(base.system.replaced(base.initial, dict.fromkeys(names))), "varies"
    )


def _short(keys: Iterable[str]) -> list[str]:
    return [key.rpartition(".")[2] for key in keys]


def _hint(key: str, known: list[str]) -> str:
    """Return what to do about a key that cannot vary."""
    table, _, name = key.rpartition(".")
    if table == "friction" and name in PARTS:
        return f" Give the scenario a `{key}`, 0 at least."
    return suggestion(name, _short(known))


def variation_faults(base: "Problem", columns: Mapping[str, Any]) -> list[str]:
    """What is wrong with the keys and the shapes of columns, in sentences.

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
    shapes = {key: np.shape(values) for key, values in columns.items() if key in base.rules}
    faults = key_faults(base, columns)
    if len(set(shapes.values())) > 1 or any(
        len(shape) != 1 or not shape[0] for shape in shapes.values()
    ):
        sizes = ", ".join(f"{key} {shape}" for key, shape in shapes.items())
        faults.append(f"`variations` must be arrays of one length and dimension, but are {sizes}.")
    return faults


def shape_faults(problem: "Problem") -> list[str]:
    """What of a problem is no record of its kind, in sentences: what cannot even be written as a
    scenario.
    """
    sequence, times = (tuple, list), (EvenTimes, ListedTimes)
    kinds = (
        ("system", System, "a System"),
        ("form", Form, "a Form of its system"),
        ("parameters", Mapping, "a mapping of names to numbers"),
        ("initial", Mapping, "a mapping of names to numbers"),
        ("times", times, "an array of times"),
        ("events", sequence, "a tuple of names"),
        ("columns", (*sequence, type(None)), "a tuple of names, or None"),
        ("sensitivities", sequence, "a tuple of names"),
        ("contact", (ContactLaw, type(None)), "a ContactLaw, or None"),
    )
    wrong = [
        (name, words) for name, kind, words in kinds if not isinstance(getattr(problem, name), kind)
    ]
    faults = [
        f"`{name}` of a Problem must be {words}, but is {getattr(problem, name)!r:.60}."
        for name, words in wrong
    ]
    if faults:
        return faults
    if named(type(problem.friction), problem.system.laws):
        return []
    return [
        "`friction` of a Problem must be the record of a known law, but is "
        f"{problem.friction!r:.60}."
    ]


def given_names(initial: Mapping[str, Any]) -> list[str]:
    """The names of initial data that are given; a flag that is false is not."""
    return [name for name, value in initial.items() if value is not False]


def together(problems: "Problems", valid: np.ndarray) -> list[tuple[int, str]]:
    """What parameters break together, for each set of them once."""
    given = problems.given("parameters")
    rows = np.stack(
        [np.broadcast_to(np.asarray(v, float), (problems.n,)) for v in given.values()], axis=1
    )
    known: dict[bytes, list[str]] = {}
    faults = []
    for i in np.flatnonzero(valid):
        key = rows[i].tobytes()
        if key not in known:
            known[key] = problems.base.system.checks(
                dict(zip(given, rows[i].tolist(), strict=True))
            )
        faults += [(int(i), sentence) for sentence in known[key][:1]]
    return faults


LARGEST = 1e150
"""Of quantities at the start, in internal units: the square of more is no number, nor is what a run
reports of it.
"""


def at_start(problems: "Problems") -> list[tuple[str, np.ndarray]]:
    """What may be wrong with a start, and where it is, (n,): numbers that are finite one by one may
    overflow together, or the model may have no solution.
    """
    base = problems.base
    if not problems.columns and base.precision == "double" and _is_sound(problems):
        return []
    plain = np.float64 if base.precision == "double" else np.longdouble
    pars, start = problems.pars.astype(float), problems.start.astype(float)
    which = 0 if problems.n == 1 else slice(None)  # numbers are faster than arrays of one
    body = problems.body_of_pars(pars[:, which].astype(plain))
    moment = problems.moment(start[:, which].astype(plain), body)
    quantities = [(q.formula, q.formula(moment, body)) for q in base.system.quantities]
    weights = np.array(problems.weights, dtype=float).reshape(len(start), -1)
    finite = np.logical_and.reduce(
        [np.isfinite(numbers).all(axis=0) for numbers in (pars, start, weights)]
    )
    own = [] if base.contact is not None else _of_law(problems)
    own += _of_ones_own(quantities, finite)
    own += _of_ones_own(
        [(e.formula, e.formula(moment, body)) for e in base.system.events if _owner(e.formula)],
        finite,
    )
    values = np.empty((len(quantities), problems.n))
    for row, (_, value) in zip(values, quantities, strict=True):
        row[:] = value
    finite = finite & (np.abs(values) < LARGEST).all(axis=0)
    overflow = (
        "`parameters`, `friction` and `initial` must stay finite together, but they overflow."
    )
    moving, names = problems.variables.moving, problems.variables.names
    return [
        *own,
        (overflow, ~finite),
        *(
            (
                f"`initial` must keep {name} within {1 / INTEGRAL_SCALE:.2g} of its unit (R, "
                f"rad), {_CONTROLS}.",
                far,
            )
            for name, far in zip(names[moving:], np.abs(start[moving:]) > 1, strict=True)
        ),
    ] + [
        (
            f"`initial` must allow a motion, but {h.meaning}.",
            ~(np.zeros(problems.n) + h.formula(moment, body) > 0),
        )
        for h in base.form.domains
    ]


def _is_sound(problems: "Problems") -> bool:
    """Return whether `at_start` has nothing to report of one run.

    Plain numbers take a third of the time of arrays.

    False also of formulas of the user, and where an operation of Python raises an error."""
    base, split = problems.base, problems.variables.split
    evaluated = _evaluated(base.system, base.form)
    if evaluated is None or _owner(SLIP.get(base.law)):
        return False
    start, pars = problems.start[:, 0].tolist(), problems.pars[:, 0].tolist()
    weights = np.array(problems.weights, dtype=float).ravel().tolist()  # numbers, or arrays of one
    try:
        values = [float(value) for value in evaluated(*split(start), problems.body_of_pars(pars))]
    except ArithmeticError:
        return False
    kept = len(base.system.quantities)
    return (
        all(map(math.isfinite, (*pars, *start, *weights)))
        and all(abs(value) < LARGEST for value in values[:kept])
        and all(abs(value) <= 1 for value in start[problems.variables.moving :])
        and all(value > 0 for value in values[kept:])
    )


@lru_cache(maxsize=64)
def _evaluated(system: System, form: Form) -> Callable | None:
    """Return the function of the values of the quantities and domains of a system; None if one, or
    an event, has a formula of the user.
    """
    read: tuple[Any, ...] = (*system.quantities, *form.domains)
    formulas = [one.formula for one in read]
    if any(map(_owner, (*formulas, *(event.formula for event in system.events)))):
        return None

    def values(q: Any, carried: Any, b: Any) -> list:
        state = moment(system, form, q, carried, b)
        return [formula(state, b) for formula in formulas]

    return inlined(values)


def _owner(formula: Any) -> str:
    """What a formula of the user is of, "the column `mine`"; empty for those of the package."""
    return getattr(formula, "of", "")


def _of_ones_own(values: list[tuple[Any, Any]], valid: np.ndarray) -> list[tuple[str, np.ndarray]]:
    """Where formulas of the user, given with their values at the start, are not finite though the
    numbers are.
    """
    faults = []
    for formula, value in values:
        bad = valid & ~np.isfinite(np.asarray(value, dtype=float))
        if _owner(formula) and bad.any():
            what = np.broadcast_to(np.asarray(value, dtype=float), bad.shape)[bad][0]
            faults.append(
                (
                    f"the formula of {_owner(formula)} must be finite at the start, but is {what}.",
                    bad,
                )
            )
    return faults


PLACES = [(v2, z) for v2 in (0.0, 1e-6, 1e-4, 1e-2, 1.0) for z in (1.0, 0.0, -1.0)]
"""|v_A|^2 [m^2/s^2] and cos(theta) at which a law of the user is asked."""


def _of_law(problems: "Problems") -> list[tuple[str, np.ndarray]]:
    """Where a friction law of the user feeds energy, or is no number: at rest or in motion,
    wherever the contact is.
    """
    kind, n = type(problems.base.friction), problems.n
    if not (words := _owner(SLIP.get(kind))):
        return []
    law = kind._make(np.zeros(n) + number for number in problems.given("friction").values())
    for v2, z in PLACES:
        k = np.zeros(n) + SLIP[kind](np.full(n, v2), np.full(n, z), law)
        if (bad := ~(np.isfinite(k) & (k >= 0))).any():
            value = k[bad][0]
            must = (
                "be at least 0, or friction feeds energy," if np.isfinite(value) else "be finite,"
            )
            at = f"{value:g} s/m at |v_A| = {v2**0.5:g} m/s, cos(theta) = {z:g}"
            return [(f"the coefficient k of {words} must {must} but is {at}.", bad)]
    for z in (1.0, 0.0, -1.0):
        place = np.full(n, z)
        if (
            rough := _has_no_slope(lambda v2, z=place: SLIP[kind](v2 + 0 * z, z, law) + 0 * z)
        ).any():
            must = "be smooth in v2 = |v_A|^2 at rest (sqrt(v2 + v_0^2) for |v_A|)"
            at = f"its slope is infinite there, at cos(theta) = {z:g}"
            return [(f"the coefficient k of {words} must {must}, but {at}.", rough)]
    return _of_units(problems, words, law)


SAME = 1e-6
"""Relative difference by which what keeps a root from 0 may show, such as sqrt(v2 + 1e-20)."""


def _of_units(problems: "Problems", words: str, law: Any) -> list[tuple[str, np.ndarray]]:
    """Where the coefficient of a law of the user is another in the units of the integration: it has
    a number in it that has a unit.
    """
    kind, scales, n = type(law), problems.scales, problems.n
    units = problems.base.law.units()
    scaled = kind._make(v / scales.of(u).astype(float) for v, u in zip(law, units, strict=True))
    speed, slowness = (
        scales.of(unit).astype(float) for unit in (METRE_PER_SECOND, SECOND_PER_METRE)
    )
    for v2, z in PLACES[3:]:  # at rest, what keeps a root from 0 decides
        there = np.full(n, z)
        k = SLIP[kind](np.full(n, v2), there, law) + np.zeros(n)
        again = (SLIP[kind](v2 / speed**2, there, scaled) + np.zeros(n)) * slowness
        if (bad := ~(abs(k - again) <= SAME * abs(k))).any():
            what = (
                f"at |v_A| = {v2**0.5:g} m/s it is {k[bad][0]:g} s/m, and {again[bad][0]:g} "
                "s/m in those of the run"
            )
            cause = "a number that has a unit must be a parameter of the law"
            return [
                (
                    f"the coefficient k of {words} must be the same in all units, but {what}: "
                    f"{cause}.",
                    bad,
                )
            ]
    return []


def _has_no_slope(k: Callable) -> np.ndarray:
    """Where a function of v2 rises from 0 as a power below 1, by its imaginary part at imaginary
    v2: to no difference's rounding, and by powers of two, so that where the slope is 0 the rounding
    of both is the same.
    """
    try:
        with np.errstate(all="ignore"):
            far, near = (np.abs(np.imag(k(1j * v2))) for v2 in (2.0**-166, 2.0**-332))
    except InputError as error:
        if isinstance(error.__cause__, TypeError):  # atan2 takes no complex numbers
            return np.zeros(1, bool)
        raise
    return (far > 0) & (far < 0.9 * 2.0**166 * near)
