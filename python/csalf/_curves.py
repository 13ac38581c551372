"""Curves, as loops and scars of ``csalf.mesh`` and ``csalf.discretise`` may be made of."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._csalf import Curve

Point = Sequence[float]


def nodes(points: ArrayLike) -> NDArray[np.float64]:
    """Points as rows of two numbers; a third coordinate is not taken."""
    array = np.ascontiguousarray(points, dtype=np.float64)
    if array.ndim != 2 or array.shape[1] != 2:
        raise ValueError(f"expected points of shape (n, 2), not {array.shape}")
    return array


def _pair(p: Point) -> tuple[float, float]:
    x, y = p
    return float(x), float(y)


def line(a: Point, b: Point) -> Curve:
    """The segment from a to b."""
    return Curve.polyline(nodes([_pair(a), _pair(b)]))


def polyline(points: ArrayLike) -> Curve:
    """Straight segments through points; turns above 30 degrees keep their node."""
    return Curve.polyline(nodes(points))


def circle(center: Point, radius: float) -> Curve:
    """A full circle, counter-clockwise from its rightmost point."""
    return arc(center, radius, 0.0, math.tau)


def arc(center: Point, radius: float, start: float, sweep: float) -> Curve:
    """An arc of a circle from the angle ``start`` through ``sweep`` radians (positive: counter-clockwise)."""
    return ellipse(center, (radius, radius), start=start, sweep=sweep)


def ellipse(
    center: Point, radii: Point, *, rotation: float = 0.0, start: float = 0.0, sweep: float = math.tau
) -> Curve:
    """An ellipse or an arc of one. ``rotation`` turns its first axis; all angles in radians."""
    return Curve.arc(_pair(center), _pair(radii), rotation, start, sweep)


def bezier(points: ArrayLike) -> Curve:
    """A Bezier curve of 3 or 4 points."""
    return Curve.bezier(nodes(points))


def spline(points: ArrayLike, *, closed: bool = False) -> Curve:
    """The cubic spline through points."""
    return Curve.spline(nodes(points), closed)
