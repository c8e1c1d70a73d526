"""What one test leaves behind in its process is not there for the next one."""

from __future__ import annotations

import gc
from collections.abc import Iterator

import pytest

from hacheck.rational import Meter

WORK = Meter.left


@pytest.fixture(autouse=True)
def collected() -> Iterator[None]:
    """Garbage is collected again after a test that called `hacheck` as a function: a run of it does without."""
    yield
    gc.enable()


@pytest.fixture(autouse=True)
def rested() -> None:
    """What an earlier test had `hacheck` do does not count against its budget of work."""
    Meter.left = WORK
