"""Mutants: every small change of a source file that its tests have to notice."""

import ast
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

_COMPARED = {
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
}
_COMPUTED = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult,
}
_CALLED = {"min": "max", "max": "min", "any": "all", "all": "any"}
_UNTOUCHED = ("annotation", "returns", "decorator_list", "format_spec", "type_params")
"""Fields that say nothing of what a program does, or only how it is printed."""

Function = ast.FunctionDef | ast.AsyncFunctionDef


class Mutant(NamedTuple):
    """One change of a file.

    Parameters
    ----------
    path : str
        The file, below the root.
    line, last : int
        From where the changed statement begins to where the change ends.
    change : str
        The code before and after it.
    source : str
        Of the file, unchanged.
    number : int
        Of the change among all of the file.
    inside : bool
        It is in the body of a function; otherwise it acts as soon as the file is imported.
    """

    path: str
    line: int
    last: int
    change: str
    source: str
    number: int
    inside: bool

    @property
    def text(self) -> str:
        """The line where the change begins, as the list of equivalents has it."""
        return self.source.split("\n")[self.line - 1].strip()

    def tree(self) -> ast.Module:
        """Return the changed file."""
        tree = ast.parse(self.source)
        for number, (node, field, index, after, *_) in enumerate(_places(tree)):
            if number == self.number:
                if index is None:
                    setattr(node, field, after)
                else:
                    getattr(node, field)[index] = after
                break
        return ast.fix_missing_locations(tree)


def mutants_of(root: Path, path: str) -> list[Mutant]:
    """Return every mutant of a file."""
    source = (root / path).read_text(encoding="utf-8")
    mutants = []
    places = enumerate(_places(ast.parse(source)))
    for number, (node, field, index, after, statement, inside) in places:
        before = getattr(node, field) if index is None else getattr(node, field)[index]
        whole = node if isinstance(before, ast.cmpop) else before
        change = f"{_text(whole)} -> {_text(after, whole, index)}"
        line = statement or whole.lineno
        mutants.append(Mutant(path, line, whole.end_lineno, change, source, number, inside))
    return mutants


def _text(node: ast.AST, whole: ast.AST | None = None, index: int | None = None) -> str:
    if isinstance(node, ast.cmpop) and isinstance(whole, ast.Compare):
        ops = [node if k == index else op for k, op in enumerate(whole.ops)]
        node = ast.Compare(whole.left, ops, whole.comparators)
    return ast.unparse(node).split("\n")[0]


Place = tuple[ast.AST, str, int | None, ast.AST, int, bool]


def _places(node: ast.AST, statement: int = 0, *, inside: bool = False) -> Iterator[Place]:
    """Yield each change below a node.

    Whose field, which of a list, what takes its place, the line of the statement, and whether it is
    in a function.
    """
    for field, value in ast.iter_fields(node):
        if field in _UNTOUCHED:
            continue
        of_body = inside or (isinstance(node, Function | ast.Lambda) and field == "body")
        children = enumerate(value) if isinstance(value, list) else [(None, value)]
        for index, child in children:
            if not isinstance(child, ast.AST) or _is_left_out(node, child):
                continue
            line = child.lineno if isinstance(child, ast.stmt) else statement
            for after in _changes(node, field, child):
                yield node, field, index, _put(after, child, node), line, of_body
            yield from _places(child, line, inside=of_body)


def _put(after: ast.AST, before: ast.AST, parent: ast.AST) -> ast.AST:
    return ast.copy_location(after, parent if isinstance(before, ast.cmpop) else before)


def _is_left_out(parent: ast.AST, node: ast.AST) -> bool:
    """Return whether a node is a text for people, or for the type checker only."""
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
        return True
    if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
        return True
    if isinstance(node, ast.keyword) and node.arg == "strict":  # of a zip(): a note of the author's
        return True
    is_type = isinstance(parent, ast.Call) and ast.unparse(parent.func) in ("cast", "TypeVar")
    return is_type or (isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__")


def _more(number: float) -> float:
    return number + max(1.0, abs(number)) if isinstance(number, float) else number + 1


def _changes(parent: ast.AST, field: str, node: ast.AST) -> Iterator[ast.AST]:
    """Yield what may take the place of a node."""
    match node:
        case ast.cmpop():
            yield from (other() for other in _COMPARED[type(node)])
        case ast.BoolOp():
            yield ast.BoolOp(ast.Or() if isinstance(node.op, ast.And) else ast.And(), node.values)
        case ast.BinOp() if type(node.op) in _COMPUTED:
            yield ast.BinOp(node.left, _COMPUTED[type(node.op)](), node.right)
        case ast.AugAssign():
            yield ast.Pass()
            if type(node.op) in _COMPUTED:
                yield ast.AugAssign(node.target, _COMPUTED[type(node.op)](), node.value)
        case ast.UnaryOp(op=ast.Not() | ast.USub()):
            yield node.operand
        case ast.Constant(value=bool()):
            yield ast.Constant(not node.value)
        case ast.Constant(value=int() | float()):
            yield ast.Constant(_more(node.value))
        case ast.Call(func=ast.Name(id="abs")):
            yield node.args[0]
        case ast.Call(func=ast.Name(id=name)) if name in _CALLED:
            yield ast.Call(ast.Name(_CALLED[name], ast.Load()), node.args, node.keywords)
        case ast.Expr() | ast.Raise():
            yield ast.Pass()
        case ast.Assign(targets=[ast.Attribute() | ast.Subscript(), *_]):
            yield ast.Pass()
        case ast.AnnAssign(target=ast.Attribute(), value=ast.expr()):
            yield ast.Pass()
        case ast.Return(value=ast.expr()) if ast.unparse(node.value) != "None":
            yield ast.Return(ast.Constant(None))
    if field == "test" and isinstance(parent, ast.If | ast.IfExp):
        yield ast.Constant(True)
    if field in ("test", "ifs") and not isinstance(parent, ast.Assert):
        yield ast.Constant(field == "ifs")
