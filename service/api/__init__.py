"""The HTTP API, one module per resource; the logic of jobs is in the other modules of `service`."""
