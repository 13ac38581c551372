"""Sizes that are functions or arrays, as values on triangles.

A function is sampled on a quadtree, in blocks: one call per level. A cell is split while linear interpolation is off
by more than 2 % and the cell is larger than the size asked for in it. Neighbours differ by one level at most; then a
fan of triangles around each centre fits together.
"""

from __future__ import annotations

from typing import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._errors import SizeError

Triangles = tuple[NDArray[np.float64], NDArray[np.uint32], NDArray[np.float64]]
Function = Callable[[NDArray[np.float64], NDArray[np.float64]], ArrayLike]
Bounds = tuple[float, float, float, float]

ROOT = 8  # cells per side at the start
DEEPEST = 12  # levels below them
CELLS = 60_000  # no more than about so many cells
ERROR = 0.02  # relative error of the interpolation


def on_grid(values: ArrayLike, extent: Bounds) -> Triangles:
    """A rectangular array, the first row at the bottom, over the box x0, y0, x1, y1."""
    v = np.ascontiguousarray(values, dtype=np.float64)
    if v.ndim != 2 or min(v.shape) < 2:
        raise ValueError(f"a grid of sizes needs two dimensions of at least 2, not the shape {v.shape}")
    ny, nx = v.shape
    x0, y0, x1, y1 = extent
    x, y = np.meshgrid(np.linspace(x0, x1, nx), np.linspace(y0, y1, ny))
    k = np.arange(nx * ny, dtype=np.uint32).reshape(ny, nx)
    a, b, c, d = (p.ravel() for p in (k[:-1, :-1], k[:-1, 1:], k[1:, 1:], k[1:, :-1]))
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return np.stack([x.ravel(), y.ravel()], 1), np.ascontiguousarray(triangles), v.ravel()


def of_function(function: Function, bounds: Bounds) -> Triangles:
    """A function of arrays x and y, sampled over a box."""
    return _Tree(function, bounds).triangles()


class _Tree:
    """Cells are (level, i, j); nodes are integer places on the lattice of half the finest cells."""

    def __init__(self, function: Function, bounds: Bounds) -> None:
        x0, y0, x1, y1 = bounds
        pad = 0.005 * max(x1 - x0, y1 - y0)
        self.function = function
        self.origin = np.array([x0 - pad, y0 - pad])
        self.width = max(x1 - x0, y1 - y0) + 2 * pad
        self.n = ROOT << (DEEPEST + 1)
        self.value: dict[tuple[int, int], float] = {}
        columns, rows = (min(ROOT, int(np.ceil(ROOT * (s + 2 * pad) / self.width))) for s in (x1 - x0, y1 - y0))
        self.leaves = {(0, i, j) for i in range(columns) for j in range(rows)}
        self._refine()

    def _places(self, cell: tuple[int, int, int]) -> list[tuple[int, int]]:
        """Corners, middles of sides (counter-clockwise from the bottom left), centre."""
        level, i, j = cell
        s = 1 << (DEEPEST + 1 - level)
        x, y, h = i * s, j * s, s // 2
        return [
            (x, y), (x + h, y), (x + s, y), (x + s, y + h), (x + s, y + s), (x + h, y + s), (x, y + s), (x, y + h),
            (x + h, y + h),
        ]  # fmt: skip

    def _coordinates(self, places: list[tuple[int, int]]) -> NDArray[np.float64]:
        return self.origin + np.array(places, dtype=np.float64).reshape(-1, 2) * (self.width / self.n)

    def _evaluate(self, cells: list[tuple[int, int, int]]) -> NDArray[np.float64]:
        """Values at the nine places of each cell; those not yet known in one call."""
        places = [p for c in cells for p in self._places(c)]
        new = [p for p in dict.fromkeys(places) if p not in self.value]
        if new:
            xy = self._coordinates(new)
            made = np.asarray(self.function(xy[:, 0].copy(), xy[:, 1].copy()), dtype=np.float64)
            made = np.broadcast_to(made, (len(new),))
            bad = ~(np.isfinite(made) & (made > 0))
            if bad.any():
                k = int(np.flatnonzero(bad)[0])
                x, y = xy[k]
                message = f"the size function gave {made[k]} at ({x}, {y}); sizes are finite and above 0"
                raise SizeError(message, "size function", k, float(made[k]))
            self.value.update(zip(new, made.tolist()))
        return np.array([self.value[p] for p in places]).reshape(-1, 9)

    def _refine(self) -> None:
        front = sorted(self.leaves)
        for level in range(DEEPEST):
            v = self._evaluate(front)
            corners = v[:, [0, 2, 4, 6]]
            middles = 0.5 * (corners + np.roll(corners, -1, axis=1))
            off = np.abs(v[:, [1, 3, 5, 7]] - middles).max(1)
            off = np.maximum(off, np.abs(v[:, 8] - corners.mean(1)))
            least = v.min(1)
            wanted = (off > ERROR * least) & (self.width / (ROOT << level) > least)
            front = [child for k in np.flatnonzero(wanted) for child in self._split(front[k])]
            if not front or len(self.leaves) > CELLS:
                break
        self._balance()
        self._evaluate(sorted(self.leaves))

    def _split(self, cell: tuple[int, int, int]) -> list[tuple[int, int, int]]:
        level, i, j = cell
        self.leaves.discard(cell)
        children = [(level + 1, 2 * i + a, 2 * j + b) for a in (0, 1) for b in (0, 1)]
        self.leaves.update(children)
        return children

    def _leaf_over(self, level: int, i: int, j: int) -> tuple[int, int, int] | None:
        """The leaf that covers a cell; none if it is split further, or outside."""
        while level >= 0:
            if (level, i, j) in self.leaves:
                return level, i, j
            level, i, j = level - 1, i >> 1, j >> 1
        return None

    def _balance(self) -> None:
        stack = sorted(self.leaves)
        while stack:
            cell = stack.pop()
            if cell not in self.leaves:
                continue
            level, i, j = cell
            for a, b in ((i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)):
                while (leaf := self._leaf_over(level, a, b)) is not None and leaf[0] < level - 1:
                    stack += self._split(leaf)

    def triangles(self) -> Triangles:
        leaves = sorted(self.leaves)
        rings = {c: self._places(c) for c in leaves}
        corners = {p for ring in rings.values() for p in ring[0:8:2]}
        number: dict[tuple[int, int], int] = {}
        out: list[tuple[int, int, int]] = []
        for c in leaves:
            *ring, centre = rings[c]
            rim = [number.setdefault(p, len(number)) for p in ring if p in corners]
            middle = number.setdefault(centre, len(number))
            out += [(middle, a, b) for a, b in zip(rim, rim[1:] + rim[:1])]
        places = list(number)
        values = np.array([self.value[p] for p in places])
        return self._coordinates(places), np.array(out, dtype=np.uint32), values
