"""Uncertainty of a task: streams, intervals, Monte Carlo, linear and exact model, budget, certificate."""
