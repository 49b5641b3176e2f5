"""Friction on the ball, period by period."""

from controllers.spherical_joint.ball_friction import slide


class BallFriction:
    """Remembers the deflections that `slide` goes on from."""

    def __init__(self, ring, wire, distance, period):
        self._constants = (ring, wire, period / distance)
        self.reset()

    def reset(self):
        self._deflections = ((0.0, 0.0), (0.0, 0.0))

    def update(self, velocity, tension):
        force, *self._deflections = slide(*self._constants, *self._deflections, velocity, tension)
        return force
