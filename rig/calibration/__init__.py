"""Find what a profile cannot know, and keep it with where it came from."""
