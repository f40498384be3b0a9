"""Pinhole camera."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Camera:
    """Where it stands, its axes in the world (right, down, ahead as rows), and fx, fy, cx, cy [px]."""

    position: np.ndarray
    axes: np.ndarray
    intrinsics: tuple[float, float, float, float]

    def rays(self, columns: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Rays through pixels, (N, 3), scaled so that a hit at distance t has depth t."""
        fx, fy, cx, cy = self.intrinsics
        seen = np.stack([(columns - cx) / fx, (rows - cy) / fy, np.ones(columns.shape)], axis=-1)
        return (seen.reshape(-1, 3) @ self.axes).astype(np.float32)

    def scaled(self, share: float) -> Camera:
        """The same view with fewer pixels."""
        fx, fy, cx, cy = self.intrinsics
        return Camera(
            self.position, self.axes, (fx * share, fy * share, (cx + 0.5) * share - 0.5, (cy + 0.5) * share - 0.5)
        )


def aimed(
    position: np.ndarray, target: np.ndarray, roll: float, view: float, size: tuple[int, int], rng: np.random.Generator
) -> Camera:
    """Camera that looks at a point, rolled and with a horizontal field of view [degrees], on (width, height) pixels."""
    ahead = np.asarray(target, float) - position
    ahead /= max(float(np.linalg.norm(ahead)), 1e-9)
    up = np.array([0.0, 1.0, 0.0]) if abs(ahead[1]) < 0.98 else np.array([0.0, 0.0, 1.0])
    right = np.cross(up, ahead)
    right /= np.linalg.norm(right)
    down = np.cross(right, ahead)
    cos, sin = np.cos(np.radians(roll)), np.sin(np.radians(roll))
    axes = np.stack([cos * right + sin * down, cos * down - sin * right, ahead])
    width, height = size
    focal = width / 2 / np.tan(np.radians(view) / 2)
    centre = np.array([width / 2 - 0.5, height / 2 - 0.5]) + rng.normal(0, 0.015, 2) * width
    return Camera(np.asarray(position, float), axes, (focal, focal * float(rng.normal(1, 0.005)), *map(float, centre)))
