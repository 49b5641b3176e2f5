"""The suites of the rig controller, for what this package offers."""

pytest_plugins = "rig.testing.plugin"
