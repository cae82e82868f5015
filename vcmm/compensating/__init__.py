"""Compensating: rewrite an NC program, a list of points or a control's table so that known machine errors cancel."""
