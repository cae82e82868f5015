"""Every colour in both themes."""

from __future__ import annotations

import pytest

from vcmm.core.errors import UsageError
from vcmm.show.report import blocks as report
from vcmm.show.report.palette import DARK, LIGHT, hex_of


def test_every_role_has_both_themes() -> None:
    assert LIGHT.keys() == DARK.keys()
    html = report.page("t", [])
    for role in LIGHT:
        assert html.count(f"--{role}:") == 2
    with pytest.raises(UsageError, match='Did you mean "accent"'):
        hex_of("acent")
