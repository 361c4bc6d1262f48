"""Options on a command line: parsed, checked, listed by --help."""
