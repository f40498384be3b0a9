"""Reports: what is asked for, and pages on paper."""
