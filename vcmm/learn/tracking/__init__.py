"""A machine followed in time: recordings one after another to what is known of it at a date, and what changed."""
