"""CAN interfaces behind one seam."""
