"""The paper's experiments: run, drawn, written, and reported beside what the paper says."""
