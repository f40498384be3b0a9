"""Rendering with numpy: label maps, stages of the extraction, point clouds."""
