"""The point cloud: its scene, its drawing, and its view."""
