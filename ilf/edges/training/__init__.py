"""Training of the edge network on BSDS500: `python -m ilf.edges.training`. Needs PyTorch, which nothing else does."""
