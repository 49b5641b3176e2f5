"""A load cell behind an analogue input: logged, and used by nobody."""
