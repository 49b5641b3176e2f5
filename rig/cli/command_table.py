"""The commands by name: where each one is, and its line in the help."""

COMMANDS = {
    "run": ("rig.cli.run:run", "Run an experiment and leave a run folder."),
    "compare": ("rig.cli.compare:compare", "Run an experiment under several controllers."),
    "sweep": ("rig.cli.sweep:sweep", "Run an experiment under many settings, resumable."),
    "new": ("rig.cli.new:new", "Write an experiment, rig, law or driver to begin with."),
    "check": ("rig.cli.check:check", "Check a profile and show what it says."),
    "doctor": ("rig.cli.doctor:doctor", "Say what this computer lacks for a rig."),
    "status": ("rig.cli.status:status", "Show how far a rig has come, and what comes next."),
    "commission": ("rig.cli.commission:commission", "Test a physical rig before it is used."),
    "calibrate": ("rig.cli.calibrate:calibrate", "Find what a profile cannot know, and keep it."),
    "tune": ("rig.cli.tune:tune", "Find gains that a rig and its uncertainty bear."),
    "margins": ("rig.cli.margins:margins", "Measure how far a loop is from instability."),
    "watch": ("rig.cli.watch:watch", "Show a run in a browser, also while it goes on."),
    "stop": ("rig.cli.stop:stop", "Stop a run that goes on, from another terminal."),
    "reset": ("rig.cli.reset:reset", "Reset a rig's latched fault."),
    "simulate": ("rig.cli.simulate:simulate", "Put a rig's emulated devices on a real bus."),
    "monitor": ("rig.cli.monitor:monitor", "Show recorded or live frames in a rig's names."),
    "faults": ("rig.cli.faults:faults", "Break a rig in simulation, and judge what comes of it."),
    "list": ("rig.cli.listing:listing", "List rigs, experiments and runs."),
    "explain": ("rig.cli.explain:explain", "Say what a word means, or why a run stopped."),
    "report": ("rig.cli.report:report", "Make a run's figures and report again."),
    "export": ("rig.cli.export:export", "Write a run's log for other programs."),
    "rerun": ("rig.cli.rerun:rerun", "Run a run again, from its folder alone."),
    "diff": ("rig.cli.diff:diff", "Show what two runs differ in."),
    "replay": ("rig.cli.replay:replay", "Feed a run's log to the code at hand."),
    "schema": ("rig.cli.schema:schema", "Print the JSON Schema of a file, for editors."),
    "completion": ("rig.cli.completion:completion", "Print a shell's completion script."),
}

INTRODUCTION = """\
Run experiments on a research rig, on hardware or in simulation.

Start with `rig run cylinder-sine`: an antagonistic pair of pneumatic
cylinders tracks a sine over emulated CANopen devices. `rig list` shows what
else there is.
"""
