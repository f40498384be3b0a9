"""EBS: where surfaces may end, the operation blocks between, their editing and their propagation."""
