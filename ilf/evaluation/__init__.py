"""Evaluation of depth and blocks: ground truth, hold-out, comparison, quality checks, measuring."""
