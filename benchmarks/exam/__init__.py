"""Blind exam of `vcmm diagnose`: recordings with a concealed effect, by code that shares nothing with the effects.

    machines    machines with known error tables        kinema      exact chains, 4x4 matrices
    designs*    how one measures                        concealed*  what is concealed, and what the catalogue lacks
    noise       worlds of scatter                       strength    delta: size in whitened units
    blocks      which cases a block holds               score       answers against the truth
    baselines   plain methods on the same cases         run         the command line

Nothing here imports vcmm: the product is reached as its users reach it, by files and its command.
"""
