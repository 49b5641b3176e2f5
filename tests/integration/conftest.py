"""Fixtures of whole commands."""

from broken_package import plug_in

__all__ = ["plug_in"]
