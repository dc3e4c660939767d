"""Behind the command line: arguments, and scenes by name."""
