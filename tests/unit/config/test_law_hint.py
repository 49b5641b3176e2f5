"""A law that a rig has not: who has it is said, and how another package's takes part."""

from dataclasses import replace

import pytest

from rig.assembly import REGISTRY
from rig.assembly.production import controller_class
from rig.config import ProfileError, find_configs, load_profile
from rig.config.law_hint import profiles_with_law
from rig.hal import ConfigurationError

OURS = "extends: bench\nadditions: [ours]\ncontrollers: {our-law: {}}\n"


def refused(configs, *overrides):
    with pytest.raises(ProfileError) as caught:
        configs.experiment("bench-sine", *overrides)
    return str(caught.value)


def test_the_rig_that_has_a_law_is_named(configs):
    configs.write("rigs/our-bench.yaml", OURS)
    assert profiles_with_law("our-law", [configs.path]) == ("our-bench",)
    said = refused(configs, "controller=our-law")
    assert "no controller is called 'our-law'" in said
    assert said.endswith("the rig our-bench has it: --rig our-bench")


def test_the_rig_that_names_a_law_in_vain_is_not_told_to_be_taken(configs):
    configs.write("rigs/our-bench.yaml", OURS)
    said = refused(configs, "controller=our-law", "rig=our-bench")
    assert "has it" not in said
    assert "there are: cascade, pid" in said


def test_what_packages_offer_is_told_where_no_profile_names_it(configs, monkeypatch):
    monkeypatch.setattr(configs.registry, "unnamed", lambda: ("theirs of the package them",))
    said = refused(configs, "controller=their-law")
    assert said.endswith(
        "there are: cascade, pid; a profile's additions: [NAME] lets a package take part: "
        "theirs of the package them"
    )


def test_a_profile_that_cannot_be_read_is_no_answer(configs):
    configs.write("rigs/broken.yaml", "controllers: [our-law]\n")
    configs.write("rigs/worse.yaml", "controllers: {our-law: {}\n")
    assert profiles_with_law("our-law", [configs.path]) == ()


def test_a_law_of_the_mechanism_gets_the_option_that_adds_it():
    rig = load_profile("cylinder", REGISTRY, (), find_configs())
    with pytest.raises(ConfigurationError) as caught:
        controller_class(replace(rig, controllers={"cascade": rig.controllers["cascade"]}), "pid")
    assert str(caught.value).endswith(
        "it has cascade; with its own gains: --set 'controllers.pid={}'"
    )
    with pytest.raises(ConfigurationError, match=r"cascade$"):
        controller_class(rig, "esc")
