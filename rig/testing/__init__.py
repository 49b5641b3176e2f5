"""What everything that the contract names must do, as tests: ours pass them, and so may yours.

Opt in with ``pytest_plugins = "rig.testing.plugin"`` in the ``conftest.py`` at the root of your
tests. Then inherit a suite and say what it is about::

    from rig.testing.devices import PressureRegulatorSuite

    class TestOurRegulators(PressureRegulatorSuite):
        configs, rig, device = CONFIGS, "our-rig", "regulators"

`devices` has a suite for each capability, `laws`, `motions`, `mechanisms`, `plants` and `scenes`
one each, about what an experiment names. Nothing but this package imports pytest.
"""
