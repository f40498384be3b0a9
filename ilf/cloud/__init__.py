"""What depth and intrinsics say of space: coloured points, their normals, and the surface through them."""

from .flying import flying_points
from .links import Links, surface_links
from .mesh import Mesh, surface_mesh
from .normals import surface_normals
from .points import AXES, PointCloud, back_project, in_axes, in_world, point_cloud

__all__ = [
    "AXES",
    "Links",
    "Mesh",
    "PointCloud",
    "back_project",
    "flying_points",
    "in_axes",
    "in_world",
    "point_cloud",
    "surface_links",
    "surface_mesh",
    "surface_normals",
]
