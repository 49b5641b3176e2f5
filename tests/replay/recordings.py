"""The runs of the corpus: every rig, every law, and what may happen on the way."""

from replay.recording import Recording

_STOP = (1.4, "stop")
"""In the run: it begins 1.2 s after the loop did."""
_SHORT = ("approach=0.2 s",)
_SLOW = (*_SHORT, "loop.rate=250 Hz", "devices.regulators.setpoint_deadline=20 ms")
"""Pneumatic rigs at a quarter of their rate: a quarter of the cycles."""
_FASTER = ("loop.rate=500 Hz",)
"""For a loop that swings at a quarter of its rate, and is stopped for it."""
_BEND = (*_SHORT, "reference.repeats=1", "reference.time=1 s")
"""One quick knee bend, whose plan is soon made."""


def _pairs():
    laws = ("pid", "pid-friction", "cascade", "super-twisting")
    for law in laws:
        ideal = ("rig=cylinder-ideal",) if law == "super-twisting" else ()  # the one that has it
        yield Recording(
            f"cylinder-{law}-step", f"{law} jumps and is stopped in the step", "cylinder-step",
            "sim", (*_SLOW, *ideal, f"controller={law}"), (_STOP,),
        )  # fmt: skip
        yield Recording(
            f"cylinder-{law}-sine", f"{law} follows a sine to its end", "cylinder-sine",
            "virtual",
            (*_SLOW, *ideal, f"controller={law}", "reference.tones=[{frequency: 8 Hz, periods: 2}]",
             "reference.amplitude=0.5 mm", *(_FASTER if law == "pid" else ())),
            status="ok",
        )  # fmt: skip
        yield Recording(
            f"cylinder-low-speed-{law}", f"{law} as it is tuned for low-speed seals",
            "cylinder-ideal-staircase-low-speed", "virtual",
            (*_SHORT, f"controller={law}", "loop.rate=500 Hz"), (_STOP,),
        )  # fmt: skip
    happen = {
        "stop-energising": ("stopped before control begins", ((0.5, "stop"),), "aborted"),
        "stop-approach": ("stopped on its way to the start", ((1.1, "stop"),), "aborted"),
        "stop-twice": ("stopped at once while it brakes", (_STOP, (1.5, "stop")), "aborted"),
        "late": ("single late cycles", ((1.25, "pause", 6e-3), (1.3, "pause", 9e-3), _STOP),
                 "aborted"),
        "late-braking": ("late while it brakes", (_STOP, (1.5, "pause", 9e-3)), "aborted"),
        "stalled": ("late for too long", ((1.3, "pause", 0.4),), "faulted"),
        "silent": ("the regulators fall silent",
                   ((1.3, "break", "regulators", "silent", None),), "faulted"),
        "emergency-stop": ("the contact opens",
                           ((1.3, "break", "regulators", "emergency_stop", 1.0),), "faulted"),
        "wire-cut": ("a wire is cut", ((1.3, "break", "plant", "wire_cut", 0.0),), "faulted"),
        "supply-lost": ("the supply is lost", ((1.3, "break", "plant", "supply_lost", None),),
                        "faulted"),
        "jump": ("an encoder jumps",
                 ((1.3, "break", "encoder-agonist", "jump", None),), "faulted"),
        "lost-frames": ("some readings are old",
                        ((1.2, "break", "can0", "frame_loss", 0.02), _STOP), "aborted"),
    }  # fmt: skip
    for name, (reason, events, status) in happen.items():
        yield Recording(
            f"cylinder-{name}", reason, "cylinder-sine", "virtual", _SLOW, events, status
        )
    yield Recording(
        "cylinder-full-rate", "at its own rate", "cylinder-sine", "virtual", _SHORT,
        ((0.3, "stop"),),
    )  # fmt: skip
    yield Recording(
        "cylinder-locked", "chambers that hold their pressure when it is released",
        "cylinder-sine", "virtual", (*_SLOW, "rig=cylinder-locked"), (_STOP,),
    )  # fmt: skip


def _joints():
    for law in ("pid", "pid-friction", "cascade", "super-twisting"):
        yield Recording(
            f"joint-{law}", f"{law} turns the joint", "joint-ideal-circle", "sim",
            (*_SLOW, f"controller={law}"), (_STOP,),
        )  # fmt: skip
    yield Recording("joint-poses", "from pose to pose", "joint-poses", "virtual", _SLOW, (_STOP,))
    yield Recording(
        "joint-stiffness", "forces without control", "joint-stiffness", "virtual", _SLOW, (_STOP,)
    )
    yield Recording(
        "joint-wide", "beyond 40 degrees", "joint-wide", "sim", (*_SLOW, "approach=1.5 s"),
        ((2.7, "stop"),),
    )  # fmt: skip
    yield Recording(
        "joint-learning", "laps that are learnt from", "joint-circle-learning-fast", "sim",
        (*_SHORT, "loop.rate=500 Hz", "reference.tones=[{frequency: 5 Hz}]",
         "reference.tilt=2 deg", "reference.laps=3"), ((2.1, "stop"),),
    )  # fmt: skip
    camera = (*_SHORT, "loop.rate=500 Hz")
    for name, reason, events, status in (
        ("camera", "the camera corrects", (_STOP,), "aborted"),
        ("lost-images", "images are lost and come back",
         ((1.1, "break", "camera", "covered", 0.1), (1.3, "break", "camera", "lost", 0.1),
          (1.6, "stop")), "aborted"),
        ("late-images", "images are late", ((1.1, "break", "camera", "late", 0.03), _STOP),
         "aborted"),
        ("unplugged", "the camera is unplugged",
         ((1.3, "break", "camera", "unplugged", None),), "faulted"),
    ):  # fmt: skip
        yield Recording(
            f"joint-{name}", reason, "joint-circle-camera", "virtual", camera, events, status
        )
    for name, reason, events, status in (
        ("late", "late cycles", ((1.3, "pause", 9e-3), (1.35, "pause", 6e-3), _STOP), "aborted"),
        ("wire-cut", "a wire is cut", ((1.3, "break", "plant", "wire_cut", 2.0),), "faulted"),
        ("stop-approach", "stopped on its way to the start", ((1.1, "stop"),), "aborted"),
        ("frozen", "an encoder says the same for ever",
         ((1.1, "break", "encoder-2", "frozen", None),), "faulted"),
    ):  # fmt: skip
        yield Recording(
            f"joint-{name}", reason, "joint-ideal-circle", "virtual", _SLOW, events, status
        )


def _arms():
    for law in ("inverse", "servo-halt", "esc-paper", "esc"):
        yield Recording(
            f"arm-{law}-turnback", f"{law} on a line to the boundary", "arm-elbow-turnback",
            "sim", (*_SHORT, f"controller={law}"), ((2.2, "stop"),),
        )  # fmt: skip
    yield Recording(
        "arm-dls-circle", "dls on a circle that touches the boundary", "arm-elbow-circle", "sim",
        (*_SHORT, "controller=dls"), ((2.2, "stop"),),
    )  # fmt: skip
    yield Recording(
        "arm-look-ahead-near-miss", "as fast as the joints allow", "arm-shoulder-near-miss", "sim",
        (*_SHORT, "reference.before=10 mm", "reference.after=30 mm"), ((2.2, "stop"),),
    )  # fmt: skip
    for path in ("elbow-circle", "shoulder-circle", "elbow-dwell", "wrist-hit"):
        yield Recording(
            f"arm-{path}", f"the law of {path} on its own path", f"arm-{path}", "virtual", _SHORT,
            (_STOP,),
        )  # fmt: skip
    yield Recording(
        "arm-odrive", "drives of another make", "arm-elbow-turnback", "virtual",
        (*_SHORT, "rig=arm-odrive"), (_STOP,),
    )  # fmt: skip
    for name, reason, events, status in (
        ("stop-energising", "stopped before control begins", ((0.6, "stop"),), "aborted"),
        ("stop-approach", "stopped on its way to the start", ((1.1, "stop"),), "aborted"),
        ("late", "late cycles hold the motion", ((1.3, "pause", 12e-3), (1.5, "pause", 7e-3),
                                                 (1.7, "stop")), "aborted"),
        ("late-fault", "a fault after a late cycle",
         ((1.3, "pause", 7e-3), (1.5, "break", "drives.q2", "drive_fault", None)), "faulted"),
        ("silent", "a drive falls silent", ((1.5, "break", "drives.q3", "silent", None),),
         "faulted"),
        ("stalled", "late for too long", ((1.5, "pause", 0.4),), "faulted"),
    ):  # fmt: skip
        yield Recording(
            f"arm-{name}", reason, "arm-elbow-turnback", "virtual", _SHORT, events, status
        )


def _legs():
    for law in ("inverse", "sc", "sc-trapezoid", "min-jerk", "sc-per-leg", "clamp", "dls"):
        yield Recording(
            f"legs-{law}-squat", f"{law} squats", "legs-squat", "sim",
            (*_BEND, f"controller={law}"), (_STOP,),
        )  # fmt: skip
    for name, experiment, reason, events, status in (
        ("walk", "legs-walk", "a step, and a stop in it", ((1.7, "stop"),), "aborted"),
        ("walk-trapezoid", "legs-walk-trapezoid", "a step with ramps of the joints' norm",
         ((1.7, "stop"),), "aborted"),
        ("late", "legs-squat", "late cycles hold the motion",
         ((1.3, "pause", 12e-3), (1.5, "pause", 7e-3), (1.7, "stop")), "aborted"),
        ("stop-twice", "legs-squat", "stopped at once while it brakes", (_STOP, (1.5, "stop")),
         "aborted"),
        ("overheated", "legs-squat", "a servo is too hot",
         ((1.5, "break", "servos", "right_knee.overheated", None),), "faulted"),
        ("unplugged", "legs-squat", "the chain is unplugged",
         ((1.5, "break", "chain", "unplugged", None),), "faulted"),
    ):  # fmt: skip
        yield Recording(
            f"legs-{name}", reason, experiment, "virtual",
            _SHORT if experiment.startswith("legs-walk") else _BEND, events, status,
        )  # fmt: skip
    yield Recording(
        "legs-footsteps", "a step round a bend", "legs-footsteps", "virtual", _SHORT,
        ((4.5, "stop"),),
    )  # fmt: skip
    yield Recording(
        "legs-can", "drives on two buses", "legs-squat", "virtual", (*_BEND, "rig=legs-can"),
        (_STOP,),
    )  # fmt: skip


RECORDINGS = {r.name: r for part in (_pairs, _joints, _arms, _legs) for r in part()}
