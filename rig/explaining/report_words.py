"""Words that reports, tables and options have, and no file: what each means."""

from typing import Final

REPORT_WORDS: Final = {
    "sim": "A backend: the simulated rig without buses; its devices are read directly, in "
    "virtual time.",
    "virtual": "A backend: the simulated rig behind its real drivers and emulated nodes, frame by "
    "frame, in virtual time and as quick as the computer is. The default.",
    "vcan": "A backend: as virtual, over the kernel's virtual CAN and in real time.",
    "hardware": "A backend: the rig itself, on the interfaces that its profile names.",
    "sensitivity": "Of a loop: the greatest factor by which it amplifies a disturbance. It is 1 "
    "over the least distance to instability; below 2 is good, above 3 little is left.",
    "stable": "Of a loop: whether it comes to rest without Coulomb friction, as a linear model "
    "says. 'no: friction holds it' is no fault: seals damp what the model leaves out, and the "
    "shipped laws are tuned on simulated seals; slippery ones let them swing. `rig tune` looks "
    "for gains with a margin of their own.",
    "linear loop": "Of a law in a table of `rig compare`: whether its loop is stable as a linear "
    "model says, see `rig explain stable`. 'unknown' is that of a law from elsewhere, whose "
    "equations the model does not know; that says nothing against it.",
    "crossover": "Of a loop: the greatest frequency at which its gain is 1, rad/s; it follows what "
    "is slower.",
    "phase": "Of a loop: its phase margin, how much more lag it bears before it swings. In a log: "
    "the phase of the run (energise, approach, run, brake, stop).",
    "more dead time": "Of a loop: how much later regulators may answer before it swings, s.",
}
