"""Data types of the library: frames, cameras, blocks, parameters, results, points and meshes."""
