"""Places for the hand to go through: out of files, seen in frames, with how the tool turns."""
