"""Rewrite NC programs, points and tables so that known errors of the machine cancel, and prove the result."""
