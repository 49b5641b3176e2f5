"""Words of the product: a class docstring says what the class is, and asks nothing."""

import ast
from pathlib import Path

ROOT = Path(__file__).parents[1]
QUESTIONS = ("What", "How", "Where", "When", "Who", "Whether", "Which", "Why")


def test_no_class_is_described_by_a_question():
    asking = [
        f"{path.relative_to(ROOT)}:{node.lineno}: {node.name}"
        for package in ("rig", "drivers", "controllers")
        for path in (ROOT / package).rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ClassDef)
        and (ast.get_docstring(node) or "-").split()[0] in QUESTIONS
    ]
    assert not asking, "\n".join(asking)
