"""One module per procedure."""
