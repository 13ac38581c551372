"""Quad meshes from outlines: rings around every boundary, all quads, the boundary kept exactly.

>>> import csalf
>>> mesh = csalf.mesh(loops=[[(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1)]], size=1.0)
>>> mesh.quads.shape
(4, 4)
"""

from ._api import Grid, Sources, check, discretise, jobs, mesh, mesh_all, read
from ._csalf import Curve, __version__
from ._curves import arc, bezier, circle, ellipse, line, polyline, spline
from ._errors import (
    Cancelled,
    Defect,
    Error,
    FaceFailure,
    FormatError,
    GeometryError,
    InternalError,
    MissingError,
    ModelError,
    Place,
    ShardError,
    SizeError,
)
from ._mesh import Check, Mesh
from ._model import Model, ModelMesh, mesh_model, stitch

__all__ = [
    "Cancelled",
    "Check",
    "Curve",
    "Defect",
    "Error",
    "FaceFailure",
    "FormatError",
    "GeometryError",
    "Grid",
    "InternalError",
    "Mesh",
    "MissingError",
    "Model",
    "ModelError",
    "ModelMesh",
    "Place",
    "ShardError",
    "SizeError",
    "Sources",
    "__version__",
    "arc",
    "bezier",
    "check",
    "circle",
    "discretise",
    "ellipse",
    "jobs",
    "line",
    "mesh",
    "mesh_all",
    "mesh_model",
    "polyline",
    "read",
    "spline",
    "stitch",
]
