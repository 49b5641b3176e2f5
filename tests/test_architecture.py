"""Who may import whom, as a failing check."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
CODE = ("rig", "drivers", "controllers")

MODULES = {
    ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path
    for folder in CODE
    for path in (ROOT / folder).rglob("*.py")
}


def imports(path: Path, package: str) -> set[tuple[str, int, bool]]:
    """Return (module, line, at module level) of every project import in a file."""
    tree = ast.parse(path.read_text())
    top_level = {id(node) for node in ast.walk(tree) if isinstance(node, ast.Module)}
    found = set()

    def visit(node: ast.AST, at_top: bool) -> None:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.Import):
                for alias in child.names:
                    found.add((alias.name, child.lineno, at_top))
            elif isinstance(child, ast.ImportFrom):
                assert child.level == 0, f"{path}:{child.lineno}: imports are absolute"
                found.add((child.module or "", child.lineno, at_top))
            inside = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef)
            visit(child, at_top and not inside)

    visit(tree, bool(top_level))
    return {entry for entry in found if entry[0].split(".")[0] in CODE}


def belongs(module: str, package: str) -> bool:
    return module == package or module.startswith(package + ".")


# (who, may import of the project only these)
FRAMEWORKS = ("rig.experiment", "rig.report", "rig.calibration")
ALLOWED = [
    ("rig.hal", ("rig.hal",)),
    ("controllers", ("controllers",)),
    ("drivers", ("drivers", "rig.hal")),
    ("rig.runtime", ("rig.runtime", "rig.hal")),
    ("rig.config", ("rig.config", "rig.hal")),
    *(
        (
            framework,
            (*FRAMEWORKS, "rig.assembly", "rig.run_folder", "rig.runtime", "rig.config", "rig.hal"),
        )
        for framework in FRAMEWORKS
    ),
    (
        "rig.mechanisms",
        (
            "rig.mechanisms",
            *FRAMEWORKS,
            "rig.assembly",
            "rig.run_folder",
            "rig.runtime",
            "rig.config",
            "rig.hal",
            "controllers",
        ),
    ),
]


@pytest.mark.parametrize(("who", "allowed"), ALLOWED, ids=[who for who, _ in ALLOWED])
def test_imports_only_what_its_layer_may(who, allowed):
    broken = [
        f"{path.relative_to(ROOT)}:{line} imports {target}"
        for module, path in MODULES.items()
        if belongs(module, who)
        for target, line, _ in imports(path, module)
        if not any(belongs(target, package) for package in allowed)
    ]
    assert not broken, "\n".join(broken)


def test_simulation_is_known_only_to_itself_and_two_modules():
    roof = ("rig.assembly.simulated", "rig.assembly.simulation_process")
    broken = [
        f"{path.relative_to(ROOT)}:{line} imports {target}"
        for module, path in MODULES.items()
        if not belongs(module, "drivers.sim") and module not in roof
        for target, line, _ in imports(path, module)
        if belongs(target, "drivers.sim")
    ]
    assert not broken, "\n".join(broken)


def test_assembly_imports_drivers_lazily():
    broken = [
        f"line {line} imports {target} at module level"
        for module, path in MODULES.items()
        if belongs(module, "rig.assembly")
        for target, line, at_top in imports(path, module)
        if at_top and belongs(target, "drivers")
    ]
    assert not broken, "\n".join(broken)


def test_plants_share_nothing_with_drivers_or_controllers():
    broken = [
        f"{path.relative_to(ROOT)}:{line} imports {target}"
        for module, path in MODULES.items()
        if belongs(module, "drivers.sim.plants")
        for target, line, _ in imports(path, module)
        if not belongs(target, "drivers.sim.plants")
    ]
    assert not broken, "\n".join(broken)


def test_emulated_nodes_use_no_codec_of_the_drivers():
    broken = [
        f"{path.relative_to(ROOT)}:{line} imports {target}"
        for module, path in MODULES.items()
        if belongs(module, "drivers.sim.nodes")
        for target, line, _ in imports(path, module)
        if not (
            belongs(target, "drivers.sim") or target.endswith("settings") or target == "rig.hal"
        )
    ]
    assert not broken, "\n".join(broken)


def test_nothing_stands_at_the_root_that_the_design_does_not_name():
    allowed = {
        "pyproject.toml",
        "README.md",
        "LICENSE",
        "rig",
        "drivers",
        "controllers",
        "configs",
        "tests",
        "runs",
        "build",
        "dist",
    }
    stray = [
        path.name
        for path in ROOT.iterdir()
        if not path.name.startswith(".") and path.name not in allowed and path.suffix != ".egg-info"
    ]
    assert not stray


def test_no_file_has_grown_past_its_subject():
    long = [
        f"{path.relative_to(ROOT)}: {count} lines"
        for path in MODULES.values()
        if (count := len(path.read_text().splitlines())) > 450
    ]
    assert not long, "\n".join(long)
