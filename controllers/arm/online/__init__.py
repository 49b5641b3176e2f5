"""Twists that come from outside while the arm moves, and the laws that follow them."""
