"""The tools: state machines in image coordinates, without widgets, and the editor that drives them."""
