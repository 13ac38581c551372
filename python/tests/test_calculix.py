"""CalculiX solves on our .inp (docs/calculix.md)."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "examples"))
import calculix  # noqa: E402


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX (ccx) is not installed")
def test_stress_concentration_at_a_hole(tmp_path: Path) -> None:
    mesh = calculix.plate(32, rings=True)
    assert mesh.report["layers"][1]["made"] >= 2
    for order in (1, 2):
        assert calculix.concentration(mesh, tmp_path, order) == pytest.approx(calculix.EXACT, rel=0.03)
