"""What people have: machines, scenarios, recordings, plans and tables of other programs, read with line numbers and written.

Imports core, part, gps, effects, nc, cutting, measuring, response, certified, instruments, inference, routes,
machining.
"""
