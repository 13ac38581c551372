"""Circles and elementary surfaces behind the general forms that IGES files have.

IGES knows no sphere, cone or torus, and most writers give cylinders and the edges of holes as swept surfaces and
splines, too. Holes then have no diameter, and poles and apexes are not seen as such.

    swept surface ─▶ its profile, in a plane ─line?─▶ plane, cylinder, cone
                                             ─circle?─▶ cylinder, sphere, torus
    edge ─▶ points of its curve ─circle?─▶ circle

Everything is held against the given tolerance. Edges and faces keep their topology.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from OCP.Geom import Geom_Circle, Geom_Surface
    from OCP.gp import gp_Dir, gp_Pnt
    from OCP.TopoDS import TopoDS_Edge, TopoDS_Face

Floats = NDArray[np.float64]

SAMPLES = 33
"""Points of a curve that are looked at."""

LEAST_ARC = 1.0
"""Radians: flatter arcs stay splines, their radius is not certain."""


def elementary(face: TopoDS_Face, tolerance: float) -> tuple[Geom_Surface, bool] | None:
    """The elementary surface of a face that has a general one, and whether its normal is on the same side."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepTools import BRepTools
    from OCP.Geom import Geom_ElementarySurface, Geom_Plane, Geom_RectangularTrimmedSurface
    from OCP.Geom import Geom_SurfaceOfLinearExtrusion, Geom_SurfaceOfRevolution
    from OCP.GeomLib import GeomLib_IsPlanarSurface

    surface = BRep_Tool.Surface_s(face)
    while isinstance(surface, Geom_RectangularTrimmedSurface):
        surface = surface.BasisSurface()
    if isinstance(surface, Geom_ElementarySurface):
        return None
    u0, u1, v0, v1 = BRepTools.UVBounds_s(face)
    made: Geom_Surface | None = None
    flat = GeomLib_IsPlanarSurface(surface, tolerance)
    if flat.IsPlanar():
        made = Geom_Plane(flat.Plan())
    elif isinstance(surface, Geom_SurfaceOfRevolution):
        made = _revolved(surface, v0, v1, tolerance)
    elif isinstance(surface, Geom_SurfaceOfLinearExtrusion):
        made = _extruded(surface, u0, u1, tolerance)
    if made is None:
        return None
    at, old = _normal(surface, 0.5 * (u0 + u1), 0.5 * (v0 + v1))
    _, new = _normal(made, *_parameters(made, at))
    return made, bool(old @ new > 0.0)


def circle(edge: TopoDS_Edge, tolerance: float) -> Geom_Circle | None:
    """The circle of an edge that has a general curve; it runs the same way."""
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.Geom import Geom_Circle
    from OCP.GeomAbs import GeomAbs_CurveType as Type
    from OCP.gp import gp_Ax2

    curve = BRepAdaptor_Curve(edge)
    if curve.GetType() in (Type.GeomAbs_Line, Type.GeomAbs_Circle, Type.GeomAbs_Ellipse):
        return None
    points = _points(curve, curve.FirstParameter(), curve.LastParameter())
    a, b, c = points[0], points[SAMPLES // 3], points[2 * SAMPLES // 3]
    normal = np.cross(b - a, c - a)
    if np.linalg.norm(normal) <= tolerance * np.linalg.norm(b - a):
        return None
    normal /= np.linalg.norm(normal)
    x, y = _across(normal)
    found = _arc(np.stack([(points - a) @ x, (points - a) @ y], 1), tolerance)
    if found is None or np.abs((points - a) @ normal).max() > tolerance:
        return None
    (p, q), radius = found
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if steps.sum() < LEAST_ARC * radius:
        return None
    return Geom_Circle(gp_Ax2(_pnt(a + p * x + q * y), _dir(normal)), radius)


def _revolved(surface: Any, v0: float, v1: float, tolerance: float) -> Geom_Surface | None:
    from OCP.Geom import Geom_ConicalSurface, Geom_CylindricalSurface, Geom_SphericalSurface, Geom_ToroidalSurface
    from OCP.gp import gp_Ax3

    origin, along = _xyz(surface.Axis().Location()), _xyz(surface.Axis().Direction())
    points = _points(surface.BasisCurve(), v0, v1) - origin
    height = points @ along
    profile = np.stack([np.linalg.norm(points - np.outer(height, along), axis=1), height], 1)

    def axis(z: float, sign: float = 1.0) -> gp_Ax3:
        return gp_Ax3(_pnt(origin + z * along), _dir(sign * along))

    if _is_line(profile, tolerance):
        (r0, z0), (r1, z1) = sorted((tuple(profile[0]), tuple(profile[-1])))
        if r1 - r0 <= tolerance:
            return Geom_CylindricalSurface(axis(z0), 0.5 * (r0 + r1))
        return Geom_ConicalSurface(axis(z0, np.sign(z1 - z0)), float(np.arctan2(r1 - r0, abs(z1 - z0))), r0)
    if (arc := _arc(profile, tolerance)) is None:
        return None
    (r, z), radius = arc
    if abs(r) <= tolerance:
        return Geom_SphericalSurface(axis(z), radius)
    return Geom_ToroidalSurface(axis(z), r, radius) if r > radius else None


def _extruded(surface: Any, u0: float, u1: float, tolerance: float) -> Geom_Surface | None:
    from OCP.Geom import Geom_CylindricalSurface
    from OCP.gp import gp_Ax3

    along = _xyz(surface.Direction())
    x, y = _across(along)
    points = _points(surface.BasisCurve(), u0, u1)
    if (arc := _arc(np.stack([points @ x, points @ y], 1), tolerance)) is None:
        return None
    (p, q), radius = arc
    return Geom_CylindricalSurface(gp_Ax3(_pnt(p * x + q * y), _dir(along)), radius)


def _is_line(points: Floats, tolerance: float) -> bool:
    along = points[-1] - points[0]
    off = (points[:, 0] - points[0, 0]) * along[1] - (points[:, 1] - points[0, 1]) * along[0]
    return bool(np.abs(off).max() <= tolerance * np.linalg.norm(along))


def _arc(points: Floats, tolerance: float) -> tuple[tuple[float, float], float] | None:
    """Centre and radius of the circle on which the points lie."""
    # Least squares of |p|² = 2 c·p + k.
    shift = points.mean(0)
    p = points - shift
    rows = np.column_stack([2.0 * p, np.ones(len(p))])
    (a, b, k), _, rank, _ = np.linalg.lstsq(rows, (p * p).sum(1), rcond=None)
    square = k + a * a + b * b
    if rank < 3 or square <= 0.0:
        return None
    radius = float(np.sqrt(square))
    if np.abs(np.hypot(p[:, 0] - a, p[:, 1] - b) - radius).max() > tolerance:
        return None
    return (float(a + shift[0]), float(b + shift[1])), radius


def _points(curve: Any, t0: float, t1: float) -> Floats:
    return np.array([_xyz(curve.Value(t)) for t in np.linspace(t0, t1, SAMPLES)])


def _parameters(surface: Geom_Surface, at: Floats) -> tuple[float, float]:
    from OCP.ShapeAnalysis import ShapeAnalysis_Surface

    uv = ShapeAnalysis_Surface(surface).ValueOfUV(_pnt(at), 0.0)
    return uv.X(), uv.Y()


def _normal(surface: Geom_Surface, u: float, v: float) -> tuple[Floats, Floats]:
    """The point at the parameters, and the direction of its normal."""
    from OCP.gp import gp_Pnt, gp_Vec

    point, du, dv = gp_Pnt(), gp_Vec(), gp_Vec()
    surface.D1(u, v, point, du, dv)
    return _xyz(point), np.cross(_xyz(du), _xyz(dv))


def _across(along: Floats) -> tuple[Floats, Floats]:
    """Two directions at right angles to one of length 1 and to each other; the three are right-handed."""
    x = np.cross(along, np.eye(3)[np.abs(along).argmin()])
    x /= np.linalg.norm(x)
    return x, np.cross(along, x)


def _xyz(p: Any) -> Floats:
    return np.array([p.X(), p.Y(), p.Z()])


def _pnt(p: Floats) -> gp_Pnt:
    from OCP.gp import gp_Pnt

    return gp_Pnt(*map(float, p))


def _dir(p: Floats) -> gp_Dir:
    from OCP.gp import gp_Dir

    return gp_Dir(*map(float, p))
