"""Who may import whom, as a failing check."""

import ast
import graphlib
import re
import statistics
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
CODE = ("rig", "drivers", "controllers")

MODULES = {
    ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path
    for folder in CODE
    for path in (ROOT / folder).rglob("*.py")
}


@cache
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
FRAMEWORKS = ("rig.experiment", "rig.report", "rig.calibration", "rig.commissioning")
RUN_FOLDER = ("rig.run_folder", "rig.run_facts", "rig.typed_json", "rig.whole_file")
# The one module that plants and laws share: how kernels are kept in files.
KEEPING = "controllers.kernel_files"
ALLOWED = [
    ("rig.hal", ("rig.hal",)),
    ("controllers", ("controllers",)),
    ("drivers", ("drivers", "rig.hal", KEEPING)),
    ("rig.runtime", ("rig.runtime", "rig.hal")),
    ("rig.config", ("rig.config", "rig.hal")),
    ("rig.steering", ("rig.steering", "rig.tuning.gains", "rig.hal", "controllers.base")),
    (
        "rig.watching",
        (
            "rig.watching",
            "rig.steering.mailbox",
            "rig.tuning.gains",
            "rig.stopping",
            *RUN_FOLDER,
            "rig.runtime.log_tail",
            "rig.assembly",
            "rig.config",
            "rig.hal",
            "controllers.base",
        ),
    ),
    *(
        (
            framework,
            (
                *FRAMEWORKS,
                "rig.assembly",
                *RUN_FOLDER,
                "rig.runtime",
                "rig.config",
                "rig.hal",
                "rig.installation",
                # A page of a run that stopped says why, in the words of `rig explain`.
                *(["rig.explaining.ended_run"] if framework == "rig.report" else []),
            ),
        )
        for framework in FRAMEWORKS
    ),
    (
        "rig.mechanisms",
        (
            "rig.mechanisms",
            *FRAMEWORKS,
            "rig.assembly",
            *RUN_FOLDER,
            "rig.runtime",
            "rig.config",
            "rig.hal",
            "rig.installation",
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


def test_a_run_knows_nothing_of_who_watches_it():
    """The page is another process, which reads the run's folder; it is started, not imported."""
    broken = [
        f"{path.relative_to(ROOT)}:{line} imports {target}"
        for module, path in MODULES.items()
        if not belongs(module, "rig.watching") and module != "rig.cli.watch"
        for target, line, _ in imports(path, module)
        if belongs(target, "rig.watching")
    ]
    assert not broken, "\n".join(broken)


def test_what_judges_safety_knows_the_truth_and_the_limits_only():
    """The oracle may not learn from the program what is safe."""
    allowed = {
        "rig.faults.oracle": ("rig.hal",),
        "drivers.sim.hazards": ("rig.hal", "drivers.sim.plants"),
    }
    broken = [
        f"{MODULES[module].relative_to(ROOT)}:{line} imports {target}"
        for module, packages in allowed.items()
        for target, line, _ in imports(MODULES[module], module)
        if not any(belongs(target, package) for package in packages)
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
        if not belongs(target, "drivers.sim.plants") and target != KEEPING
    ]
    assert not broken, "\n".join(broken)


def test_what_keeps_kernels_knows_nothing_of_the_project():
    assert imports(MODULES[KEEPING], KEEPING) == set()


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
        "faults",
        "build",
        "dist",
    }
    stray = [
        path.name
        for path in ROOT.iterdir()
        if not path.name.startswith(".") and path.name not in allowed and path.suffix != ".egg-info"
    ]
    assert not stray


# The contract ---------------------------------------------------------------------------


def calls(tree: ast.AST, *names: str):
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in names:
            yield node


@cache
def contract_names() -> set[str]:
    """Return every public member of what rig.hal has others inherit."""
    found = set()
    for path in (ROOT / "rig" / "hal").glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ClassDef) and (
                node.name == "DriverSettings"
                or any("Protocol" in ast.unparse(base) for base in node.bases)
            ):
                for item in node.body:
                    if isinstance(item, ast.FunctionDef):
                        found.add(item.name)
                    elif isinstance(item, ast.AnnAssign) and isinstance(item.target, ast.Name):
                        found.add(item.target.id)
    return {name for name in found if not name.startswith("_")}


def test_no_hook_of_the_contract_is_looked_for():
    """What a device, motion, mechanism or law may lack has a default; nobody asks for it."""
    hooks = contract_names()
    broken = [
        f"{path.relative_to(ROOT)}:{call.lineno} {ast.unparse(call)}"
        for path in MODULES.values()
        for call in calls(ast.parse(path.read_text()), "hasattr", "getattr")
        if isinstance(call.args[1], ast.Constant) and call.args[1].value in hooks
    ]
    assert not broken, "\n".join(broken)


def test_no_hook_of_the_contract_is_set_from_outside():
    hooks = contract_names() | {"controller", "motion"}
    users = ("rig.runtime", "rig.assembly", "rig.cli", *FRAMEWORKS)
    broken = []
    for path in (
        path for module, path in MODULES.items() if any(belongs(module, u) for u in users)
    ):
        for node in ast.walk(ast.parse(path.read_text())):
            targets = node.targets if isinstance(node, ast.Assign) else ()
            for target in targets:
                outside = (
                    isinstance(target, ast.Attribute)
                    and target.attr in hooks
                    and not (isinstance(target.value, ast.Name) and target.value.id == "self")
                )
                if outside:
                    broken.append(f"{path.relative_to(ROOT)}:{node.lineno} {ast.unparse(target)}")
    assert not broken, "\n".join(broken)


MOST_ANY = 198


def test_any_is_said_rarely():
    """A ratchet: the bound goes down with the count, never up."""
    said = sum(
        bool(re.search(r"\bAny\b", line)) and "import" not in line
        for path in MODULES.values()
        for line in path.read_text().splitlines()
    )
    assert said <= MOST_ANY, f"{said} lines say Any"


def test_no_module_imports_itself_through_others():
    imported = {
        module: {
            target
            for node in ast.walk(ast.parse(path.read_text()))
            if isinstance(node, ast.ImportFrom)
            for target in {node.module, *(f"{node.module}.{name.name}" for name in node.names)}
            if target in MODULES
            and target != module
            # A package's own name is imported for what stands in it, not for its modules.
            and not (f"{node.module}.{node.names[0].name}" in MODULES and target == node.module)
        }
        for module, path in MODULES.items()
    }
    try:
        tuple(graphlib.TopologicalSorter(imported).static_order())
    except graphlib.CycleError as error:
        pytest.fail(" -> ".join(error.args[1]))


def test_frameworks_name_no_mechanism():
    """Neither by import (above) nor by name; a mechanism's row says what it has."""
    from rig.assembly.offered import MECHANISMS

    broken = [
        f"{path.relative_to(ROOT)}:{node.lineno} says {node.value!r}"
        for module, path in MODULES.items()
        if any(belongs(module, p) for p in (*FRAMEWORKS, "rig.runtime", "rig.hal", "rig.config"))
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Constant) and node.value in MECHANISMS
    ]
    assert not broken, "\n".join(broken)


def test_every_mechanism_has_the_same_files():
    from rig.assembly.offered import MECHANISMS

    names = (
        "parts", "settings", "mechanism", "references", "measures", "figures", "comparison",
        "calibration",
    )  # fmt: skip
    missing = [
        f"{mechanism}/{name}"
        for mechanism in MECHANISMS
        for name in names
        if f"rig.mechanisms.{mechanism}.{name}" not in MODULES
    ]
    assert not missing


# Words ----------------------------------------------------------------------------------

TWINS = {
    # Emulated nodes are of their own making, so that a mistake in a driver shows against them.
    "Emergency": ("drivers.canopen", "drivers.sim.nodes"),
    "HeartbeatProducer": ("drivers.canopen", "drivers.sim.nodes"),
    "NmtState": ("drivers.canopen", "drivers.sim.nodes"),
    # What is true of a plant is not what its controllers believe.
    "SealFriction": ("drivers.sim.plants", "rig.mechanisms.pneumatic"),
    # Controllers import nothing of rig: their base fulfils its protocol from outside.
    "Law": ("controllers.base", "rig.hal"),
}
"""Class names for two things, and where each may stand: a ratchet, which never grows."""


def test_a_class_name_means_one_thing():
    homes: dict[str, list[str]] = {}
    for module, path in MODULES.items():
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                homes.setdefault(node.name, []).append(module)
    twins = {name: sorted(found) for name, found in homes.items() if len(found) > 1}
    assert twins.keys() == TWINS.keys()
    for name, found in twins.items():
        assert len(found) == 2
        assert all(belongs(m, home) for m, home in zip(found, TWINS[name], strict=True)), name


# Sizes ----------------------------------------------------------------------------------


def code_lines(function: ast.AST) -> int:
    """Count the lines of a function that hold code, its docstring left out."""
    body = function.body[1:] if ast.get_docstring(function) else function.body
    return sum(node.end_lineno - node.lineno + 1 for node in body)


def test_what_runs_in_the_cycle_is_read_at_a_glance():
    long = [
        f"{path.relative_to(ROOT)}:{node.lineno} {node.name}: {code_lines(node)} lines"
        for module, path in MODULES.items()
        if belongs(module, "rig.runtime")
        or (belongs(module, "rig.mechanisms") and ".calibration" not in module)
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.FunctionDef) and code_lines(node) > 50
    ]
    assert not long, "\n".join(long)


def test_the_median_file_is_short():
    lengths = [len(path.read_text().splitlines()) for path in MODULES.values()]
    assert statistics.median(length for length in lengths if length >= 5) <= 130


def test_no_file_has_grown_past_its_subject():
    long = [
        f"{path.relative_to(ROOT)}: {count} lines"
        for path in MODULES.values()
        if (count := len(path.read_text().splitlines())) > 400
    ]
    assert not long, "\n".join(long)


def test_pytest_is_imported_by_the_suites_alone():
    """It is no dependency of who runs a rig; the suites are for who writes for one."""
    broken = [
        str(path.relative_to(ROOT))
        for module, path in MODULES.items()
        if not belongs(module, "rig.testing")
        for node in ast.walk(ast.parse(path.read_text()))
        if (isinstance(node, ast.Import) and any(a.name == "pytest" for a in node.names))
        or (isinstance(node, ast.ImportFrom) and node.module in ("pytest", "rig.testing"))
    ]
    assert not broken, "\n".join(broken)


def test_what_controls_reads_no_clock_that_somebody_may_set():
    """Stamps of logs and files say when it was by the wall's clock; nothing else may ask."""
    stamps = ("rig.runtime.recorder", "drivers.can.frame_log")
    asked = re.compile(r"\btime\.time(_ns)?\(|from time import .*\btime\b|datetime\.(utc)?now\(")
    controlling = ("rig.runtime", "rig.hal", "rig.mechanisms", "controllers", "drivers")
    broken = [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()}"
        for module, path in MODULES.items()
        if any(belongs(module, package) for package in controlling) and module not in stamps
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        if asked.search(line)
    ]
    assert not broken, "\n".join(broken)


KINDS = {".css", ".eds", ".html", ".ipynb", ".js", ".md", ".py", ".svg", ".typed", ".yaml"}


def test_packages_hold_text_that_somebody_wrote():
    """A wheel once lay among the sources, where a download had left it."""
    strange = [
        str(path.relative_to(ROOT))
        for folder in (*CODE, "configs")
        for path in (ROOT / folder).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts and path.suffix not in KINDS
    ]
    assert not strange, "\n".join(strange)
