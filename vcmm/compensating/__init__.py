"""NC programs, points and tables rewritten so that known errors of the machine cancel, with their proof.

Imports core, nc, nc.iso, nc.sinumerik, nc.heidenhain, motion, cutting, evaluation, machining, files.
"""
