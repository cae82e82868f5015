"""What the program itself makes of files, certificates and calibrations: imported directly, and typed, by whoever needs it."""
