"""What is peculiar to calibrating legs: their jig, and the lines through what it shows."""
