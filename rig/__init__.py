"""Hardware-in-the-loop rig controller: one program for a lab's research rigs."""
