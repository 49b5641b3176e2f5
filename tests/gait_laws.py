"""The laws of the papers and their first rival, which pass along one path in four ways."""

from controllers.gait.laws import InverseLaw, LimitedNormLaw, MinimumJerkLaw, TrapezoidNormLaw

LAWS = (InverseLaw, LimitedNormLaw, TrapezoidNormLaw, MinimumJerkLaw)
"""In the order in which they are compared."""
