"""Programs that run inside other programs' interpreters; they are copied, not imported."""
