"""Diagnosis: what physics does a recording hold that the machine model lacks? `engine.diagnose_recording` runs it all.

Order (each step one module): problem -> mistakes -> noise -> locate -> candidates, evidence, null -> select -> holdout
-> field (names against the unknown) -> confusion -> adequacy, neighbours -> power -> nextstep -> result.
"""
