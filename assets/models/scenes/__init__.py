"""Endless scenes made at random, with exact depth: pictures to train the networks on."""
