"""A camera that orbits a point of the cloud: where it stands, and where it sees what."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

NEAR = 0.01
"""Points nearer to the eye than this [m] are not drawn."""

_DISTANCES = (0.02, 1e4)
_SAMPLE = 20_000  # points that are enough to judge a cloud's extent and density


@dataclass(frozen=True)
class OrbitCamera:
    """A camera that orbits a target. Axes as in the cloud: x right, y down, z forward.

    Parameters
    ----------
    target : tuple of float
        Point that is looked at, (x, y, z) [m].
    distance : float
        From the eye to the target [m].
    yaw, pitch : float
        Direction of view [rad]; 0, 0 looks along +z as the depth camera did, a positive pitch looks down.
    fov : float
        Vertical angle of view [rad].
    """

    target: tuple[float, float, float] = (0.0, 0.0, 0.0)
    distance: float = 3.0
    yaw: float = 0.0
    pitch: float = 0.0
    fov: float = math.radians(45)

    def orbit(self, yaw: float, pitch: float) -> OrbitCamera:
        """Turned about the target by two angles [rad]; the pitch stops straight above and below."""
        turned = math.remainder(self.yaw + yaw, math.tau)
        return replace(self, yaw=turned, pitch=min(max(self.pitch + pitch, -math.pi / 2), math.pi / 2))

    def pan(self, right: float, down: float) -> OrbitCamera:
        """Moved with its target along the picture's axes [m]."""
        x_axis, y_axis, _ = self.rotation()
        x, y, z = (np.asarray(self.target) + right * x_axis + down * y_axis).tolist()
        return replace(self, target=(x, y, z))

    def dolly(self, factor: float) -> OrbitCamera:
        """Nearer (factor < 1) or farther (factor > 1), within 0.02 m to 10 km."""
        return replace(self, distance=min(max(self.distance * factor, _DISTANCES[0]), _DISTANCES[1]))

    def rotation(self) -> NDArray[np.float64]:
        """Rows: the picture's right, down and forward axes in cloud coordinates, float64 (3, 3)."""
        cos_y, sin_y, cos_p, sin_p = math.cos(self.yaw), math.sin(self.yaw), math.cos(self.pitch), math.sin(self.pitch)
        return np.array(
            [
                [cos_y, 0.0, -sin_y],
                [-sin_p * sin_y, cos_p, -sin_p * cos_y],
                [cos_p * sin_y, sin_p, cos_p * cos_y],
            ]
        )

    def view_matrix(self) -> NDArray[np.float64]:
        """Homogeneous matrix from cloud to eye coordinates, float64 (4, 4)."""
        matrix = np.eye(4)
        matrix[:3, :3] = self.rotation()
        matrix[:3, 3] = -matrix[:3, :3] @ np.asarray(self.target)
        matrix[2, 3] += self.distance
        return matrix

    def focal(self, height: int) -> float:
        """Focal length [px] in a picture of that height."""
        return 0.5 * height / math.tan(0.5 * self.fov)

    def project(self, points: NDArray[np.floating], width: int, height: int) -> NDArray[np.float64]:
        """Where points of the cloud, (N, 3) [m], are in a picture of that size, float64 (N, 3): x and y [px] from its
        upper left corner, and how far before the eye they are [m]; x and y mean nothing unless that is positive."""
        matrix = self.view_matrix()
        eye = np.asarray(points, np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
        with np.errstate(all="ignore"):
            places = eye[:, :2] / eye[:, 2:] * self.focal(height) + (width / 2, height / 2)
        return np.column_stack([places, eye[:, 2]])

    def metres_per_pixel(self, height: int) -> float:
        """Length [m] of a pixel's side at the target, in a picture of that height."""
        return self.distance / self.focal(height)

    def fitted(self, points: NDArray[np.float32], aspect: float) -> OrbitCamera:
        """Same direction, but aimed at the middle of a cloud and far enough away to see nearly all of it.

        Parameters
        ----------
        points : ndarray
            float32 (N, 3) [m]. The outermost points do not count: stray ones would make the rest tiny.
        aspect : float
            Width of the picture over its height.
        """
        sample = few_of(points).astype(np.float64)
        if not len(sample):
            return self
        centre = np.median(sample, axis=0)
        x, y, z = self.rotation() @ (sample - centre).T
        half = math.tan(0.5 * self.fov)
        middle = np.zeros(2)
        for _ in range(4):  # the middle of the picture depends on the distance, and the other way round
            across, along = np.abs(x - middle[0]) / aspect, np.abs(y - middle[1])
            distance = max(float(np.percentile(np.maximum(across, along) / half - z, 99.5)), 2 * NEAR - float(z.min()))
            edges = np.percentile(np.stack([x - middle[0], y - middle[1]]) / (z + distance), (0.5, 99.5), axis=1)
            middle += edges.mean(axis=0) * distance
        aimed = replace(self, target=tuple(centre.tolist()), distance=1.0)
        return aimed.pan(*middle.tolist()).dolly(1.08 * distance)


def few_of(points: NDArray[np.float32]) -> NDArray[np.float32]:
    """The finite ones of at most 20 000 points, spread evenly over the cloud's order."""
    if len(points) > _SAMPLE:
        points = points[np.linspace(0, len(points) - 1, _SAMPLE).astype(np.intp)]
    return points[np.isfinite(points).all(axis=1)]
