"""Arithmetic over results of a run, as the verification table of a scene writes it.

    over (2 * history.strain_energy / 0.3) ** 0.5, max(history.max_penetration), probes.pole.z - probes.rim.z

A path is the column of a table of results (or a frequency, numbered from 0); an expression is worth what it is in the
last row. `max` and `min` go over all rows.
"""

import ast
import operator
import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

PATH = re.compile(
    r"\b(?:surface\.volume|frequencies\.\d+|history\.\w+|spin\.(?:angular_momentum\.)?\w+|"
    r"(?:probes|reactions)\.\w[\w-]*\.\w+)(?![\w.])"
)
LONGEST = 500
"""Characters; each may be a bracket, and Python's own limits are not far beyond."""

OPERATORS = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.UAdd: operator.pos,
    ast.USub: operator.neg,
}
FUNCTIONS = {"max": np.max, "min": np.min}


@dataclass(frozen=True)
class Expression:
    """A parsed expression.

    Attributes:
        paths: results that it names, in their order.
    """

    paths: tuple[str, ...]
    tree: ast.expr

    def value(self, column: Callable[[str], np.ndarray]) -> float:
        """Its value in the last row; `column` gives the (n,) rows of a path. Not finite where it divides by zero."""
        columns = {f"result_{k}": np.asarray(column(path), dtype=float) for k, path in enumerate(self.paths)}
        with np.errstate(all="ignore"):
            return float(np.atleast_1d(_evaluate(self.tree, columns))[-1])


def parse(text: str) -> Expression:
    """The expression of a text.

    Raises:
        ValueError: it is none, or longer than LONGEST.
    """
    paths: list[str] = []
    if len(text) > LONGEST or "result_" in text:  # names of our own, below
        raise ValueError(text)

    def replaced(match: re.Match) -> str:
        paths.append(match.group())
        return f"result_{len(paths) - 1}"

    try:
        tree = ast.parse(PATH.sub(replaced, text).strip(), mode="eval").body
        _check(tree, {f"result_{k}" for k in range(len(paths))})
    except (SyntaxError, RecursionError, MemoryError, OverflowError):
        raise ValueError(text) from None
    if not paths:
        raise ValueError(text)
    return Expression(tuple(paths), tree)


def _check(tree: ast.expr, names: set[str]) -> None:
    match tree:
        case ast.Constant(value=int() | float()) if not isinstance(tree.value, bool) and np.isfinite(float(tree.value)):
            return
        case ast.Name(id=name) if name in names:
            return
        case ast.BinOp(op=op, left=left, right=right) if type(op) in OPERATORS:
            _check(left, names)
            _check(right, names)
        case ast.UnaryOp(op=op, operand=operand) if type(op) in OPERATORS:
            _check(operand, names)
        case ast.Call(func=ast.Name(id=name), args=[argument], keywords=[]) if name in FUNCTIONS:
            _check(argument, names)
        case _:
            raise ValueError(ast.unparse(tree))


def _evaluate(tree: ast.expr, columns: dict[str, np.ndarray]) -> np.ndarray | np.float64:
    match tree:
        case ast.Constant(value=number):
            return np.float64(number)
        case ast.Name(id=name):
            return columns[name]
        case ast.BinOp(op=op, left=left, right=right):
            return OPERATORS[type(op)](_evaluate(left, columns), _evaluate(right, columns))
        case ast.UnaryOp(op=op, operand=operand):
            return OPERATORS[type(op)](_evaluate(operand, columns))
        case ast.Call(func=ast.Name(id=name), args=[argument]):
            return FUNCTIONS[name](_evaluate(argument, columns))
    raise AssertionError(ast.dump(tree))
