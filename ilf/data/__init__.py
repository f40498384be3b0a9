"""The data that everything works on: frames, cameras, blocks, parameters, results, points and meshes."""
