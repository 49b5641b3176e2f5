"""Packages that work as they are, and that `rig new` copies under another name."""
