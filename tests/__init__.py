"""A package, so that ``tests.vcan`` means this folder: others install a ``tests`` of their own."""
