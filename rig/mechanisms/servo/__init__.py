"""What the mechanisms on servo drives share."""
