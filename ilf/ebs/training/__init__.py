"""Training of the edge network on BSDS500: `python -m ilf.ebs.training`. Needs PyTorch, which nothing else does."""
