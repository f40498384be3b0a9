"""The linked views, the point cloud and the curves."""
