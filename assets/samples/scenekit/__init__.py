"""Endless scenes made at random, with exact depth: pictures to train the depth-edge network on."""
