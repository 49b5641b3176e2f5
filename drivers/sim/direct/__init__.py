"""Devices of `--on sim`: the capabilities straight on a plant, without a bus."""
