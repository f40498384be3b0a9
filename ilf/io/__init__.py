"""Readers and writers for images, depth, clouds, meshes and blocks. File units, names and formats are used only here
and in `sources`."""
