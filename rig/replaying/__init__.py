"""A recorded run again: its log through the code at hand, beside another run, or run once more."""
