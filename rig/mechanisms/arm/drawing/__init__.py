"""From a description that others wrote, URDF or Denavit-Hartenberg, to a profile's geometry."""
