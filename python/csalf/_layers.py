"""Layers, as people ask for them."""

from __future__ import annotations

from typing import Any, Mapping, Sequence, Union

import numpy as np

Layer = Union[int, Sequence[float], tuple[int, str], tuple[int, str, float], Mapping[str, Any]]

Row = tuple[str, int, str, Union[list[float], None], Union[float, None]]
"""Pattern, count, law, thicknesses, first thickness."""


def layer_row(pattern: str, layer: Layer) -> Row:
    """A count; (count, law) or (count, law, first); a list of thicknesses; or a dict of all of these."""
    if isinstance(layer, Mapping):
        thicknesses = layer.get("thicknesses")
        count = layer.get("count", len(thicknesses) if thicknesses is not None else None)
        unknown = set(layer) - {"count", "law", "first", "thicknesses"}
        if unknown or count is None:
            raise ValueError(f"layers of {pattern!r}: expected count, law, first, thicknesses, not {sorted(layer)}")
        return pattern, int(count), layer.get("law", "auto"), thicknesses, layer.get("first")
    if isinstance(layer, (int, np.integer)):
        return pattern, int(layer), "auto", None, None
    if isinstance(layer, tuple) and len(layer) in (2, 3) and isinstance(layer[1], str):
        first = float(layer[2]) if len(layer) == 3 else None
        return pattern, int(layer[0]), layer[1], None, first
    thicknesses = [float(t) for t in layer]  # type: ignore[union-attr, arg-type]
    return pattern, len(thicknesses), "auto", thicknesses, None
