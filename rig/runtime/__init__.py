"""The fixed-rate cycle, what keeps it safe, and what it leaves on disk."""
