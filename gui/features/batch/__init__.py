"""Batches: frames of the list, completed in the background, each into its own folder."""
