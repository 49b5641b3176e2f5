"""Device drivers behind the hardware abstraction layer of `rig.hal`."""
