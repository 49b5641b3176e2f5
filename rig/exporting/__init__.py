"""The formats that a log is exported to, each in memory that does not grow with the run."""
