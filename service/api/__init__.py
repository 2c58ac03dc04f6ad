"""The HTTP API: one module per resource; what is known of a job is in the rooms above it, not here."""
