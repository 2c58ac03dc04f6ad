"""Turn queued jobs into results: the Celery application and its task."""
