"""States at eight times of a Taylor step at once, in the processor's vectors: a fourth of the time of one by one.

The sums are compensated, and have the bits of those that the compiled step itself makes of one time (`compiled_step`).
Where LLVM optimises that code, it rounds a product and the difference that takes it at once: `rounding_of` tells.
"""

from fractions import Fraction
from typing import Any

import numpy as np

from .compiled_step import call
from .jit import intrinsic


TIMES = 8  # at once
VARIABLES = 4  # at once: the processor has that many sums to make side by side while each waits for its last addition
UNKNOWN, SEPARATE, FUSED = 0, 1, 2  # how compiled code rounds a product and the difference that takes it
TRIALS = 4


def rounding_of(dense: int, variables: int, order: int) -> int:
    """How the dense output of a compiled step rounds.

    Parameters
    ----------
    dense
        Its address.
    variables, order
        Of the Taylor coefficients.

    Returns
    -------
    int
        SEPARATE, FUSED; UNKNOWN if neither has its bits, or both have.
    """
    random = np.random.default_rng(order)
    alike = {SEPARATE, FUSED}
    for _ in range(TRIALS):
        tc, h = random.normal(size=(variables, order + 1, 1)), random.uniform(0.5, 1.0, 1)
        tc[:, 0] = -(tc[:, 1:, 0] @ h ** np.arange(1, order + 1))[:, None]  # what is left is rounding
        out = np.zeros((variables, 1))
        call(dense, out, tc, h)
        polynomials, given = tc[..., 0].tolist(), out[:, 0].tolist()
        alike = {kind for kind in alike if given == [_sum(c, float(h[0]), kind) for c in polynomials]}
        if len(alike) < 2:
            break
    return alike.pop() if len(alike) == 1 else UNKNOWN


def _sum(coefficients: list[float], h: float, kind: int) -> float:
    """The compensated sum of a polynomial."""
    (total, *others), rest, power = coefficients, 0.0, h
    for c in others:
        more = c * power - rest if kind == SEPARATE else float(Fraction(c) * Fraction(power) - Fraction(rest))
        new = total + more
        rest = (new - total) - more
        total, power = new, power * h
    return total


def _sums(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    from llvmlite import ir

    integer, vector = ir.IntType(64), ir.VectorType(ir.DoubleType(), TIMES)
    tc, when, out = (context.make_array(signature.args[i])(context, builder, value=arguments[i]) for i in (0, 2, 3))
    fuses = builder.icmp_signed("==", arguments[4], ir.IntType(64)(FUSED))
    variables, size = builder.extract_value(tc.shape, 0), builder.extract_value(tc.shape, 1)

    def place(data: Any) -> Any:
        return builder.bitcast(data, vector.as_pointer())

    def rows(first: Any) -> list[Any]:  # of coefficients; the last one again where there are no more
        last = builder.sub(variables, integer(1))
        each = [builder.add(first, integer(i)) for i in range(VARIABLES)]
        within = [builder.select(builder.icmp_signed("<", i, last), i, last) for i in each]
        return [builder.gep(tc.data, [builder.mul(i, size)]) for i in within]

    def spread(number: Any) -> Any:
        one = builder.insert_element(ir.Constant(vector, ir.Undefined), number, ir.IntType(32)(0))
        return builder.shuffle_vector(one, one, ir.Constant(ir.VectorType(ir.IntType(32), TIMES), [0] * TIMES))

    data = rows(arguments[1])
    h = builder.load(place(when.data), align=8)
    starts = [spread(builder.load(row)) for row in data]

    name = f"llvm.fma.v{TIMES}f64"  # llvmlite's own is of single numbers
    fma = builder.module.globals.get(name) or ir.Function(builder.module, ir.FunctionType(vector, [vector] * 3), name)

    def summed(fused: bool) -> None:
        before = builder.block
        loop, after = builder.append_basic_block("power"), builder.append_basic_block("summed")
        builder.branch(loop)
        builder.position_at_end(loop)
        k, power = builder.phi(integer), builder.phi(vector)
        sums, rests = ([builder.phi(vector) for _ in data] for _ in range(2))
        k.add_incoming(integer(1), before)
        power.add_incoming(h, before)
        for row, total, rest, start in zip(data, sums, rests, starts, strict=True):
            total.add_incoming(start, before)
            rest.add_incoming(ir.Constant(vector, [0.0] * TIMES), before)
            c = spread(builder.load(builder.gep(row, [k])))
            more = (
                builder.call(fma, [c, power, builder.fneg(rest)])
                if fused
                else builder.fsub(builder.fmul(c, power), rest)
            )
            new = builder.fadd(total, more)
            rest.add_incoming(builder.fsub(builder.fsub(new, total), more), loop)
            total.add_incoming(new, loop)
        power.add_incoming(builder.fmul(power, h), loop)
        following = builder.add(k, integer(1))
        k.add_incoming(following, loop)
        builder.cbranch(builder.icmp_signed("<", following, size), loop, after)
        builder.position_at_end(after)
        for i, total in enumerate(sums):
            builder.store(total.incomings[1][0], place(builder.gep(out.data, [integer(i * TIMES)])), align=8)

    with builder.if_else(fuses) as (then, otherwise):
        with then:
            summed(fused=True)
        with otherwise:
            summed(fused=False)
    return context.get_dummy_value()


@intrinsic
def sums(typing, tc, first, when, out, rounding):
    """The values of the variables `first` and the next ones at the times `when` (TIMES,) after the beginning of the
    step with the Taylor coefficients tc (variables, order + 1, 1), into out (VARIABLES, TIMES); SEPARATE or FUSED."""
    from numba import types

    return types.void(tc, first, when, out, rounding), _sums
