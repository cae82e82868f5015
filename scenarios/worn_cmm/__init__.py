"""A worn measuring machine: a log with concealed faults, diagnosed, and a measuring task before and after."""
