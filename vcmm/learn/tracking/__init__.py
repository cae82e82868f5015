"""A machine followed in time: from recordings one after another to its state at a date, and its changes."""
