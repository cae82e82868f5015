"""Effects that the program itself creates from files, certificates and calibrations; other modules import them directly, with their types."""
