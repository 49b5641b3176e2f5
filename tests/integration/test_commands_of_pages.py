"""Every command that a page shows is one that the program takes, with names that there are.

None of them moves anything here: what the command line itself makes of it is asked. Those that
only look are really run. What comes out of the others is compared in `test_documents.py`.
"""

import itertools
from functools import cache
from pathlib import Path

import click
import pytest
from shown_commands import PAGES, ROOT, commands_of

from rig.assembly import REGISTRY
from rig.calibration.catalogue import pick
from rig.cli import compare, invoke
from rig.cli.commands import group
from rig.cli.names import with_seed
from rig.config import load_profile
from rig.config.names import find_configs
from rig.experiment.plan import Plan, load_plan
from rig.faults.campaign import draw_once
from rig.faults.survey import experiments_of, survey
from rig.hal import ConfigurationError, RigError
from rig.sweeping.axis import parse_axis, parse_seeds
from rig.sweeping.design import make_design
from rig.sweeping.request import SweepRequest
from rig.sweeping.sweep_file import is_sweep_file, load_sweep

RIGS = ("cylinder", "joint", "arm", "legs", "cylinder-valves", "cylinder-locked")
FILLED = {
    "RIG": RIGS,
    "PROFILE": RIGS,
    "ARM": ("arm",),
    "EXPERIMENT": ("cylinder-sine",),
    "FILE": ("configs/rigs/cylinder.yaml", "configs/sweeps/cylinder.yaml"),
    "LAW": ("pid",),
    "NAME": ("esc",),
    "WORD": ("bore",),
    "KEY": ("cylinder.bore",),
    "KIND": ("arm-path",),
    "COMMAND": ("run",),
    "HOURS": ("0.1",),
    "INTERFACE": ("vcan0",),
    "a.b=c": ("cylinder.home=31mm",),
    "a.b=c,d": ("controllers.cascade.position_rate=20,30",),
    "a.b=1..5:9": ("controllers.cascade.position_rate=20..30:3",),
    # What a page has its reader write or unpack before.
    "my-rig": ("cylinder",),
    "your-rig": ("cylinder",),
    "my-rig.yaml": ("cylinder",),
    "lab/my-rig.yaml": ("cylinder",),
    "my-arm.yaml": ("arm",),
    "my-drives.yaml": ("arm-loaded",),
    "my-sine.yaml": ("cylinder-sine",),
    "my-arc.yaml": ("arm-tour",),
    "my-path.yaml": ("arm-path",),
}
"""What may stand for a word of a page that its reader fills in: one of them has to be taken."""
REFUSED = {"controllers.cascade.position_rat=20", "reference.size=5 mm"}
"""Settings that a page shows because they are refused."""


def filled(words):
    """Yield a command with all that its reader would fill in, in each way that there is."""
    blanks = [word for word in FILLED if word in words]
    for chosen in itertools.product(*(FILLED[word] for word in blanks)):
        given = dict(zip(blanks, chosen, strict=True))
        yield [given.get(word, word) for word in words]


def parsed(words, monkeypatch):
    """Return what click makes of a command: its name, its parameters and what it is given."""
    invoke_group = click.Command.invoke

    def held(command, context):
        return invoke_group(command, context) if isinstance(command, click.Group) else context

    with monkeypatch.context() as patch:
        patch.setattr(click.Command, "invoke", held)
        context = group.main([*words], prog_name="rig", standalone_mode=False)
    if isinstance(context, int):  # --help
        return "", {}
    return context.command_path.removeprefix("rig "), context.params


def unplanned(experiment, profile):
    """Return a plan without its motion, which takes seconds and has tests of its own.

    On another rig than the experiment's it may be none: there it is planned.
    """
    if experiment.controller not in profile.controllers:
        raise ConfigurationError(f"{profile.name} has no controller {experiment.controller}")
    return Plan(experiment, profile, None, None)


def plan_of(given, more=()):
    """Load an experiment with the settings of a command."""
    options = [*with_seed(given["overrides"], given.get("seed")), *more]
    if given.get("controller"):
        options.append(f"controller={given['controller']}")
    return load_plan(given["experiment"], options, rig=given["rig_name"])


def planned(given):
    plan_of(given)


def compared(given):
    plan = plan_of(given)
    names = (plan.experiment.controller,)
    if given["controllers"] is not None or given["vary"] is None:
        names = compare._chosen(given["controllers"], tuple(plan.profile.controllers))
    for _, own in compare._variants(names, given["vary"]):
        plan_of(given, own)


def swept(given):
    name = given["experiment"]
    file = load_sweep(Path(name)) if is_sweep_file(name) else SweepRequest(name)
    axes = (*file.axes, *map(parse_axis, given["axes"]))
    seeds = parse_seeds(given["seeds"]) if given["seeds"] else file.seeds
    design = make_design(axes, seeds, file.draw_seed)
    rig = given["rig_name"] or file.rig
    asked = {**given, "experiment": file.experiment, "rig_name": rig}
    asked["overrides"] = (*file.options, *given["overrides"])
    for point in {0, design.count - 1}:
        plan_of(asked, design.options(point))


def tuned(given):
    profile = profile_of(given["rig"], given["overrides"])
    assert given["controller"] in profile.controllers, f"no controller {given['controller']}"
    if given["experiment"]:
        load_plan(given["experiment"])


def calibrated(given):
    profile = profile_of(given["rig"], given["overrides"])
    pick(profile, given["procedures"])


def profile_of(name, overrides=()):
    return load_profile(name, REGISTRY, overrides, find_configs(None))


def measured(given):
    """Look at settings as `rig margins` does: of the rig, or of the experiment that shakes it."""
    profile = profile_of(given["rig"])
    experiment = f"{profile.mechanism}-margins"
    plan_of({**given, "experiment": experiment, "rig_name": given["rig"]})


def broken(given):
    for rig in given["rigs"]:
        profile_of(rig)
        if given["only"]:
            subject = survey(rig, experiments_of(rig, None)[:1], None)
            assert [*draw_once(subject, tuple(given["only"].split("+")), 0, 1)]


def of_rig(given):
    if given.get("rig"):
        profile_of(given["rig"], given.get("overrides", ()))


NAMES = {
    "run": planned, "compare": compared, "sweep": swept, "tune": tuned, "calibrate": calibrated,
    "faults run": broken, "margins": measured,
}  # fmt: skip
"""What looks up the names that a command is given; of the others it is the rig's alone."""
LOOKS = {"check", "explain", "schema", "list", "status", "completion", "faults list"}
"""Commands that open nothing: they are run, unless they are asked about a bus or a run."""
ABOUT_RUNS = {"RUN", "runs", "latest"}


def wrong_of(words, monkeypatch):
    """Return what is wrong with a command of ours, or nothing."""
    try:
        name, given = parsed(words, monkeypatch)
        with monkeypatch.context() as patch:
            if not given.get("rig_name") and name != "faults run":
                patch.setattr("rig.experiment.plan.make_plan", unplanned)
            NAMES.get(name, of_rig)(given)
    except (click.ClickException, RigError, AssertionError) as error:
        return str(error)
    if name in LOOKS and not given.get("on") and not ABOUT_RUNS & {*words}:
        code = run_once(*words)
        return f"ended with {code}" if code else ""
    return ""


@cache
def run_once(*words):
    """Run a command that looks, and return its exit code: pages say the same ones again."""
    return invoke([*words])


def is_a_name(words):
    """Return whether words name a command and ask nothing of it."""
    command = group
    for word in words:
        if not isinstance(command, click.Group):
            return False
        command = command.get_command(click.Context(command), word)
    return command is not None


def taken_until_right(said):
    """Yield what is wrong with each way to fill in a command, up to one that is right."""
    for lack in said:
        yield lack
        if not lack:
            return


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_the_program_takes_each_command_of_a_page(page, monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    wrong = {}
    for command in commands_of(page):
        program, *words = command.words
        if program != "rig" or (command.is_inline and is_a_name(words)):
            continue
        said = (wrong_of(one, monkeypatch) for one in filled(words))
        *lacks, last = taken_until_right(said)
        if bool(last) != bool(REFUSED & {*words}):
            wrong[command.text] = [*lacks, last]
    assert wrong == {}
