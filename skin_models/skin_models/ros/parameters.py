"""ROS parameters declared from a frozen dataclass: typed, described, with ranges, and checked whenever they are set.

    @dataclass(frozen=True)
    class Settings:
        sample_rate: float = setting(100.0, "Hz, samples per second", lower=1.0, upper=1000.0)

    self.settings = Parameters(self, Settings)
    self.settings.now.sample_rate

A check that involves several parameters belongs into `__post_init__` of the dataclass and raises `SkinError`. A start value for a parameter
that no node here knows, such as one with a slip in its name, gives a warning: ROS itself ignores it in silence.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import field, fields, replace
from difflib import get_close_matches
from typing import Any, Generic, TypeVar

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, ParameterType, SetParametersResult
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node
from rclpy.parameter import Parameter

from skin_models.errors import SkinError

Settings = TypeVar("Settings")

_TYPES = {
    bool: ParameterType.PARAMETER_BOOL,
    int: ParameterType.PARAMETER_INTEGER,
    float: ParameterType.PARAMETER_DOUBLE,
    str: ParameterType.PARAMETER_STRING,
    tuple[float, ...]: ParameterType.PARAMETER_DOUBLE_ARRAY,
    tuple[int, ...]: ParameterType.PARAMETER_INTEGER_ARRAY,
    tuple[str, ...]: ParameterType.PARAMETER_STRING_ARRAY,
}
_EXAMPLES = {bool: "true or false", int: "a whole number", float: "a number with a decimal point", str: "text"}
_ARRAY_TYPES = {float: Parameter.Type.DOUBLE_ARRAY, int: Parameter.Type.INTEGER_ARRAY, str: Parameter.Type.STRING_ARRAY}


def setting(
    default: Any,
    doc: str,
    *,
    lower: float | None = None,
    upper: float | None = None,
    choices: Sequence[str] = (),
    fixed: bool = False,
) -> Any:
    """Declare a field as a ROS parameter. `fixed` makes it read-only after start; `doc` starts with the unit where there is one."""
    return field(default=default, metadata={"doc": doc, "lower": lower, "upper": upper, "choices": tuple(choices), "fixed": fixed})


class Parameters(Generic[Settings]):
    """The parameters of one node; `now` is the present, checked value of all of them."""

    def __init__(self, node: Node, cls: type[Settings], on_change: Callable[[Settings], None] | None = None) -> None:
        """Declare every field of the dataclass `cls`. Raises `SkinError` for an override that cannot be used.

        `on_change(settings)` is called before a change is accepted, and refuses it by raising `SkinError`.
        """
        self._cls, self._on_change = cls, on_change
        self._names = {f.name for f in fields(cls) if "doc" in f.metadata}
        values = {f.name: _declare(node, f) for f in fields(cls) if f.name in self._names}
        self.now: Settings = _checked(cls, cls(**values))
        node.add_on_set_parameters_callback(self._set)
        _warn_of_strangers(node, self._names)

    def now_with(self, **changes: Any) -> Settings:
        """A copy of the present settings with `changes`; those in force stay. Raises `SkinError` for changes that could not be set."""
        return _checked(self._cls, replace(self.now, **changes))

    def _set(self, parameters: list[Parameter]) -> SetParametersResult:
        changes = {p.name: _plain(p.value) for p in parameters if p.name in self._names}
        if not changes:
            return SetParametersResult(successful=True)
        try:
            settings = self.now_with(**changes)
            if self._on_change is not None:
                self._on_change(settings)
        except SkinError as error:
            return SetParametersResult(successful=False, reason=str(error))
        self.now = settings
        return SetParametersResult(successful=True)


def _declare(node: Node, f: Any) -> Any:
    descriptor = _descriptor(f)
    default = list(f.default) if isinstance(f.default, tuple) else f.default
    if default == []:  # an empty list has no type of its own
        default = _ARRAY_TYPES[f.type.__args__[0]]
    try:
        return _plain(node.declare_parameter(f.name, default, descriptor).value)
    except InvalidParameterTypeException as error:
        raise SkinError(f"parameter {f.name} must be {_EXAMPLES.get(f.type, 'a list')}, not {_given(node, f.name)}") from error
    except InvalidParameterValueException as error:
        raise SkinError(f"parameter {f.name} {_allowed(f)}, not {_given(node, f.name)}") from error


def _start_values(node: Node) -> dict[str, Parameter]:
    """What was given for the node at its start; rclpy has no public way to ask."""
    return getattr(node, "_parameter_overrides", {})


def _given(node: Node, name: str) -> str:
    given = _start_values(node).get(name)
    return "this" if given is None else repr(given.value)


def _warn_of_strangers(node: Node, names: set[str]) -> None:
    for name in _start_values(node):
        if not node.has_parameter(name) and not name.startswith("qos_overrides."):
            close = get_close_matches(name, names, 1)
            meant = f": did you mean {close[0]}?" if close else ""
            node.get_logger().warning(f"parameter {name} is not known here and changes nothing{meant}")


def _descriptor(f: Any) -> ParameterDescriptor:
    m = f.metadata
    descriptor = ParameterDescriptor(name=f.name, type=_TYPES[f.type], description=m["doc"], read_only=m["fixed"])
    if f.type is int and m["lower"] is not None:
        descriptor.integer_range = [IntegerRange(from_value=int(m["lower"]), to_value=int(m["upper"]), step=0)]
    elif f.type is float and m["lower"] is not None:
        descriptor.floating_point_range = [FloatingPointRange(from_value=m["lower"], to_value=m["upper"], step=0.0)]
    if m["choices"]:
        descriptor.additional_constraints = "one of: " + ", ".join(m["choices"])
    return descriptor


def _checked(cls: type, settings: Any) -> Any:
    """`settings`, if every value lies in its range. Raises `SkinError` otherwise."""
    for f in fields(cls):
        value, m = getattr(settings, f.name), f.metadata
        if isinstance(value, float) and not math.isfinite(value):
            raise SkinError(f"parameter {f.name} must be a finite number, not {value}")
        if m.get("lower") is not None and not m["lower"] <= value <= m["upper"]:
            raise SkinError(f"parameter {f.name} {_allowed(f)}, not {value}")
        if m.get("choices") and value not in m["choices"]:
            raise SkinError(f"parameter {f.name} must be one of {', '.join(m['choices'])}, not {value!r}")
    return settings


def _allowed(f: Any) -> str:
    return f"must lie between {f.metadata['lower']} and {f.metadata['upper']} ({f.metadata['doc']})"


def _plain(value: Any) -> Any:
    return value if isinstance(value, (bool, int, float, str)) else tuple(value or ())
