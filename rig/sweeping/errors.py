"""A sweep that cannot go on where it is."""

from rig.hal import DeviceError


class SweepStopped(DeviceError):
    """The folder, the disk, the cluster or the code of a sweep is not as it should be.

    What is finished is kept, and the same command goes on from there.
    """
