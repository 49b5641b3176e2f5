"""`rig new`: names and rigs that plain YAML would read as something else, and rigs from files."""

import itertools
import random

import pytest
import yaml

from rig.assembly import REGISTRY
from rig.cli import invoke
from rig.config import load_experiment, load_profile
from rig.config.names import find_configs
from rig.config.plain_dump import plain_text
from rig.config.yaml_loader import read_plain
from rig.scaffolding.packages import package_files

TOLD = ["null", "true", "false", "yes", "no", "off"]
NO_TEXT = ["on", "~", "1e3", "0x10", "12:30", "2026-11-29", "007", "1_000", ".inf", ".5", "-3"]
MARKED = ["a: b", "- a", "#a", "a #b", "{a}", "[a", "*a", "&a", "!a", "%a", "@a", "", "'a", '"a"']
NAMES = ["crank", "my-rig.yaml", "./rigs/my rig.yaml", "Prüfstand.yaml", "x" * 300]


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("text", [*TOLD, *NO_TEXT, *MARKED, *NAMES], ids=lambda text: text[:12])
def test_a_text_is_read_as_it_was_by_every_reader(here, text):
    line = f"key: {plain_text(text)}\n"
    (here / "file.yaml").write_text(line, encoding="utf-8")
    assert read_plain(here / "file.yaml") == yaml.safe_load(line) == {"key": text}
    assert line.count("\n") == 1
    assert text not in ("crank", "my-rig.yaml") or line == f"key: {text}\n"


@pytest.mark.parametrize("name", TOLD)
def test_a_rig_and_an_experiment_may_be_called_so(here, capsys, name):
    assert invoke(["new", "rig", name]) == 0
    assert invoke(["check", f"{name}.yaml"]) == 0
    assert load_profile(f"{name}.yaml", REGISTRY, (), find_configs()).name == name
    (here / f"{name}.yaml").unlink()
    assert invoke(["new", "experiment", name]) == 0
    assert invoke(["check", f"{name}.yaml"]) == 0
    assert load_experiment(f"{name}.yaml", REGISTRY, (), find_configs()).name == name


def test_a_rig_of_such_a_name_is_extended_and_moved(here):
    rigs = here / "configs" / "rigs"
    rigs.mkdir(parents=True)
    (rigs / "null.yaml").write_text("extends: cylinder\n")
    assert invoke(["new", "rig", "mine", "--like", "null"]) == 0
    assert invoke(["check", "mine.yaml"]) == 0
    assert invoke(["new", "experiment", "first", "--rig", "null"]) == 0
    assert invoke(["check", "first.yaml"]) == 0
    assert load_experiment("first.yaml", REGISTRY, (), find_configs()).rig == "null"


@pytest.mark.parametrize("kind", ["controller", "driver", "mechanism"])
def test_the_files_of_a_package_call_it_by_its_name(here, kind):
    name = random.Random(kind).choice(["null", "yes", "no", "on", "off"])
    texts = [text for path, text in package_files(kind, name).items() if path.suffix == ".yaml"]
    said = [yaml.safe_load(text) for text in texts]
    [profile] = [one for one in said if "reference" not in one]
    [first] = [one for one in said if "reference" in one]
    if kind == "controller":
        assert list(profile["controllers"]) == [name] and first["controller"] == name
    elif kind == "driver":
        assert profile["devices"][name]["driver"] == name
    else:
        assert profile["mechanism"] == profile["plant"]["model"] == name and name in profile


CHAIN = ["cylinder", "one", "two"]


@pytest.mark.parametrize("name", ["my-rig.yaml", "rigs of mine/a: b.yaml"])
@pytest.mark.parametrize("length", [1, 2, 3])
def test_a_rig_in_a_file_has_the_experiments_of_what_it_extends(here, capsys, name, length):
    (here / name).parent.mkdir(exist_ok=True)
    for base, own in itertools.pairwise(CHAIN):
        (here / name).with_name(f"{own}.yaml").write_text(f"extends: {base}\n")
    (here / name).write_text(f"extends: {CHAIN[length - 1]}\n")
    assert invoke(["new", "experiment", "first", "--rig", name]) == 0
    assert invoke(["check", "first.yaml"]) == 0
    experiment = load_experiment("first.yaml", REGISTRY, (), find_configs())
    assert experiment.rig == name
    assert experiment.reference.kind in REGISTRY.names("reference")


def test_an_experiment_that_extends_another_is_of_the_rig_too(here):
    like = "cylinder-sine-10mm"  # which does not say whose it is
    assert invoke(["new", "experiment", "a", "--rig", "cylinder-ideal", "--like", like]) == 0
    assert load_experiment("a.yaml", REGISTRY, (), find_configs()).rig == "cylinder-ideal"


@pytest.mark.parametrize(
    ("rig", "said"),
    [
        ("my-rg.yaml", "did you mean the file my-rig.yaml?"),
        ("my-rig", "did you mean the file my-rig.yaml?"),
        ("my-rig.yaml", "no experiment is of the rig 'my-rig.yaml', nor of what it extends"),
    ],
)
def test_a_file_that_is_none_or_has_none_is_told(here, capsys, rig, said):
    (here / "my-rig.yaml").write_text("extends: base.yaml\n")
    (here / "base.yaml").write_text("mechanism: cylinder\n")
    assert invoke(["new", "experiment", "first", "--rig", rig]) == 2
    assert said in capsys.readouterr().err
    assert not (here / "first.yaml").exists()
