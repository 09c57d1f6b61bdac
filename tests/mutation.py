"""Mutation check: every + - * / and unary minus of a formula is flipped, one at a time, and the
tests must notice.

usage: python tests/mutation.py [--seconds N] [--list] [MODULE ...]

MODULE is the end of a module's name (friction, gliding.euler); without it, all.
The laws of mechanics judge what the systems are made of; test files judge other formulas, and what
the laws do not notice.
Each judge is a fork of this process that imports the package anew with the mutant in it.
"""

import argparse
import ast
import copy
import datetime
import importlib
import itertools
import math
import multiprocessing
import os
import resource
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import CodeType
from typing import NamedTuple

import mpmath  # noqa: F401  the forks need not import it again
import numba
import pytest
import scipy.spatial.transform  # noqa: F401

from tippetop_kernels import compilation


TESTS = Path(__file__).parent
ROOT = Path(importlib.import_module("tippetop").__file__).parent  # type: ignore[arg-type]
LAWS = ("mechanics/test_laws.py::test_law",)
CONTACT, RUNS = "mechanics/contact", "engine/contact"
JUDGES: dict[str, tuple[str, ...]] = {
    "mechanics.disc_friction": (
        "mechanics/test_disc_friction.py",
        f"{RUNS}/test_rows_of_phases.py",
        f"{RUNS}/test_disc_at_rest.py",
    ),
    "mechanics.doubledouble": ("mechanics/test_operand.py", "-k", "doubles"),
    "mechanics.theory.spinning": ("mechanics/test_spinning.py",),
    "mechanics.systems.tippe_top": ("mechanics/test_spinning.py",),
    "mechanics.theory.thresholds": ("mechanics/test_spinning.py",),
    "landscape.formulas": ("landscape/test_formulas.py",),
    "mechanics.friction": (
        "mechanics/test_friction.py",
        f"{RUNS}/test_parts_of_laws.py",
        f"{RUNS}/test_loaded_impacts.py",
        "-k",
        "set_valued or linearly or (newton_and_euler and contensou)",
    ),
    "mechanics.contact.body": (f"{CONTACT}/test_body.py", f"{CONTACT}/test_response.py"),
    "mechanics.contact.response": (
        f"{CONTACT}/test_response.py",
        f"{CONTACT}/test_disc_held.py",
        f"{RUNS}/test_impacts.py",
        f"{RUNS}/test_loaded_impacts.py",
        f"{RUNS}/test_parts_of_laws.py",
    ),
    "mechanics.rotation": ("mechanics/test_rotation.py",),
    "mechanics.theory.least_energy": ("library/test_asymptotics.py",),
}
"""Formulas that the laws do not read, or not all of them, and the arguments of pytest that judge
them.
"""
COMPILED = (
    "test_rows_of_phases.py",
    "test_disc_at_rest.py",
    "test_parts_of_laws.py",
    "test_impacts.py",
    "test_loaded_impacts.py",
    "test_asymptotics.py",
)
"""Test files that drive whole runs; of the others numba compiles nothing, which would be most of
their time.
"""
UNREAD = (
    "mechanics.rotation",
    "mechanics.theory.spinning",
    "mechanics.theory.least_energy",
    "mechanics.disc_friction",
    "mechanics.doubledouble",
)
"""Formulas of mechanics that the laws do not read."""
# z is +1 or -1 of a spinning top, and so is its own reciprocal
EQUAL: dict[str, tuple[str, ...]] = {
    "mechanics.theory.thresholds": ("spin: b.R * z",),
    "mechanics.theory.spinning": ("slope: b.R * z",),
}
"""Expressions whose mutant is the same formula."""
FLIPPED = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult}
FORK = multiprocessing.get_context("fork")
CACHE = tempfile.mkdtemp()
PLAIN = ["-x", "--assert=plain", "-o", "addopts=", "-o", f"cache_dir={CACHE}", "--failed-first"]
"""Neighbouring mutants are noticed by the same tests."""
LIMIT = {True: 120, False: 40}
"""Seconds of the processor that a judge may take with COMPILED files and without; a mutant that
takes longer is noticed.
"""

NIGHTS = 7
"""Nights in which all mutants are tried: each night begins this part of them further."""


class Mutant(NamedTuple):
    """One operator of a module, flipped."""

    module: str
    index: int
    line: int
    text: str  # the expression as it is written


def path_of(module: str) -> Path:
    """Return the file of a module of the package."""
    path = ROOT / (module.replace(".", "/") + ".py")
    return path if path.exists() else path.with_suffix("") / "__init__.py"


@cache
def tree_of(module: str) -> ast.Module:
    """Return the syntax tree of a module."""
    return ast.parse(path_of(module).read_text(encoding="utf-8"))


def modules() -> list[str]:
    """Return every module that contains a formula."""
    paths = (path for path in ROOT.rglob("*.py") if "@formula" in path.read_text(encoding="utf-8"))
    names = (".".join(path.relative_to(ROOT).with_suffix("").parts) for path in paths)
    return sorted(name.removesuffix(".__init__") for name in names)


def judges(module: str) -> list[tuple[str, ...]]:
    """Return the arguments of pytest for each judge of a module."""
    by_laws = module.startswith("mechanics.") and module not in UNREAD
    return [LAWS] * by_laws + ([JUDGES[module]] if module in JUDGES else [])


def sites(tree: ast.Module) -> list[tuple[str, ast.AST]]:
    """The operators inside formulas (functions under @formula), in order, and the names of the
    formulas.
    """
    formulas = [
        node
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef)
        and any(getattr(d, "id", "") == "formula" for d in node.decorator_list)
    ]
    return [
        (function.name, node)
        for function in formulas
        for node in ast.walk(function)
        if (isinstance(node, ast.BinOp) and type(node.op) in FLIPPED and not is_zero(node))
        or (isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub))
    ]


def is_zero(node: ast.BinOp) -> bool:
    """Whether it is 0*x, a zero of the kind of x: 0/x is the same one."""
    return (
        isinstance(node.op, ast.Mult)
        and isinstance(node.left, ast.Constant)
        and node.left.value == 0
    )


def mutants(module: str) -> list[Mutant]:
    """Every mutant of a module."""
    return [
        Mutant(module, i, node.lineno, ast.unparse(node))  # type: ignore[attr-defined]
        for i, (name, node) in enumerate(sites(tree_of(module)))
        if f"{name}: {ast.unparse(node)}" not in EQUAL.get(module, ())
    ]


def mutated(tree: ast.Module, index: int) -> ast.Module:
    """A copy of the module with one operator flipped."""
    changed = copy.deepcopy(tree)
    _, node = sites(changed)[index]
    if isinstance(node, ast.BinOp):
        node.op = FLIPPED[type(node.op)]()
    elif isinstance(node, ast.UnaryOp):
        node.op = ast.UAdd()
    return ast.fix_missing_locations(changed)


def survives(mutant: Mutant, until: float = float("inf")) -> bool | None:
    """Return whether every judge passes with a mutant in the package; None after a time."""
    if time.monotonic() > until:
        return None
    tree = mutated(tree_of(mutant.module), mutant.index)
    return not any(notices(judge, mutant.module, tree) for judge in judges(mutant.module))


def notices(judge: tuple[str, ...], module: str = "", tree: ast.Module | None = None) -> bool:
    """Return whether a judge fails, with a mutant in the package if there is one."""
    process = FORK.Process(target=run, args=(judge, module, tree))
    process.start()
    process.join()
    return process.exitcode != 0  # negative: too long, or compiled code wrote where it must not


def run(judge: tuple[str, ...], module: str, tree: ast.Module | None) -> None:
    """Run a judge, with one module mutated, and end this process with the exit code of pytest."""
    ours = {"tippetop", *(path.stem for path in (TESTS / "helpers").glob("*.py"))}
    for name in [name for name in sys.modules if name.partition(".")[0] in ours]:
        del sys.modules[name]
    as_written = SourceFileLoader.get_code

    def get_code(self: SourceFileLoader, name: str) -> CodeType | None:
        mutated = name == f"tippetop.{module}"
        return compile(tree, self.path, "exec") if mutated else as_written(self, name)

    SourceFileLoader.get_code = get_code  # type: ignore[method-assign]
    compiled = any(word.endswith(COMPILED) for word in judge)
    numba.config.DISABLE_JIT = not compiled
    compilation.code_folder = lambda _: None  # the machine code of a mutant must not be stored
    resource.setrlimit(resource.RLIMIT_CPU, (LIMIT[compiled],) * 2)
    os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"  # plugins would take most of the time
    with open(os.devnull, "w") as nowhere:
        os.dup2(nowhere.fileno(), 1)
        os.dup2(nowhere.fileno(), 2)
    words = [str(TESTS / word) if ".py" in word else word for word in judge]
    os._exit(pytest.main([*PLAIN, *words]))


def main() -> int:
    """Run the check and print survivors; return 1 if there are any."""
    parser = argparse.ArgumentParser(description="Mutation check of the formulas.")
    parser.add_argument("modules", nargs="*", metavar="MODULE")
    parser.add_argument(
        "--seconds", type=float, default=float("inf"), help="no mutant begins later"
    )
    parser.add_argument("--list", action="store_true", help="only count the mutants")
    options = parser.parse_args()
    named = {
        name: [m for m in modules() if f".{m}".endswith(f".{name}")] for name in options.modules
    }
    if unknown := [name for name in options.modules if not named[name]]:
        parser.error(
            f"no module with a formula is called {unknown[0]}; there are {', '.join(modules())}"
        )
    chosen = sorted({*itertools.chain(*named.values())}) if named else modules()
    if options.list:
        for module in chosen:
            words = ", ".join(word for judge in judges(module) for word in judge if ".py" in word)
            print(f"{module}: {len(mutants(module))} mutants, {words}")
        return 0
    found = [mutant for module in chosen for mutant in mutants(module)]
    first = datetime.date.today().toordinal() * math.ceil(len(found) / NIGHTS) % len(found)
    began = time.monotonic()
    with ProcessPoolExecutor(mp_context=FORK) as pool:
        needed = list(dict.fromkeys(judge for module in chosen for judge in judges(module)))
        if failing := [
            j for j, fails in zip(needed, pool.map(notices, needed), strict=True) if fails
        ]:
            raise SystemExit(f"{failing[0]} must pass before a formula is changed.")
        tonight = found[first:] + found[:first]
        until = began + options.seconds
        verdicts: list[bool | None] = []
        for verdict in pool.map(survives, tonight, itertools.repeat(until)):
            if verdict:
                mutant = tonight[len(verdicts)]
                print(f"survives: {mutant.module}:{mutant.line}: {mutant.text}", flush=True)
            verdicts.append(verdict)
    left = verdicts.count(None)
    print(f"{len(found) - left} of {len(found)} mutants tried in {time.monotonic() - began:.0f} s")
    if left:
        print(f"{left} are left for other nights: each begins a {NIGHTS}th of them further")
    return int(True in verdicts)


if __name__ == "__main__":
    sys.exit(main())
