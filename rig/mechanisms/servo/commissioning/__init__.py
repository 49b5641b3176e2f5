"""Steps of the acceptance test that all mechanisms on servo axes share."""
