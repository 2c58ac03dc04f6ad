"""The skirt that fits of pattern and bending begin at."""

from __future__ import annotations

import pytest
from worn_skirt import Worn, drape_skirt


@pytest.fixture
def scene() -> Worn:
    """Return the worn skirt, draped once in a process."""
    return drape_skirt()
