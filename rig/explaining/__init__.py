"""What the program's words mean: keys of files, measures, commands, exit codes, and faults."""
