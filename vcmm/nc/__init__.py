"""What NC programs of all controls have in common: moves, tools, set-up, state of the control, cutter compensation.

Imports core.
"""
