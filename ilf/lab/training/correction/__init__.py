"""Training of the correction network on generated scenes: `python -m ilf.lab.training.correction`."""
