"""Propagate knowledge through a task: uncertainty, true values from measured ones, placement, second routes to a result."""
