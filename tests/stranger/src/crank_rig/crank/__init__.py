"""Two cranks that a rod couples, each on a servo drive of its own."""
