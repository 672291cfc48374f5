# SPDX-License-Identifier: BSD-3-Clause
"""All words that the controller may give as a reason, collected from its code and its errors."""

from __future__ import annotations

import ast
import inspect
from pathlib import Path

import rst_control
from rst_control.commands.verifier import REASONS
from rst_control.errors import Collision, Infeasible, NoGrasp
from rst_control.planning import free_space, insertion  # noqa: F401  # their errors are subclasses below

SOURCE = Path(rst_control.__path__[0])
if not (SOURCE / "errors.py").exists():  # the devel space joins source and generated messages
    SOURCE = Path(inspect.getsourcefile(insertion)).parents[1]
EXAMPLES = {"float": 0.5, "int": 3, "str": "joint_4", "tuple[str, ...]": ("a", "b")}


def trees():
    for path in sorted(SOURCE.rglob("*.py")):
        yield path, ast.parse(path.read_text(encoding="utf-8"))


def text_of(node, names):
    """What a text looks like, what it quotes as 0.5; None where none is seen."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        parts = [
            p.value if isinstance(p, ast.Constant) else names.get(getattr(p.value, "id", ""), "0.5")
            for p in node.values
        ]
        return "".join(parts)
    if isinstance(node, ast.IfExp):
        return text_of(node.body, names)
    if isinstance(node, ast.Name):
        return names.get(node.id)
    return None


def functions(tree):
    return [n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef)]


def texts_in(function, line):
    """Names that a function has given to texts before a line of it."""
    names = {}
    for node in ast.walk(function):
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            text = text_of(node.value, names) if node.lineno < line else None
            if text is not None:
                names[node.targets[0].id] = text
    return names


def calls(name, only=""):
    """Arguments and texts of every call of a function or method of that name."""
    for path, tree in trees():
        for function in functions(tree) if path.name == (only or path.name) else ():
            for node in ast.walk(function):
                if isinstance(node, ast.Call):
                    called = getattr(node.func, "attr", getattr(node.func, "id", ""))
                    if called == name:
                        yield node.args, texts_in(function, node.lineno)


def rejected():
    """Name of a Reason and words, of every `Rejected(Reason.X, "...")` with a text that is seen."""
    for args, names in calls("Rejected"):
        if len(args) == 2 and isinstance(args[0], ast.Attribute):
            words = text_of(args[1], names)
            if words is not None:
                yield args[0].attr, words


def desk_refusals():
    """Words of every refusal at the desk or at the door."""
    for args, names in calls("_refuse", only="command_queue.py"):
        words = text_of(args[1], names) if len(args) == 2 else None
        if words is not None:
            yield words
    door = ast.parse((SOURCE / "admission" / "callers.py").read_text(encoding="utf-8"))
    for function in functions(door):
        if function.name == "_objection":
            names = texts_in(function, 10**6)
            found = (n.value for n in ast.walk(function) if isinstance(n, ast.Return))
            yield from filter(None, (text_of(value, names) for value in found))


def stops():
    """Reasons with which anything asks the executor to stop."""
    for args, names in calls("stop"):
        words = text_of(args[0], names) if args else None
        if words is not None:
            yield words


def infeasible():
    """Value of the Reason and words, of every way in which planning may fail."""
    for error in map(example, sorted(subclasses(Infeasible), key=lambda kind: kind.__name__)):
        cause = error.reasons[0] if isinstance(error, NoGrasp) else error
        reason = REASONS.get(type(cause))
        yield type(error), reason.value if reason else "unreachable", f'cannot "tense": {error}'


def subclasses(kind):
    for sub in kind.__subclasses__():
        yield sub
        yield from subclasses(sub)


def example(kind):
    """An error of a kind, of made-up numbers."""
    collision = Collision("shaft", "table", 0.001, 0.015)
    if kind is NoGrasp:
        return NoGrasp((collision,), 5)
    given = []
    for parameter in list(inspect.signature(kind.__init__).parameters.values())[1:]:
        given.append(EXAMPLES.get(str(parameter.annotation), collision))
    return kind(*given)
