"""Run the command line as `python -m rig`."""

from rig.cli import main

main()
