"""Training of the depth-edge network on generated scenes: `python -m ilf.edges.training.depth_edges`."""
