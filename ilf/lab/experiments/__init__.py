"""The paper's experiments: run, drawn, written, and reported beside the paper's results."""
