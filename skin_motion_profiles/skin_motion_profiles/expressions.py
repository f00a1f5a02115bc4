"""Numbers written as small expressions, so that one battery serves every depth: `0.3*depth_mm`, `seed + 1`, `1e-3`."""

import ast
import operator
from collections.abc import Mapping
from typing import Any

from skin_motion_profiles.errors import ProfileError

_BINARY = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv, ast.Mod: operator.mod,
}  # fmt: skip
_LONGEST = 200  # characters


def evaluate(value: Any, arguments: Mapping[str, float], label: str) -> Any:
    """`value` with every text in it replaced by the number it describes; lists are gone through, other things stay as they are.

    Allowed are numbers, the names in `arguments`, + - * / % and brackets. Raises `ProfileError` naming `label` for anything else.
    """
    if isinstance(value, (list, tuple)):
        return [evaluate(v, arguments, label) for v in value]
    if not isinstance(value, str):
        return value
    if len(value) > _LONGEST:
        raise ProfileError(f"{label}: an expression has at most {_LONGEST} characters, this one {len(value)}")
    try:
        return float(value) if _is_float(value) else _number(ast.parse(value, mode="eval").body, arguments, label)
    except (SyntaxError, ValueError, RecursionError) as error:
        raise ProfileError(f"{label}: {value!r} is neither a number nor an expression such as 0.5*depth_mm") from error
    except (ZeroDivisionError, OverflowError) as error:
        raise ProfileError(f"{label}: {value!r} has no finite value") from error


def _number(node: ast.AST, arguments: Mapping[str, float], label: str) -> float:
    match node:
        case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
            return number
        case ast.Name(id=name):
            if name in arguments:
                return arguments[name]
            known = f"; there are {', '.join(arguments)}" if arguments else ", and no number"
            raise ProfileError(f"{label}: {name} is not an argument{known}")
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return -_number(operand, arguments, label)
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _BINARY:
            return _BINARY[type(op)](_number(left, arguments, label), _number(right, arguments, label))
    raise ValueError("not allowed")


def _is_float(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
