"""Files of images, depth, clouds, meshes and blocks. File units, names and formats exist here and in `sources` only."""
