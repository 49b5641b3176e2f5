"""Named tuples as the cycle makes them."""

new_tuple = tuple.__new__
"""Makes a named tuple of a class from a tuple of its fields, in half the time that the class itself
takes: ``new_tuple(PairCommand, (agonist, antagonist))``."""
