"""Accuracy of the depth: against ground truth, or on hold-outs."""
