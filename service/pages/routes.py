"""All pages."""

from __future__ import annotations

from fastapi import APIRouter

from . import (
    base_patterns_page,
    compare_page,
    edit_page,
    fabrics_page,
    files_page,
    job_page,
    jobs_page,
    keys_page,
    labels_page,
    match_page,
    queue_page,
    result_page,
    session,
    shared_page,
    static_files,
    subjects_page,
    webhooks_page,
)

router = APIRouter(include_in_schema=False)
for module in (
    session,
    static_files,
    files_page,
    jobs_page,
    job_page,
    result_page,
    match_page,
    compare_page,
    edit_page,
    labels_page,
    shared_page,
    subjects_page,
    fabrics_page,
    base_patterns_page,
    queue_page,
    webhooks_page,
    keys_page,
):
    router.include_router(module.router)
