"""Run queued jobs: the Celery application, its task and its worker process."""
