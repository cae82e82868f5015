"""Shared test helpers. VCMM_DATA names the folder of recordings and certified data; absent files skip with a reason."""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

# Thousands of collected tests and the trees of every module live as long as the run: with the thresholds of an
# interpreter that has just started, looking for cycles among them takes a quarter of the processor.
gc.set_threshold(100_000, 20, 100)


def pytest_collection_finish() -> None:
    """What was collected stays: the search for cycles leaves it out."""
    gc.collect()
    gc.freeze()


@pytest.fixture(autouse=True)
def close_figures() -> Iterator[None]:
    """Figures of pyplot end with their test: left open, the twenty-first warns in whichever test comes then."""
    yield
    if pyplot := sys.modules.get("matplotlib.pyplot"):
        pyplot.close("all")


@pytest.fixture(scope="module")
def few_parts() -> Iterator[None]:
    """Belts of the true form from a tenth of the parts, for modules that evaluate forms and ask nothing of those belts.

    Three quarters of a small evaluation are spent on them; tests/answer/evaluation/test_inversion.py asks for them.
    """
    from vcmm.answer.evaluation import inversion

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(inversion, "PARTS", (600, 600))
        patch.setattr(inversion, "COUNT_TRIALS", (60, 60))
        yield


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
