"""What every law must do: the same for the same inputs, nothing left after a reset, no bump."""

from rig.testing.laws import LawSuite


class TestMyLaw(LawSuite):
    """The law in its experiment, on the simulated pair; run pytest where `configs` is."""

    configs, experiment = None, "my-law-sine"
