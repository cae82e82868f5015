"""Shared test helpers. VCMM_DATA names the folder of recordings and certified data; absent files skip with a reason."""

from __future__ import annotations

import gc
import os
from pathlib import Path

import pytest

# Thousands of collected tests and the trees of every module live as long as the run: with the thresholds of an
# interpreter that has just started, looking for cycles among them takes a quarter of the processor.
gc.set_threshold(100_000, 20, 100)


def pytest_collection_finish() -> None:
    """What was collected stays: the search for cycles leaves it out."""
    gc.collect()
    gc.freeze()


def data_file(relative: str) -> Path:
    """Path of a file under VCMM_DATA; skips the test (fails in CI) when it is absent."""
    root = os.environ.get("VCMM_DATA")
    reason = "VCMM_DATA is not set: it names the folder with reference data" if not root else ""
    path = Path(root or ".") / relative
    if not reason and not path.exists():
        reason = f"{path} is missing"
    if reason and os.environ.get("VCMM_DATA_REQUIRED"):
        pytest.fail(reason)
    if reason:
        pytest.skip(reason)
    return path
