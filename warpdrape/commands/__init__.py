"""Behind the command line: arguments, scenes by name, progress."""
