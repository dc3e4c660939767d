"""Behind the command line: running, resuming, scenes by name."""
