"""Uncertainty evaluated: random streams, intervals, Monte Carlo, linear and exact models, budget."""
