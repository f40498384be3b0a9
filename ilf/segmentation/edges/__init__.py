"""Where surfaces may end: edges from colour and known depth."""
