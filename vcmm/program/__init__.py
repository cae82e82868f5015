"""Readers of NC programs in all languages: moves, tools, set-up, state of the control, cutter compensation."""
