"""A hand kept on one direction: what a period costs the joints, and how fast it may go."""
