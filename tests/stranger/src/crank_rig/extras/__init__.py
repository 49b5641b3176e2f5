"""What this lab adds to mechanisms of others."""
