"""What people have, read with line numbers and written: TOML and tables here, own formats and those of other systems below."""
