"""Many runs of one experiment under other settings: points, engines, table and figure."""
