"""Persistent state of the service: settings, database models, the job state machine and the artifact store."""
