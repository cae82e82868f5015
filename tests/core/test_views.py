"""Pictures and lines come from vcmm.show, loaded when the first is asked for."""

from __future__ import annotations

import subprocess
import sys

import pytest

from vcmm.core import views
from vcmm.core.errors import UsageError


def test_a_class_without_a_picture_is_refused_by_name():
    with pytest.raises(UsageError, match="complex has no picture"):
        views.draw(1j)
    with pytest.raises(UsageError, match="complex has no line"):
        views.say(1j)


@pytest.mark.thorough
def test_charts_are_loaded_by_the_first_line_and_not_before():
    """In a process of its own: the module of a result loads no charts, its line does."""
    story = """
import sys
from types import SimpleNamespace
import vcmm.answer.evaluation.result as result
assert not any(m.startswith("vcmm.show") for m in sys.modules), "before"
from vcmm.core import views
try:
    views.say(SimpleNamespace())
except Exception as error:
    assert "has no line" in str(error), error
assert "vcmm.show.charts" in sys.modules, "after"
"""
    done = subprocess.run([sys.executable, "-c", story], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
