"""Training of the networks, each by a command of its own. Needs PyTorch, which nothing else does."""
