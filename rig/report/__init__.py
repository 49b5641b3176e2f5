"""What a run folder is turned into: figures, a report, a comparison of several runs."""
