"""Editors and type checkers have every option of a run, through mypy, pyright and jedi."""

import ast
import inspect
import json
import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest
from typed import refused, typed

import tippetop as tt
from tippetop.problem.options import OPTIONS


STUBS = {path.stem: path for path in Path(tt.__file__).parent.glob("*.pyi")}
CALLS = """import tippetop as tt

run: tt.Run = tt.run("inverting", until="8 s", output="steps", columns=["theta"], events=[])
tt.derivatives.sensitivities("inverting", ["friction.mu"], output_step="1 ms", precision="double")
tt.run("inverting", outputs="steps")
tt.run("inverting", output="row")
tt.derivatives.lyapunov("inverting", until=[1])
tt.friction.Viscous(mu="0.3 s/m")
tt.friction.Viscous(mu=[0.3])
"""
WRONG = [5, 6, 7, 9]  # lines of it


def test_the_stub_is_what_its_generator_writes() -> None:
    generator = runpy.run_path(str(Path(__file__).parents[2] / ".ci" / "stub.py"))
    assert STUBS.keys() == generator["MODULES"].keys()
    for name, module in generator["MODULES"].items():
        assert STUBS[name].read_text() == generator["stub"](module), (
            "write it again: python .ci/stub.py"
        )


def test_signatures_and_help_have_every_option() -> None:
    trees = (ast.parse(stub.read_text()) for stub in STUBS.values())
    stub = {
        node.name: node for tree in trees for node in tree.body if isinstance(node, ast.FunctionDef)
    }
    for function in (tt.run, tt.ensemble, tt.derivatives.sensitivities, tt.derivatives.lyapunov):
        typed = stub[function.__name__].args
        assert [*inspect.signature(function).parameters] == [
            a.arg for a in (*typed.args, *typed.kwonlyargs)
        ]
        assert set(OPTIONS) <= {*inspect.signature(function).parameters}
    text = inspect.getdoc(tt.run) or ""
    assert all(f"\n{name} : " in text for name in OPTIONS)


@pytest.mark.slow
def test_mypy_knows_options_and_their_values(tmp_path: Path) -> None:
    from mypy import api

    (tmp_path / "calls.py").write_text(CALLS)
    found, *_ = api.run(
        [str(tmp_path / "calls.py"), "--ignore-missing-imports", "--follow-imports=silent"]
    )
    assert [int(line) for line in re.findall(r":(\d+): error:", found)] == WRONG
    assert 'did you mean "output"' in found
    assert "Literal['times', 'events', 'steps', 'keyframes']" in found


@pytest.mark.slow
def test_so_does_pyright(tmp_path: Path) -> None:
    """As Pylance does."""
    pytest.importorskip("basedpyright")
    (tmp_path / "calls.py").write_text(CALLS)
    command = ["-m", "basedpyright", "--outputjson", "--level", "error", "calls.py"]
    command += ["--pythonpath", sys.executable]
    done = subprocess.run(
        [sys.executable, *command], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    found = json.loads(done.stdout)["generalDiagnostics"]
    assert [each["range"]["start"]["line"] + 1 for each in found] == WRONG


@pytest.mark.slow
@pytest.mark.parametrize(
    ("typed", "known"),
    [
        ("tt.run('x', output_", "output_step="),
        ("tt.run('x').traj", "trajectory"),
        ("tt.friction.Vis", "Viscous"),
    ],
)
def test_jedi_completes(typed: str, known: str) -> None:
    """As Jupyter does while nothing has been run yet."""
    import jedi

    script = jedi.Script(f"import tippetop as tt\n{typed}")
    assert known in [completion.name for completion in script.complete(2, len(typed))]


def test_the_command_line_knows_every_option(capsys: pytest.CaptureFixture[str]) -> None:
    assert typed("new inverting") == typed("help scenario") == 0
    printed = capsys.readouterr().out
    for name in OPTIONS:
        assert printed.count(f"\n{name} ") + printed.count(f"\n# {name} ") == 2
        if name not in ("until", "columns"):  # options of `tippetop run` themselves
            assert "are changed by --set" in refused(f"run inverting --{name.replace('_', '-')} 1")


def test_a_name_of_a_module_is_found() -> None:
    with pytest.raises(AttributeError, match=r"see tippetop\.friction\.Viscous"):
        tt.Viscous  # noqa: B018
    assert not hasattr(tt, "viscous")
