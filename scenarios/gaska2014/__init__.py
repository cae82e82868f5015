"""Gaska et al. 2014: a virtual CMM from nodes with residual errors, five places of one part."""
