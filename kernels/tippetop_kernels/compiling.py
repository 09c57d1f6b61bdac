"""Kernels become machine code, by numba: the only module that needs it before something must be compiled.

What kernels call is not compiled by itself: the optimiser sees the code of an entry once and whole. numba would
optimise and compile every function of it anew for each that calls it, at twice the price.
"""

from typing import Any

import numba
from llvmlite import ir
from numba import types
from numba.core import compiler, cpu, dispatcher
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import cpu_target
from numba.core.runtime import rtsys
from numba.extending import intrinsic
from numba.np import numpy_support
from numba.np.arrayobj import populate_array

from .words import C_ORDER, F_ORDER, WRITEABLE


_Plain: Any = vars(dispatcher)["_FunctionCompiler"]
PART = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}


class _Part(JITCodeLibrary):
    """The code of a function and of those that it calls: smaller than it was written, but not compiled."""

    def finalize(self) -> None:
        self._linked()
        manager, passes = self._codegen._module_pass_manager(
            loop_vectorize=False, slp_vectorize=False, opt=0, cost="cheap"
        )
        manager.run(self._final_module, passes)
        self._done()

    def _linked(self) -> None:
        for library in dict.fromkeys(self._linking_libraries):
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)

    def _done(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True


class _Whole(_Part):
    """The code of an entry: optimised."""

    def finalize(self) -> None:
        self._linked()
        self._optimize_final_module()
        self._final_module.verify()
        self._done()

    def object_code(self) -> bytes:
        """As an object file."""
        self._ensure_finalized()
        code: bytes = self._codegen._tm.emit_object(self._final_module)
        return code


class _Compiler(_Plain):
    """Compiles a kernel into a part of what calls it."""

    apart = False  # whether its arrays share no memory

    def _compile_core(self, args: Any, return_type: Any) -> Any:
        flags: Any = compiler.Flags()
        self.targetdescr.options.parse_as_flags(flags, self.targetoptions)
        flags.no_compile, flags.noalias = True, self.apart
        context = self.targetdescr.target_context
        library = _Part(context.codegen(), self.py_func.__qualname__)
        result = compiler.compile_extra(
            self.targetdescr.typing_context, context, self.py_func, args=args, return_type=return_type, flags=flags,
            locals=self.locals, library=library, pipeline_class=self.pipeline_class,
        )  # fmt: skip
        if result.typing_error is not None:
            raise result.typing_error
        module, name = result.fndesc.lookup_module(), result.fndesc.qualname.rpartition(".")[2]
        known_as = cpu._dynfunc.make_function(module, name, "", 0, result.environment, (library,))  # nobody calls it
        context.insert_user_function(known_as, result.fndesc, [library])
        return result._replace(entry_point=known_as)


def part(kernel: Any) -> Any:
    """A kernel as numba knows it: calls of it are compiled into what calls it.

    Parameters
    ----------
    kernel
        Of `jit`.
    """
    njit: Any = numba.njit
    function = njit(**kernel.options, **PART)(kernel.py_func)
    whole = function._compiler
    function._compiler = _Compiler(
        whole.py_func, whole.targetdescr, whole.targetoptions, whole.locals, whole.pipeline_class
    )
    function._compiler.apart = kernel.apart
    if kernel.stages:
        function.stages = kernel.stages
    return function


def intrinsic_type(definition: Any) -> Any:
    """numba's type of an intrinsic."""
    known = intrinsic(definition)
    cpu_target.typing_context.refresh()
    return cpu_target.typing_context.resolve_value_type(known)


def runtime() -> None:
    """What kernels call that make arrays."""
    rtsys.initialize(cpu_target.target_context)


def type_of(kind: Any) -> Any:
    """numba's type of a kind of arguments (see `words`)."""
    if isinstance(kind, tuple) and kind[0] == "array":
        _, dtype, dimensions, flags = kind
        array: Any = types.Array
        layout = "C" if flags & C_ORDER else "F" if flags & F_ORDER else "A"
        return array(numpy_support.from_dtype(dtype), dimensions, layout, readonly=not flags & WRITEABLE)
    if isinstance(kind, tuple):
        _, record, fields = kind
        return types.BaseTuple.from_types([type_of(field) for field in fields], record)
    numbers = {int: types.int64, float: types.float64, bool: types.boolean}
    return numbers[kind] if isinstance(kind, type) else kind._numba_type_


def object_code(entry: Any, kinds: tuple) -> tuple[bytes, bool]:
    """An object file with the function `entry(words)`.

    Parameters
    ----------
    entry
        The kernel.
    kinds
        Of its arguments.

    Returns
    -------
    bytes
        The object file: the function takes a result (int64), then the words of the arguments, and gives 0.
    bool
        Whether it means the same in another process.
    """
    arguments = tuple(type_of(kind) for kind in kinds)
    function: Any = entry.dispatcher
    function._compilation_chain_init_hook()
    with global_compiler_lock:
        function.compile(arguments)
        result: Any = function.overloads[arguments]
        context = cpu_target.target_context
        library = _Whole(context.codegen(), f"entry_{entry.py_func.__name__}")
        library.add_linking_library(result.library)
        module = library.create_ir_module("entry")
        words = ir.IntType(64)
        wrapper = ir.Function(module, ir.FunctionType(ir.IntType(32), [words.as_pointer()]), "entry")
        builder = ir.IRBuilder(wrapper.append_basic_block())
        callee = context.declare_function(module, result.fndesc)
        place = iter(range(1, 1 << 20))

        def word() -> Any:
            return builder.load(builder.gep(wrapper.args[0], [ir.IntType(32)(next(place))]))

        values = [_argument(context, builder, kind, word) for kind in arguments]
        returns = result.signature.return_type
        status, value = context.call_conv.call_function(builder, callee, returns, arguments, values)
        if isinstance(returns, types.Integer):
            builder.store(builder.sext(value, words) if value.type.width < 64 else value, wrapper.args[0])
        builder.ret(builder.zext(status.is_error, ir.IntType(32)))
        library.add_ir_module(module)
        return library.object_code(), not library.has_dynamic_globals


def _argument(context: Any, builder: Any, kind: Any, word: Any) -> Any:
    """The value of an argument in LLVM's code; takes its words."""
    if isinstance(kind, types.Array):
        array = context.make_array(kind)(context, builder)
        data = builder.inttoptr(word(), array.data.type)
        shape, strides = ([word() for _ in range(kind.ndim)] for _ in range(2))
        itemsize = context.get_abi_sizeof(context.get_data_type(kind.dtype))
        populate_array(array, data, shape, strides, itemsize, meminfo=None)
        return array._getvalue()
    if isinstance(kind, types.BaseTuple):
        fields: Any = kind
        return context.make_tuple(builder, kind, [_argument(context, builder, field, word) for field in fields])
    if isinstance(kind, types.Float):
        return builder.bitcast(word(), ir.DoubleType())
    if isinstance(kind, types.Boolean):
        return builder.icmp_signed("!=", word(), ir.IntType(64)(0))
    return word() if isinstance(kind, types.Integer) else context.get_dummy_value()
