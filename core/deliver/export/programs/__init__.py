"""Programs that run inside other programs' own interpreters; nothing here is imported, the files are copied."""
