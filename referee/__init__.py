"""A judge that counts what vcmm claims and shares no line with it.

Own kinematics, own fits, own parts, own noise and own machines, written from the standards (ISO 1101, ISO 5459,
ISO 14405-1, ISO 10360-2, ISO 230-1). It talks to vcmm by files and the command line alone:
``python -m referee --cells 'evaluate*' --parts 400 --seed 1 --out referee.jsonl``.
"""
