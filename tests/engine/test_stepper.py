"""Machine code from elsewhere: what cannot be called is refused with a sentence, and never ends the
process.
"""

import ctypes
import subprocess
import sys

import llvmlite.binding as llvm
import numpy as np

from tippetop.engine.stepper import load


SCALED = """
declare double @{calls}(double)
define void @step(ptr %state, ptr %pars, ptr %time, ptr %h, ptr %tc) {{
  %x = load double, ptr %state
  %y = call double @{calls}(double %x)
  store double %y, ptr %state
  ret void
}}
define void @{second}(ptr %out, ptr %tc, ptr %h) {{
  ret void
}}
"""


def object_of(calls: str = "sin", second: str = "d_out_f", triple: str = "") -> bytes:
    """An object file whose step calls a function of that name."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_triple(triple or llvm.get_process_triple()).create_target_machine(
        jit=True
    )
    return machine.emit_object(llvm.parse_assembly(SCALED.format(calls=calls, second=second)))


def test_a_loaded_step_is_called() -> None:
    machine, state, other = load([object_of()], 3), np.array([0.5, 7.0]), np.zeros(3)
    step = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 5)(machine.step)
    step(state.ctypes.data, *[other.ctypes.data] * 4)
    assert state.tolist() == [np.sin(0.5), 7.0]


def test_nothing_of_this_aborts_a_process() -> None:
    """LLVM ends the process when it is asked to bind a function that it does not find: it is never
    asked.
    """
    code = f"""
from tippetop.engine.stepper import load
for code in ({object_of("no_such_function_anywhere")!r}, b"", {object_of(second="other")!r}):
    try:
        load([code], 3)
    except ImportError as error:
        print("refused")
"""
    assert printed(code) == "refused\n" * 3


def printed(code: str) -> str:
    """Run code in a process of its own and return what it prints."""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


FRAGMENTED = """
import ctypes
from tippetop.engine import taylor
from tippetop.runs import starting

driver = taylor.driver_of(starting.load("inverting", until=0.1))
code = driver.workspace.compiled.integrator.llvm_state.object_code
libc = ctypes.CDLL(None)
place, number = [ctypes.c_void_p, ctypes.c_size_t], ctypes.c_int
libc.mmap.restype = ctypes.c_void_p
libc.mmap.argtypes = [*place, number, number, number, ctypes.c_long]
libc.munmap.argtypes = place


def reserved(size):
    return libc.mmap(None, size, 0, 0x4022, -1, 0)  # private, anonymous, without a page of memory


end = reserved(6 << 30) + (6 << 30)
filled = [reserved(1 << k) for k in range(22, 11, -1) for _ in range(200)]  # other holes
for hole in range(400):  # of a page each, 6 GB from the next large one
    libc.munmap(end - (2 * hole + 1) * 4096, 4096)
from tippetop.engine.stepper import load

print(load([code], 3).step > 0)
"""


def test_memory_in_pieces_does_not_abort_a_process() -> None:
    """The constants of an object fit into a hole of the memory that is far from where its code
    fits: LLVM's older linker ended the process, as it did a session of 2400 tests.
    """
    assert printed(FRAGMENTED) == "True\n"
