"""Outlines that the tests share."""

from __future__ import annotations

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
