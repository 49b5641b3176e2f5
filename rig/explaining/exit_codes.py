"""What the exit codes of the program mean."""

from typing import Final

EXIT_CODES: Final = {
    "0": "It went well.",
    "1": "It ran to its end and missed a bound, swung, or moved off when it was released; of "
    "`rig faults`: any hazard; of `rig report`: none of its figures could be drawn; of "
    "`rig margins`: the run told no loop, or tuned gains were taken back.",
    "2": "A file, an option or code of yours is wrong. What had moved by then was made safe.",
    "3": "A device or the preflight says no; nothing was energised.",
    "4": "A fault while it ran, or the rig did not say in time that it is safe.",
    "70": "A bug in this program. The run folder has what is needed to report it.",
    "130": "It was interrupted and has made the rig safe.",
}
