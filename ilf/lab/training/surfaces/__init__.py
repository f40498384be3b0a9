"""Training of the surface network and the correction on generated scenes: `python -m ilf.lab.training.surfaces`."""
