"""The history of the tables, run by Alembic."""

HEAD = "0020"
"""The newest revision; a test compares it with the scripts, so that an up-to-date database is told without Alembic."""
