"""Training of the depth-edge network on generated scenes: `python -m ilf.lab.training.depth_edges`."""
