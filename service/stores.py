"""Choice of the store by its address: a folder or an S3 bucket."""

from __future__ import annotations

from .s3 import S3Store
from .settings import ServiceSettings
from .store import Store


def open_store(settings: ServiceSettings, must_exist: bool = False) -> Store:
    """Open the store at GARMENTQ_STORE: `s3://bucket/prefix`, or a folder, which with `must_exist` has to exist.

    Raises:
        DriverMissing: if an S3 store is named and boto3 is missing.
    """
    if settings.is_store_remote:
        return S3Store(settings.store, settings.s3_endpoint, settings.home / "cache")
    return Store(settings.store_path, must_exist)
