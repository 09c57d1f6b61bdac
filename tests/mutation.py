"""Mutation check: every + - * / and unary minus of a formula is flipped, one at a time, and the
tests must notice.

usage: python tests/mutation.py [--results FILE] [--seconds N] [--list] [MODULE ...]

MODULE is the end of a module's name (friction, gliding.euler); without it, all. What the systems
are made of is judged by the laws of mechanics, in this process; what they do not notice, and other
formulas, by test files, in a fork of this process for each mutant. With --results each verdict is
kept in FILE (JSON lines): a run that was stopped, or whose
--seconds are over, continues there, until a physics file or a judge changes.
"""

import argparse
import ast
import copy
import hashlib
import importlib
import json
import multiprocessing
import os
import resource
import sys
import time
from collections.abc import Iterator
from functools import cache
from importlib.machinery import SourceFileLoader
from multiprocessing.connection import Connection
from pathlib import Path
from types import CodeType, ModuleType
from typing import ClassVar, NamedTuple

import mpmath  # noqa: F401  the forks need not import it again
import numba
import numpy as np
import pytest

from tippetop_kernels import compilation


TESTS = Path(__file__).parent
sys.path.insert(0, str(TESTS / "helpers"))
import laws  # noqa: E402


ROOT = Path(importlib.import_module("tippetop").__file__).parent  # type: ignore[arg-type]
SYSTEMS = "mechanics.systems"
CONTACT, RUNS = "mechanics/contact", "engine/contact"
JUDGES: dict[str, tuple[str, ...]] = {
    "mechanics.disc_friction": (
        "mechanics/test_disc_friction.py",
        f"{RUNS}/test_rows_of_phases.py",
        f"{RUNS}/test_disc_at_rest.py",
    ),
    "mechanics.doubledouble": ("mechanics/test_operand.py", "-k", "doubles"),
    "mechanics.event": ("runs/test_events.py", "-k", "TestSignificance"),
    "mechanics.systems.spinning": ("mechanics/test_spinning.py",),
    "mechanics.systems.tippe_top": ("mechanics/test_spinning.py",),
    "mechanics.theory.thresholds": ("mechanics/test_spinning.py",),
    "landscape.formulas": ("landscape/test_formulas.py",),
    "mechanics.friction": ("mechanics/test_friction.py", "-k", "set_valued"),
    "mechanics.contact.body": (f"{CONTACT}/test_body.py", f"{CONTACT}/test_response.py"),
    "mechanics.contact.response": (
        f"{CONTACT}/test_response.py",
        f"{RUNS}/test_impacts.py",
        f"{RUNS}/test_loaded_impacts.py",
    ),
    "mechanics.contact.coulomb": (f"{CONTACT}/test_response.py",),
    "mechanics.contact.disc_at_rest": (
        f"{CONTACT}/test_disc_held.py",
        f"{RUNS}/test_parts_of_laws.py",
        "-k",
        "disc or newton",
    ),
    "mechanics.contact.impact_motion": (f"{RUNS}/test_loaded_impacts.py",),
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
# z is +1 or -1 of a spinning top, and so is its own reciprocal
EQUAL: dict[str, tuple[str, ...]] = {
    "mechanics.theory.thresholds": ("spin: b.R * z",),
    "mechanics.systems.spinning": ("slope: b.R * z",),
}
"""Expressions whose mutant is the same formula."""
FLIPPED = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult}
PLAIN = ("-x", "--assert=plain", "-o", "addopts=", "-p", "no:cacheprovider")
LIMIT = {
    True: 120,
    False: 40,
}  # seconds of the processor that COMPILED and other files may take; longer is noticed too


class Mutant(NamedTuple):
    """One operator of a module, flipped."""

    module: str
    index: int
    line: int
    text: str  # the expression as it stands


# --- what is mutated ----------------------------------------------------------------------------


def path_of(module: str) -> Path:
    """The file of a module of the package."""
    path = ROOT / (module.replace(".", "/") + ".py")
    return path if path.exists() else path.with_suffix("") / "__init__.py"


@cache
def source(module: str) -> str:
    """The text of a module."""
    return path_of(module).read_text(encoding="utf-8")


@cache
def tree_of(module: str) -> ast.Module:
    """The syntax tree of a module."""
    return ast.parse(source(module))


def formula_files() -> set[str]:
    """Every module that holds a formula."""
    paths = (p for p in ROOT.rglob("*.py") if "@formula" in p.read_text(encoding="utf-8"))
    return {
        ".".join(p.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__") for p in paths
    }


def imported(module: str) -> Iterator[str]:
    """The modules of the package that a module imports at its top, in order."""
    package = module if path_of(module).name == "__init__.py" else module.rpartition(".")[0]
    for node in tree_of(module).body:
        if isinstance(node, ast.ImportFrom) and node.level:
            base = importlib.util.resolve_name(
                "." * node.level + (node.module or ""), f"tippetop.{package}"
            )
            base = base.removeprefix("tippetop").removeprefix(".")
            for alias in node.names:
                name = f"{base}.{alias.name}".removeprefix(".")
                yield name if path_of(name).exists() else base


@cache
def order() -> tuple[str, ...]:
    """The mechanics that systems are made of, each after what it imports."""
    done: dict[str, None] = {}

    def visit(module: str) -> None:
        if module in done or not module.startswith("mechanics."):
            return
        for other in imported(module):
            if other != module:
                visit(other)
        done[module] = None

    visit(SYSTEMS)
    return tuple(done)


def modules() -> list[str]:
    """All that are mutated: those with formulas, in the order of the laws, then the others."""
    found = formula_files()
    return [m for m in order() if m in found] + sorted(found - {*order()})


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


# --- judges -------------------------------------------------------------------------------------


@cache
def code(module: str) -> CodeType:
    """A module, compiled."""
    return compile(source(module), module, "exec")


def loaded(module: str, tree: ast.Module) -> dict:
    """SYSTEMS with one module mutated and everything that may depend on it loaded again."""
    for name in order()[order().index(module) :]:
        full = f"tippetop.{name}"
        fresh = ModuleType(full)
        folder = ROOT / name.replace(".", "/")
        parent, _, own = full.rpartition(".")
        fresh.__package__ = full if folder.is_dir() else parent
        fresh.__file__ = str(ROOT)
        if folder.is_dir():
            fresh.__path__ = [str(folder)]
        sys.modules[full] = fresh
        setattr(sys.modules[parent], own, fresh)
        exec(compile(tree, full, "exec") if name == module else code(name), fresh.__dict__)
    return sys.modules[f"tippetop.{SYSTEMS}"].SYSTEMS


recent: list[
    tuple[str, str, str]
] = []  # the cases that noticed, the last one first: neighbours are noticed alike


def noticed_by_laws(module: str, tree: ast.Module) -> bool:
    """Whether a law is broken, at the same states for every mutant."""
    try:
        with np.errstate(all="ignore"):
            systems = loaded(module, tree)
            for case in dict.fromkeys([*recent, *laws.cases(systems)]):
                if laws.first_broken_of(systems, case, np.random.default_rng(20101452)) is not None:
                    recent[:] = dict.fromkeys([case, *recent])
                    return True
            return False
    except (ArithmeticError, AttributeError, TypeError, ValueError):
        return True
    finally:
        loaded(module, tree_of(module))


class Sharpest:
    """A plugin of pytest: tests that failed lately go first, and the first that fails is sent to
    the parent process.
    """

    recent: ClassVar[list[str]] = []  # the last one first

    def __init__(self, channel: Connection):
        self.channel = channel

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Sorts: neighbouring mutants are noticed alike, and the first failure ends the session."""
        place = {name: i for i, name in enumerate(self.recent)}
        items.sort(key=lambda item: place.get(item.nodeid, len(place)))

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Sends the name of a test that failed."""
        if report.failed:
            self.channel.send(report.nodeid)


def noticed_by_tests(module: str, tree: ast.Module) -> bool:
    """Whether a test file fails, in a fork of this process that imports the package anew with the
    mutant in it.
    """
    here, there = multiprocessing.Pipe(duplex=False)
    process = multiprocessing.get_context("fork").Process(
        target=run_tests, args=(module, tree, there)
    )
    process.start()
    process.join()
    if (
        process.exitcode is not None and process.exitcode < 0
    ):  # too long; or compiled code wrote where it must not
        return True
    if process.exitcode not in (0, 1, 2):  # 2: the file cannot even be collected
        raise RuntimeError(f"pytest exits with {process.exitcode} for {module}")
    if here.poll():
        Sharpest.recent[:] = dict.fromkeys([here.recv(), *Sharpest.recent])
    return process.exitcode != 0


def run_tests(module: str, tree: ast.Module, channel: Connection) -> None:
    """Ends this process with pytest's exit code, the package read again with one module mutated."""
    ours = {"tippetop", *(path.stem for path in (TESTS / "helpers").glob("*.py"))}
    for name in [name for name in sys.modules if name.partition(".")[0] in ours]:
        del sys.modules[name]
    as_written = SourceFileLoader.get_code

    def get_code(self: SourceFileLoader, name: str) -> CodeType | None:
        return (
            compile(tree, self.path, "exec")
            if name == f"tippetop.{module}"
            else as_written(self, name)
        )

    SourceFileLoader.get_code = get_code  # type: ignore[method-assign]
    judge = [str(TESTS / word) if word.endswith(".py") else word for word in JUDGES[module]]
    compiled = any(word.endswith(COMPILED) for word in judge)
    numba.config.DISABLE_JIT = not compiled
    compilation.code_folder = lambda: None  # the machine code of a mutant must not be stored
    resource.setrlimit(resource.RLIMIT_CPU, (LIMIT[compiled],) * 2)
    os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = (
        "1"  # most of the time goes to plugins that no judge needs
    )
    with open(os.devnull, "w") as nowhere:
        os.dup2(nowhere.fileno(), 1)
        os.dup2(nowhere.fileno(), 2)
        os._exit(pytest.main([*PLAIN, *judge], plugins=[Sharpest(channel)]))


def noticed(module: str, tree: ast.Module) -> bool:
    """Whether a judge of a module notices that it is another one."""
    return (module in order() and noticed_by_laws(module, tree)) or (
        module in JUDGES and noticed_by_tests(module, tree)
    )


def files_of(module: str) -> list[str]:
    """The test files among the judges of a module."""
    return [word for word in JUDGES.get(module, ()) if word.endswith(".py")]


def judged_by(module: str) -> str:
    """The names of the judges of a module."""
    return ", ".join(["laws"] * (module in order()) + files_of(module))


def fingerprint(module: str) -> str:
    """What a verdict depends on: the judges, and the formulas that they may read; laws read those
    of systems only.
    """
    read = formula_files() if module in JUDGES else formula_files() & {*order()}
    judge = (
        [TESTS / name for name in [*files_of(module), "helpers/landscape_oracle.py"]]
        if module in JUDGES
        else []
    )
    files = [*judge, TESTS / "helpers" / "laws.py", *(path_of(name) for name in sorted(read))]
    return hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest()[:16]


# --- the run ------------------------------------------------------------------------------------


def remembered(results: Path | None) -> dict[tuple[str, int, str], bool]:
    """The verdicts of runs before."""
    if results is None or not results.exists():
        return {}
    lines = [
        json.loads(line)
        for line in results.read_text(encoding="utf-8").splitlines()
        if line.endswith("}")
    ]
    return {(line["module"], line["index"], line["of"]): line["caught"] for line in lines}


def table(wanted: list[str], verdicts: dict[Mutant, bool]) -> str:
    """The outcome: a line for each module, then the survivors."""
    rows = [("module", "judge", "mutants", "caught", "survive", "not run")]
    for module in wanted:
        known = [verdicts[m] for m in mutants(module) if m in verdicts]
        numbers = (
            len(mutants(module)),
            sum(known),
            len(known) - sum(known),
            len(mutants(module)) - len(known),
        )
        rows.append((module, judged_by(module), *map(str, numbers)))
    lines = ["  ".join(row) for row in rows]
    survivors = [m for m, caught in verdicts.items() if not caught]
    return "\n".join([*lines, "", *(f"survives: {m.module}:{m.line}: {m.text}" for m in survivors)])


def main() -> int:
    """Runs the check and prints the table; 1 if a mutant survives, 3 if time was over before all
    were run.
    """
    parser = argparse.ArgumentParser(description="Mutation check of the formulas.")
    parser.add_argument("modules", nargs="*", metavar="MODULE")
    parser.add_argument("--results", type=Path, help="where verdicts are kept and found again")
    parser.add_argument(
        "--seconds", type=float, default=float("inf"), help="no mutant is begun after so long"
    )
    parser.add_argument("--list", action="store_true", help="only say what would be run")
    options = parser.parse_args()
    importlib.import_module(f"tippetop.{SYSTEMS}")
    wanted = [
        m
        for m in modules()
        if not options.modules or any(f".{m}".endswith(f".{n}") for n in options.modules)
    ]
    kept, verdicts, clock = remembered(options.results), {}, time.monotonic()
    for module in wanted:
        of, asked = fingerprint(module), False
        for mutant in mutants(module):
            if (caught := kept.get((module, mutant.index, of))) is None:
                if options.list or time.monotonic() - clock > options.seconds:
                    continue
                if not asked and noticed(module, tree_of(module)):
                    raise SystemExit(
                        f"{module}: its judge must be content with the formulas as they are, "
                        "but is not."
                    )
                asked = True
                caught = noticed(module, mutated(tree_of(module), mutant.index))
                if options.results:
                    line = {
                        "module": module,
                        "index": mutant.index,
                        "of": of,
                        "line": mutant.line,
                        "caught": caught,
                    }
                    with options.results.open("a", encoding="utf-8") as file:
                        file.write(json.dumps(line) + "\n")
            verdicts[mutant] = caught
        done = sum(m.module == module for m in verdicts)
        print(
            f"{module}: {done} of {len(mutants(module))} after {time.monotonic() - clock:.0f} s",
            flush=True,
        )
    print(table(wanted, verdicts))
    if not all(verdicts.values()):
        return 1
    return 0 if len(verdicts) == sum(len(mutants(m)) for m in wanted) else 3


if __name__ == "__main__":
    sys.exit(main())
