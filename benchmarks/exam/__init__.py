"""Blind exam of `vcmm diagnose`: recordings with a concealed effect, by code that shares nothing with the effects.

    machines    machines with known error tables        kinema      exact chains, 4x4 matrices
    designs*    how one measures                        concealed*  what is concealed, and what the catalogue lacks
    noise       worlds of scatter                       strength    delta: size in whitened units
    blocks      which cases a block holds               score       answers against the truth
    folds       strength in held-out rows               heldout     improved machines on new recordings
    addon*      the recommended measurement, taken      cost        seconds, and the same report twice
    baselines   plain methods on the same cases         calibration stated probabilities against what was right
    plans       cases in rounds                         results     result lines, written case by case
    bars        figures with a bar                      tables      all tables of tables.md and docs/exam.md
    asking      the command and its JSON                run         the command line

The product is reached as its users reach it, by files and its command (`asking`); `heldout` predicts with machine files that
the command wrote. Nothing here imports effects or search.
"""
