"""Read and write files of other systems: QIF, DCC, DMIS, Q-DAS. Their contents become plain values in the terms of vcmm."""
