"""What the loop needs to know of each mechanism: its state, limits and log columns."""
