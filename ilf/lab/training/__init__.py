"""Training of the networks, one command each. Only training needs PyTorch."""
