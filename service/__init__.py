"""What must last: settings, database models, the job state machine and the artifact store."""
