"""The quickstart notebook runs from its first to its last cell."""

import json
from pathlib import Path

import pytest
from matplotlib.figure import Figure


NOTEBOOK = Path(__file__).parents[2] / "docs" / "tutorials" / "quickstart.ipynb"


def test_the_quickstart_notebook_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from IPython.core.interactiveshell import InteractiveShell

    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path))
    shell, cells = InteractiveShell(), json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    results = [shell.run_cell(source) for source in code]
    assert [result.error_in_exec for result in results] == [None] * len(code)
    assert any(isinstance(result.result, Figure) for result in results)
