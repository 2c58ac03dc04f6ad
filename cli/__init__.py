"""The command line, on top of service and workers."""
