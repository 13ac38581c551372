"""Outlines that the tests share."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import csalf


def rectangle(w: float, h: float, nx: int, ny: int) -> np.ndarray:
    x, y = np.linspace(0, w, nx + 1), np.linspace(0, h, ny + 1)
    sides = [(x[:-1], 0 * x[:-1]), (0 * y[:-1] + w, y[:-1]), (x[:0:-1], 0 * x[:-1] + h), (0 * y[:-1], y[:0:-1])]
    return np.concatenate([np.stack(s, 1) for s in sides])


def ring(center: tuple[float, float], r: float, n: int) -> np.ndarray:
    t = np.linspace(0, 2 * np.pi, n, endpoint=False)
    return np.stack([center[0] + r * np.cos(t), center[1] + r * np.sin(t)], 1)


@pytest.fixture(scope="session")
def plate() -> csalf.Mesh:
    """A plate with two holes, a scar, a hard point and rings that were asked for."""
    return csalf.mesh(
        loops={
            "outer": rectangle(12, 8, 24, 16),
            "bolt": ring((3, 4), 1, 16),
            "slot": ring((9, 4), 1.5, 20),
        },
        scars={"weld": [(5.5, 1.5), (6, 2), (6.5, 2.5)]},
        points={"spot": (6, 6, 0.4)},
        size=0.5,
        layers={"bolt": (2, "constant", 0.4), "slot": (2, "constant", 0.3)},
        name="plate",
    )


def boxes(path: Path, n: int) -> Path:
    """An STL file of ``n`` unit cubes in a row, apart from each other."""
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
    sides = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    lines = ["solid boxes"]
    for k in range(n):
        p = corners + (1.5 * k, 0, 0)
        for a, b, c, d in sides:
            for triangle in ((a, b, c), (a, c, d)):
                lines.append("facet normal 0 0 0\nouter loop")
                lines += ["vertex {} {} {}".format(*p[v]) for v in triangle]
                lines.append("endloop\nendfacet")
    path.write_text("\n".join([*lines, "endsolid boxes", ""]))
    return path
