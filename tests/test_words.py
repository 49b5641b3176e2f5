"""Words of the product: a class docstring says what the class is, and asks nothing."""

import ast
from pathlib import Path

ROOT = Path(__file__).parents[1]
HELD = (
    "rig/config", "rig/cli", "rig/report", "rig/run_folder", "rig/export", "rig/provenance",
    "rig/runtime/log", "rig/runtime/mcap_file", "rig/runtime/realtime", "rig/runtime/recorder",
    "rig/runtime/states", "rig/runtime/stop.py",
)  # fmt: skip
"""Starts of the paths that are held to it so far."""
QUESTIONS = ("What", "How", "Where", "When", "Who", "Whether", "Which", "Why")


def test_no_class_is_described_by_a_question():
    classes = [
        (path.relative_to(ROOT).as_posix(), node)
        for package in ("rig", "drivers", "controllers")
        for path in (ROOT / package).rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ClassDef) and ast.get_docstring(node)
    ]
    held = [(path, node) for path, node in classes if path.startswith(HELD)]
    asking = [
        f"{path}:{node.lineno}: {node.name}"
        for path, node in held
        if ast.get_docstring(node).split()[0] in QUESTIONS
    ]
    assert held
    assert not asking, "\n".join(asking)
