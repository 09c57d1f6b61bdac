"""Mutation check: every + - * / and unary minus of a physics file is flipped, one at a time, and the laws must notice.

usage: python tests/mutation.py [FILE ...]     (names as in src/tippetop/systems, or `friction`; default: all)
"""

import ast
import copy
import importlib
import sys
import time
from pathlib import Path
from types import CodeType, ModuleType

import numpy as np


sys.path.insert(0, str(Path(__file__).parent / "helpers"))
import laws


ROOT = Path(importlib.import_module("tippetop").__file__).parent  # type: ignore[arg-type]
CONTACT = "mechanics.contact"
GLIDING = tuple(f"{CONTACT}.gliding.{name}" for name in ("vector", "euler", "chart", "catalogue"))
ROLLING = tuple(f"{CONTACT}.rolling.{name}" for name in ("reaction", "vector", "euler", "chart", "catalogue"))
TOPS = ("tippe_top", "tippe_top_reduced", "rolling_tippe_top", "heavy_top", "gliding_heavy_top")
ORDER = (
    "mechanics.friction",
    f"{CONTACT}.body",
    *GLIDING,
    *ROLLING,
    *(f"mechanics.systems.{name}" for name in (*TOPS, "cylinder", "rolling_cylinder")),
    "mechanics.systems",
)
FLIPPED = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult}


def sites(tree: ast.Module) -> list[ast.AST]:
    """The operators inside formulas (functions under @formula), in order."""
    formulas = [
        node
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef) and any(getattr(d, "id", "") == "formula" for d in node.decorator_list)
    ]
    return [
        node
        for function in formulas
        for node in ast.walk(function)
        if (isinstance(node, ast.BinOp) and type(node.op) in FLIPPED)
        or (isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub))
    ]


def mutated(tree: ast.Module, index: int) -> ast.Module:
    """A copy of the module with one operator flipped."""
    changed = copy.deepcopy(tree)
    node = sites(changed)[index]
    if isinstance(node, ast.BinOp):
        node.op = FLIPPED[type(node.op)]()
    elif isinstance(node, ast.UnaryOp):
        node.op = ast.UAdd()
    return ast.fix_missing_locations(changed)


def loaded(name: str, tree: ast.Module, codes: dict[str, CodeType]) -> dict:
    """SYSTEMS with one module mutated and everything that depends on it loaded again."""
    for module in ORDER[ORDER.index(name) :]:
        full = f"tippetop.{module}"
        fresh = ModuleType(full)
        folder = ROOT / module.replace(".", "/")
        parent, _, own = full.rpartition(".")
        fresh.__package__ = full if folder.is_dir() else parent
        fresh.__file__ = str(ROOT)
        if folder.is_dir():
            fresh.__path__ = [str(folder)]
        sys.modules[full] = fresh
        setattr(sys.modules[parent], own, fresh)
        exec(compile(tree, full, "exec") if module == name else codes[module], fresh.__dict__)
    return sys.modules["tippetop.mechanics.systems"].SYSTEMS


def source(module: str) -> str:
    """The text of a module."""
    path = ROOT / (module.replace(".", "/") + ".py")
    return (path if path.exists() else path.with_suffix("") / "__init__.py").read_text(encoding="utf-8")


def main(names: list[str]) -> int:
    """Runs the check and prints the survivors."""
    importlib.import_module("tippetop.mechanics.systems")
    codes: dict[str, CodeType] = {module: compile(source(module), module, "exec") for module in ORDER}
    wanted = [m for m in ORDER if not names or m.split(".")[-1] in names]
    alive = 0
    for module in wanted:
        tree, clock, survivors = ast.parse(source(module)), time.perf_counter(), []
        everything = loaded(module, tree, codes)
        assert (message := laws.first_broken(everything, rng)) is None, message
        count = len(sites(tree))
        for index in range(count):
            changed = mutated(tree, index)
            with np.errstate(all="ignore"):
                try:
                    noticed = laws.first_broken(loaded(module, changed, codes), rng)
                except (ArithmeticError, TypeError, ValueError) as error:
                    noticed = repr(error)
            if noticed is None:
                node = sites(tree)[index]
                survivors.append(f"    line {node.lineno}: {ast.unparse(node)}")  # type: ignore[attr-defined]
        loaded(module, tree, codes)
        alive += len(survivors)
        seconds = time.perf_counter() - clock
        print(f"{module}: {count - len(survivors)} of {count} mutants caught, {seconds:.0f} s", flush=True)
        print("\n".join(survivors), end="\n" if survivors else "", flush=True)
    return 1 if alive else 0


def rng() -> np.random.Generator:
    """The same states for every mutant."""
    return np.random.default_rng(20101452)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
