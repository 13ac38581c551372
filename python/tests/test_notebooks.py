"""The notebooks of the documentation run, and hold no outputs that could go stale."""

from __future__ import annotations

import ast
import json
from pathlib import Path

import pytest

import csalf

ROOT = Path(__file__).parents[2]
NOTEBOOKS = sorted((ROOT / "docs/notebooks").glob("*.ipynb"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda p: p.stem)
def test_notebook(path: Path, tmp_path, monkeypatch) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("CSALF_ROOT", str(ROOT))
    notebook = json.loads(path.read_text())
    assert notebook["nbformat"] == 4
    space: dict[str, object] = {"__name__": "__main__"}
    shown = 0
    for k, cell in enumerate(notebook["cells"]):
        assert cell["cell_type"] in ("markdown", "code") and cell["id"]
        if cell["cell_type"] == "markdown":
            continue
        assert not cell["outputs"] and cell["execution_count"] is None, f"{path.name}, cell {k}: stored output"
        value = run("".join(cell["source"]), f"{path.name}, cell {k}", space)
        if isinstance(value, csalf.Mesh):
            assert value._repr_html_().startswith("<div")
            shown += 1
    assert shown > 0, "a notebook shows a mesh"
    import matplotlib.pyplot as plt

    plt.close("all")


def run(source: str, name: str, space: dict[str, object]) -> object:
    """Runs a cell; the value of its last expression, as a notebook shows it."""
    body = ast.parse(source, name).body
    last = body.pop() if body and isinstance(body[-1], ast.Expr) else None
    exec(compile(ast.Module(body, []), name, "exec"), space)
    return eval(compile(ast.Expression(last.value), name, "eval"), space) if last else None


def test_the_notebooks_are_there() -> None:
    if not (ROOT / "docs").exists():
        pytest.skip("not in a checkout")
    assert len(NOTEBOOKS) >= 3
