"""Diagnosis: find the physics in a recording that the machine file lacks.

Order of the steps, one module each: problem -> mistakes -> noise -> locate -> candidates, evidence, null_recordings -> select -> holdout
-> field (names against the unknown) -> rivals -> accepted_terms, unknown_shapes, kernels -> next_measurement -> assembly, result -> written_machine.
"""
