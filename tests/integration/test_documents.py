"""What is written for people: links lead somewhere, and what is made from code is what it says."""

import contextlib
import doctest
import os
import pty
import re
import shlex
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest
from shown_commands import PAGES, ROOT


def anchors(page):
    """Return the anchors of a page's headings, as GitHub makes them."""
    for title in re.findall(r"^#+ (.+)$", page.read_text(), re.M):
        kept = re.sub(r"[^\w\- ]", "", title.strip().lower())
        yield kept.replace(" ", "-")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_link_leads_somewhere(page):
    text = re.sub(r"```.*?```|`[^`\n]*`", "", page.read_text(), flags=re.S)
    broken = []
    for link in re.findall(r"\]\(([^)\s]+)\)", text):
        if re.match(r"[a-z]+:", link):
            continue
        where, _, anchor = link.partition("#")
        target = page.parent / where if where else page
        there = target.exists() and (not anchor or anchor in anchors(target))
        broken += [] if there else [link]
    assert broken == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_a_command_for_marked_tests_asks_for_the_marker_that_sets_them_apart(page):
    """Without it `conftest.py` leaves them out, whatever else they are marked with."""
    for quoted, plain in re.findall(r"pytest [^`\n]*?-m (?:'([^']+)'|(\w+))", page.read_text()):
        assert re.search(r"\b(slow|benchmark|vcan)\b", quoted or plain), quoted or plain


def test_the_reference_is_what_the_code_says():
    made = subprocess.run([sys.executable, ROOT / ".readme/reference.py", "--check"], check=False)
    assert made.returncode == 0, "python .readme/reference.py writes it again"


NUMBER = re.compile(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?")
BLOCK = re.compile(r"(?:Write `([\w.-]+)`:\n\n)?```(console|yaml|csv|python)\n(.*?)```", re.S)
SESSIONS = [ROOT / f".readme/{name}.md" for name in ("tutorial", "your-own-rig", "your-own-arm")]


def shape(text):
    """Return a text without what differs from run to run: digits, and how columns are set.

    So does whether a kernel has been compiled on this machine before.
    """
    text = re.sub(r"^compiling kernels.*\n", "", text, flags=re.M)
    return "\n".join(" ".join(NUMBER.sub("0", line).split()) for line in text.splitlines()) + "\n"


def run_session(page, folder):
    """Do what a page says in a folder, and return the commands that print something else."""
    shell = {**os.environ, "COLUMNS": "100", "PYTHONPATH": str(ROOT), "MPLBACKEND": "Agg"}
    shell["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{shell['PATH']}"
    wrong = []
    for name, kind, content in BLOCK.findall(page.read_text()):
        if kind in ("yaml", "csv"):
            (folder / (name or "unnamed.yaml")).write_text(content)
            continue
        if kind == "python":
            asked = [([sys.executable, "-c", content], None)]
        else:
            parts = re.split(r"^\$ ", content, flags=re.M)[1:]
            asked = [
                (shlex.split(command), said)
                for command, _, said in (part.partition("\n") for part in parts)
            ]
        for command, said in asked:
            done = subprocess.run(
                command,
                cwd=folder,
                env=shell,
                check=False,
                text=True,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                timeout=300,
            )
            if said is None:
                wrong += [done.stdout] if done.returncode else []
            elif not doctest.OutputChecker().check_output(
                shape(said), shape(done.stdout), doctest.ELLIPSIS
            ):
                wrong.append(f"{shlex.join(command)} printed\n{done.stdout}")
    return wrong


@pytest.mark.slow
@pytest.mark.parametrize("page", SESSIONS, ids=lambda page: page.stem)
def test_commands_print_what_the_page_shows(page, tmp_path):
    (tmp_path / "tests").symlink_to(ROOT / "tests")  # where pages take examples from
    wrong = run_session(page, tmp_path)
    assert not wrong, "\n\n".join(wrong)


ASKED = re.compile(r"```terminal\n(.*?)```", re.S)


def at_a_terminal(command, folder, typed):
    """Return what a command prints to a person who answers its question."""
    terminal, theirs = pty.openpty()
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    own = {**os.environ, "PATH": path, "PYTHONPATH": str(ROOT)}
    with subprocess.Popen(
        command, cwd=folder, env=own, stdin=theirs, stdout=theirs, stderr=theirs
    ) as process:
        os.close(theirs)
        said, is_asked = b"", False
        with contextlib.suppress(OSError):  # a terminal ends so
            while piece := os.read(terminal, 65536):
                said += piece
                if not is_asked and b"to go on: " in said:
                    is_asked = True
                    os.write(terminal, f"{typed}\n".encode())
    os.close(terminal)
    return process.returncode, said.decode().replace("\r\n", "\n")


def test_the_page_shows_the_question_and_the_program_asks_it(tmp_path):
    """What it asks of whoever moves a rig is answered wrongly here: there may be a rig."""
    page = (ROOT / ".readme" / "your-own-rig.md").read_text()
    for name, kind, content in BLOCK.findall(page):
        if kind == "yaml" and name:
            (tmp_path / name).write_text(content)
    (shown,) = ASKED.findall(page)
    command, _, expected = textwrap.dedent(shown).removeprefix("$ ").partition("\n")
    question = expected.rpartition("my-rig")[0]
    code, said = at_a_terminal(shlex.split(command), tmp_path, "nobody")
    assert code == 2 and said.endswith("that is not its name: nothing was done\n"), said
    assert doctest.OutputChecker().check_output(
        shape(question), shape(said.rpartition("nobody\n")[0]), doctest.ELLIPSIS
    ), said
    assert not (tmp_path / "runs").exists()


def test_no_page_for_people_at_a_rig_answers_the_question_beforehand():
    pages = [path for path in PAGES if path.name not in ("safety.md", "reference.md")]
    told = [
        f"{path.name}: {line}"
        for path in pages
        for line in path.read_text().splitlines()
        if "--yes" in line and ("rig run" in line or "rig calibrate" in line)
    ]
    assert told == []


def test_the_page_of_laws_has_every_motion_of_arm_and_legs():
    page = (ROOT / ".readme" / "laws.md").read_text()
    names = [path.stem for path in (ROOT / "configs/experiments").glob("*.yaml")]
    asked = sorted(name for name in names if name.startswith(("arm-", "legs-")))
    assert re.findall(r"^## (\S+)$", page, re.M) == asked


@pytest.mark.slow
def test_the_tables_of_laws_are_what_a_comparison_measures():
    """All take a quarter of an hour: ``python .readme/laws.py --check``."""
    made = subprocess.run(
        [sys.executable, ROOT / ".readme" / "laws.py", "--check", "arm-wrist-hit"],
        check=False, capture_output=True, text=True,
    )  # fmt: skip
    assert made.returncode == 0, made.stdout + made.stderr
