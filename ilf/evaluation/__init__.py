"""How good depth and blocks are: ground truth, hold-out, comparison, quality checks, measuring."""
