"""A system as heyoka expressions: for the integrator, and for functions over arrays that are compiled like it."""

from functools import lru_cache
from typing import Any

import heyoka as hy

from ..mechanics.operand import cos, leaves, refill, sin
from ..mechanics.system import Form, System
from ..problem import QUADRATURE_SCALE


def symbolic_body(system: System, form: Form, friction: Any, *, by_parameters: bool = False) -> Any:
    """The body in run-time parameters, internal units.

    These are the leaves of the body, `Problems.pars`; what is 0 or 1 by construction is a number, so that expressions
    fold. `by_parameters`: they are what the user gives, `Problems.parameters`, and all of it: for derivatives by alpha,
    m, R, mu, ..., in fixed units.
    """
    if by_parameters:
        pars = iter(hy.par[i] for i in range(len(system.parameters) + len(friction._fields)))
        return system.body_of({name: next(pars) for name in system.parameters}, friction(*pars))
    template = system.body_of(dict.fromkeys(system.parameters, 1.0), friction(*(1.0 for _ in friction._fields)))
    count = iter(range(len(leaves(template))))
    return refill(template, (hy.par[i] for i in count))._replace(**system.folds(form))


def variables(
    system: System, form: Form, friction: Any, *, by_parameters: bool = False
) -> tuple[Any, Any, list[tuple]]:
    """State and body as heyoka expressions, and the equations of motion, in internal units; see `symbolic_body`."""
    state = hy.make_vars(*form.units._fields)
    scaled = [v / QUADRATURE_SCALE if v_ in form.quadratures else v for v, v_ in zip(state, form.units._fields)]  # noqa: B905
    record = type(form.units)(*scaled)
    body = symbolic_body(system, form, friction, by_parameters=by_parameters)
    rates = form.rates(record, body)
    equations = [
        (v, hy.expression(0.0) + (QUADRATURE_SCALE * rate if name in form.quadratures else rate))
        for v, name, rate in zip(state, form.units._fields, rates, strict=True)
    ]
    return record, body, equations


def observed(system: System, form: Form, record: Any, body: Any) -> dict[str, Any]:
    """All that a row says, by name, in internal units: angles, vectors, quantities; of arrays or of expressions.

    `_s2` and `_axis_speed2` come along where a system has poles; the integrated axis, `_ux` and so on, where the form
    has one that is not what `axis` is taken from.
    """
    scalars, angles = form.scalars(record, body), form.to_angles(record, body)
    values = dict(angles._asdict())
    if system.vectors:
        vector, direct = system.forms["vector"], form.name == "vector"
        state = record if direct else vector.of_angles(angles, sin(angles.theta), cos(angles.theta), body)
        values |= {name: getattr(state, name) for names in system.vectors.values() for name in names}
        if not direct and integrates_axis(system, form):
            values |= {f"_{name}": getattr(record, name) for name in system.vectors["axis"]}
    values |= {quantity.name: quantity.formula(scalars, body) for quantity in system.quantities}
    if hasattr(scalars, "axis_speed2"):
        values |= {"_s2": scalars.s2, "_axis_speed2": scalars.axis_speed2}
    return values


def integrates_axis(system: System, form: Form) -> bool:
    """Whether the form integrates the components of 3hat, whose length must then stay 1."""
    axis = system.vectors.get("axis", ())
    return bool(axis) and set(axis) <= set(form.units._fields)


@lru_cache(maxsize=32)
def table(system: System, form_name: str, friction: Any) -> tuple[tuple[str, ...], Any]:
    """Names of what `observed` gives, and the compiled function f(inputs=(variables, n), pars=(leaves, n)) of it.

    11 ns a row where numpy takes 590: that is what lets a store keep pace with the integrator.
    """
    form = system.forms[form_name]
    record, body, equations = variables(system, form, friction)
    values = observed(system, form, record, body)
    outputs = [hy.expression(0.0) + value for value in values.values()]
    return tuple(values), hy.cfunc(outputs, vars=[variable for variable, _ in equations])
