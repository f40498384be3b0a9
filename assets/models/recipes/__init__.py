"""Recipes of the networks, one file each: model, samples and loss. `train.py` trains them."""
