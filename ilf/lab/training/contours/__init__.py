"""Training of the edge network on BSDS500: `python -m ilf.lab.training.contours`."""
