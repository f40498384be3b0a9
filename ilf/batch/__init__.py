"""Batches: many frames, completed by several processes or machines, with one folder per frame; resumable."""
