"""Gaska et al. 2014: a virtual CMM from a grid of nodes with residual errors."""
