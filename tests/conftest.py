"""Fixtures for all tests."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from pathlib import Path

import pytest

from subskin._cold import at_once

_SHARED = Path(__file__).resolve().parents[2] / "shared"


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder of reference values and recordings beside the repository; the test is skipped where there is none."""
    if not _SHARED.is_dir():
        pytest.skip("needs the reference values and recordings in ../shared, which do not ship with the project")
    return _SHARED


@pytest.fixture(scope="session", autouse=True)
def compiled_from_the_first_frame() -> Iterator[None]:
    """Digits do not depend on which loops other tests have had compiled."""
    with at_once():
        yield


gc.disable()


def pytest_collection_finish() -> None:
    """What is imported and collected stays: no search for garbage walks through the thousands of tests.

    Nor often through what tests make: little of it is left in circles.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 20)
    gc.enable()
