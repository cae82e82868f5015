"""Files of other systems, in and out: QIF, DCC, DMIS, Q-DAS. What they hold becomes plain values in the words of vcmm."""
