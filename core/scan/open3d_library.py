"""Load open3d, with the shared library that its wheel for Linux needs and few machines have."""

from __future__ import annotations

import ctypes
import sys
from types import ModuleType

USB = "libusb-1.0.so.0"
"""Shared library that drives depth cameras: unused here, but open3d cannot be loaded without it."""


def load_open3d() -> ModuleType:
    """Return the module open3d.

    Where the system lacks `USB`, the copy in the package `libusb_package` is loaded first: the dynamic loader accepts a
    loaded library of the same SONAME.

    Raises:
        ImportError: where it, or another library that it needs, is missing.
    """
    if sys.platform == "linux":
        try:
            ctypes.CDLL(USB)
        except OSError:
            _load_packaged_usb()
    import open3d

    module: ModuleType = open3d
    return module


def _load_packaged_usb() -> None:
    import libusb_package

    try:
        ctypes.CDLL(str(libusb_package.get_library_path()), ctypes.RTLD_GLOBAL)
    except OSError as error:
        raise ImportError(f"{USB} cannot be loaded: {error}") from error
