"""A mechanism of our own: an axis on a servo drive, to begin with."""
