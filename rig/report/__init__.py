"""Figures, a report and comparisons, made from run folders."""
