"""Classical methods of depth completion to compare with: one module per family.

Each is a function of a frame (and of blocks, for the one that works block by block) that returns depth [m] of
shape (H, W), NaN where it does not fill. They share nothing with the filter.
"""
