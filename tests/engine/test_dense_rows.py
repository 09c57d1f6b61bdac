"""The rows of a step, many at once or one alone, have the same bits, however LLVM rounds the code
that gives one.
"""

from collections.abc import Iterator

import llvmlite.binding as llvm
import numpy as np
import pytest

from tippetop.engine import taylor
from tippetop.engine.compiled import compiled_from
from tippetop.engine.opt_level import OPT_LEVEL
from tippetop.engine.stepper import Loaded, is_fused, load
from tippetop.runs.run import solve
from tippetop.scenario import build


SUM = """
declare double @llvm.fma.f64(double, double, double)
define void @step(ptr %a, ptr %b, ptr %c, ptr %d, ptr %e) {{
  ret void
}}
define void @d_out_f(ptr %out, ptr %tc, ptr %h) {{
  %first = load double, ptr %tc
  %x = load double, ptr %h
  br label %power
power:
  %k = phi i64 [1, %0], [%next, %power]
  %total = phi double [%first, %0], [%new, %power]
  %rest = phi double [0.0, %0], [%newer, %power]
  %to = phi double [%x, %0], [%higher, %power]
  %place = getelementptr double, ptr %tc, i64 %k
  %c = load double, ptr %place
  {more}
  %new = fadd double %total, %more
  %gone = fsub double %new, %total
  %newer = fsub double %gone, %more
  %higher = fmul double %to, %x
  %next = add i64 %k, 1
  %again = icmp slt i64 %next, {size}
  br i1 %again, label %power, label %summed
summed:
  store double %new, ptr %out
  ret void
}}
"""
MORE = {
    "separate": "%term = fmul double %c, %to\n %more = fsub double %term, %rest",
    "fused": "%minus = fneg double %rest\n %more = call double @llvm.fma.f64(double %c, double "
    "%to, double %minus)",
    "simple": "%more = fmul double %c, %to",
}


def code_of(more: str, size: int) -> Loaded:
    """The dense output of one variable with `size` coefficients, whose sum is made so."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    target = llvm.Target.from_triple(llvm.get_process_triple())
    machine = target.create_target_machine(
        jit=True, features=llvm.get_host_cpu_features().flatten()
    )
    return load(machine.emit_object(llvm.parse_assembly(SUM.format(more=more, size=size))))


@pytest.mark.skipif(
    not llvm.get_host_cpu_features().get("fma", False), reason="the processor cannot round so"
)
@pytest.mark.parametrize("kind", MORE)
def test_code_that_fuses_is_recognised(kind: str) -> None:
    for order in (8, 20, 31):
        code = code_of(MORE[kind], order + 1)
        assert is_fused(code.dense, 1, order) == (kind == "fused")


@pytest.fixture(params=["0", "3"])
def fuses(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[bool]:
    """As tests are compiled; as users have it, with fused products where the processor has them."""
    monkeypatch.setenv(OPT_LEVEL, request.param)
    compiled_from.cache_clear()
    yield request.param == "3" and llvm.get_host_cpu_features().get("fma", False)
    compiled_from.cache_clear()


@pytest.mark.parametrize("preset", ["inverting", "rolling-cylinder"])
def test_the_rows_of_a_step_have_the_bits_of_each_alone(fuses: bool, preset: str) -> None:
    """Of the inversion, eight numbers in 8500 had not: where what is left of a sum is 1e-8 of its
    terms.
    """
    times = np.linspace(0.0, 0.5, 501)
    problem = build.load(preset, ["run.output_step=1e-3"], 0.5)
    driver = taylor.driver_of(problem)
    assert driver.compiled.machine.fused == fuses
    many = solve(problem)
    np.testing.assert_array_equal(many.times, times)
    for first in range(9):
        few = solve(build.load(preset, [f"run.output_times={times[first::9].tolist()}"], 0.5))
        np.testing.assert_array_equal(few.rows, many.rows[first::9])
