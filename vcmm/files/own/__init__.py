"""Formats of vcmm itself: machines, scenarios, recordings, plans and set-ups, read with line numbers and written."""
