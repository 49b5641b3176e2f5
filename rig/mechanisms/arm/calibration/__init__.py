"""What is peculiar to calibrating an arm: its model, its poses, the fit."""
