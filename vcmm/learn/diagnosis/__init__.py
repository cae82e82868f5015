"""Diagnosis: find the physics in a recording that the machine file lacks.

Order (each step one module): problem -> mistakes -> noise -> locate -> candidates, evidence, null -> select -> holdout
-> field (names against the unknown) -> confusion -> adequacy, neighbours -> power -> nextstep -> result.
"""
