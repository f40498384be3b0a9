"""The sweep: many values of one parameter or of two, each evaluated and shown."""
