"""Looking closely: the depth along a line, a surface in numbers, distances and angles."""
