"""The command line: a thin face over service and workers."""
