"""Dates of recordings as days."""

from __future__ import annotations

from datetime import datetime, timedelta

from vcmm.core.errors import UsageError

DAY = 86400.0  # s


def moment(date: str) -> float:
    """Return days since 1970-01-01, by the clock of the shop. Raises UsageError for a text that is no date."""
    try:
        day = datetime.fromisoformat(date)
    except ValueError:
        raise UsageError(f'"{date}" is no date; write for example 2026-12-01 or 2026-12-01T14:30') from None
    return (day.replace(tzinfo=None) - datetime(1970, 1, 1)).total_seconds() / DAY


def date_of(when: float) -> str:
    """Return the day, ISO 8601."""
    return (datetime(1970, 1, 1) + timedelta(days=when)).date().isoformat()
