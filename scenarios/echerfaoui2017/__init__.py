"""Echerfaoui et al. 2017: a bridge CMM measured by a 6-D laser, neural nets for its 18 component errors, compensation."""
