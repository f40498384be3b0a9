"""EBS: edges, operation blocks, their editing and their propagation."""
