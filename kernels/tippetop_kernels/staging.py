"""Long formulas worked in stages: 45 ns a point of the minimal surface instead of 58 to 67.

Timed on 1000 x 1000 points, one core of a busy Intel Xeon (2.5 GHz); the price is some 10 s more of
compilation.

A record is a number, or a (named) tuple of records. Its leaf number i of point j lies at
table[i*BLOCK + j]: so a loop over neighbouring points fills the SIMD lanes of one instruction, and
as the distances are known to the compiler, the code need not test at run time whether columns
overlap.

A stage is a loop of its own. In one long chain of dependent operations the processor waits, as it
sees only some 200 operations ahead; of a short one it has several turns in flight.
"""

from typing import Any

from llvmlite import ir
from numba import extending, types
from numba.extending import overload


intrinsic: Any = extending.intrinsic
BLOCK = 256  # points: ten columns of it and their neighbours stay in the first cache


def _leaves(kind: Any, path: tuple = ()) -> list[tuple]:
    """The places of the doubles in an LLVM aggregate, in order."""
    if isinstance(kind, ir.ArrayType):
        return [leaf for i in range(kind.count) for leaf in _leaves(kind.element, (*path, i))]
    if isinstance(kind, ir.LiteralStructType):
        return [leaf for i, k in enumerate(kind.elements) for leaf in _leaves(k, (*path, i))]
    if not isinstance(kind, ir.DoubleType):
        raise TypeError(f"A record must be made of doubles, but has {kind}.")
    return [path]


def _place(context: Any, builder: Any, kind: Any, table: Any, leaf: int, j: Any) -> Any:
    """Pointer to leaf number `leaf` of point j."""
    data = context.make_array(kind)(context, builder, table).data
    return builder.gep(data, [builder.add(j, ir.Constant(j.type, leaf * BLOCK))])


@intrinsic
def width(typing, record):
    """How many doubles a record like this one has."""

    def generate(context, builder, signature, arguments):
        leaves = _leaves(context.get_value_type(signature.args[0]))
        return context.get_constant(types.intp, len(leaves))

    return types.intp(record), generate


@intrinsic
def put(typing, table, j, record):
    """Keeps a record as point j of the table."""

    def generate(context, builder, signature, arguments):
        table, j, record = arguments
        for i, path in enumerate(_leaves(record.type)):
            leaf = builder.extract_value(record, path) if path else record
            builder.store(leaf, _place(context, builder, signature.args[0], table, i, j))
        return context.get_dummy_value()

    return types.void(table, types.intp, record), generate


@intrinsic
def get(typing, table, j, like):
    """Point j of the table, a record like `like`."""

    def generate(context, builder, signature, arguments):
        table, j, like = arguments
        record = ir.Constant(like.type, None)
        for i, path in enumerate(_leaves(like.type)):
            leaf = builder.load(_place(context, builder, signature.args[0], table, i, j))
            record = builder.insert_value(record, leaf, path) if path else leaf
        return record

    return like(table, types.intp, like), generate


STAGES: dict[Any, tuple] = {}
"""The stages of a formula, up to three: each takes the result of the one before it, and the
arguments.
"""


def first(whole, *arguments) -> Any:
    """The result of the first stage; of the whole, where it has no stages.

    Inside numba only, as are the next two.
    """
    raise NotImplementedError


def second(whole, before, *arguments) -> Any:
    """The result of the second stage, given that of the first; the same, where it has no second."""
    raise NotImplementedError


def third(whole, before, *arguments) -> Any:
    """The result of the third stage, given that of the second; the same, where it has no third."""
    raise NotImplementedError


@overload(first, jit_options={"error_model": "numpy", "forceinline": True})
def _(whole, *arguments):
    stage = STAGES.get(whole.typing_key, (whole.typing_key,))[0]
    return lambda whole, *arguments: stage(*arguments)


def _later(number: int) -> Any:
    def chosen(whole, before, *arguments):
        stages = STAGES.get(whole.typing_key, ())
        if len(stages) <= number:
            return lambda whole, before, *arguments: before
        stage = stages[number]
        return lambda whole, before, *arguments: stage(before, *arguments)

    return chosen


for _number, _name in ((1, second), (2, third)):
    overload(_name, jit_options={"error_model": "numpy", "forceinline": True})(_later(_number))
