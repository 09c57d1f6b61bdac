"""States at eight times of a Taylor step at once, in the processor's vectors: a fourth of the time of one by one.

The sums are compensated, and have the bits of those that the compiled step itself makes of one time (`compiled_step`).
"""

from typing import Any

from .jit import intrinsic


TIMES = 8  # at once
VARIABLES = 4  # at once: the processor has that many sums to make side by side while each waits for its last addition


def _sums(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    from llvmlite import ir

    integer, vector = ir.IntType(64), ir.VectorType(ir.DoubleType(), TIMES)
    tc, when, out = (context.make_array(signature.args[i])(context, builder, value=arguments[i]) for i in (0, 2, 3))
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
        term = builder.fmul(spread(builder.load(builder.gep(row, [k]))), power)
        more = builder.fsub(term, rest)
        new = builder.fadd(total, more)
        rest.add_incoming(builder.fsub(builder.fsub(new, total), more), loop)
        total.add_incoming(new, loop)
    power.add_incoming(builder.fmul(power, h), loop)
    following = builder.add(k, integer(1))
    k.add_incoming(following, loop)
    builder.cbranch(builder.icmp_signed("<", following, size), loop, after)
    builder.position_at_end(after)
    for i, total in enumerate(sums):
        sum_of = total.incomings[1][0]
        builder.store(sum_of, place(builder.gep(out.data, [integer(i * TIMES)])), align=8)
    return context.get_dummy_value()


@intrinsic
def sums(typing, tc, first, when, out):
    """The values of the variables `first` and the next ones at the times `when` (TIMES,) after the beginning of the
    step with the Taylor coefficients tc (variables, order + 1, 1), into out (VARIABLES, TIMES)."""
    from numba import types

    return types.void(tc, first, when, out), _sums
