"""The command line: a file for each command, with what it takes and what it calls."""
