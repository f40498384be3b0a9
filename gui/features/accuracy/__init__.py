"""How far off the depth is: against ground truth, or on hold-outs."""
