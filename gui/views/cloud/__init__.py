"""The point cloud: scene, drawing and view."""
