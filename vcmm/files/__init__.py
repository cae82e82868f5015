"""Read files with line numbers, and write them: TOML and tables here, own formats and those of other systems in the folders."""
