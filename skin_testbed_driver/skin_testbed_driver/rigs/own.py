"""A rig of one's own: the one class of `Rig` in a Python file, or in an installed module. The driver itself stays as it is."""

import importlib
import importlib.util
import inspect
from pathlib import Path
from types import ModuleType
from typing import Any

import yaml

from skin_models.errors import SkinError
from skin_models.layout import Layout
from skin_testbed_driver.rig import Rig, RigError


def is_own_rig(name: str) -> bool:
    """Whether `name` is that of a Python file, `my_rig.py`, or of a module in a package, `my_package.my_rig`."""
    return "." in name


def own_rig(name: str, layout: Layout, options: str) -> Rig:
    """The rig `name`, closed, made with `layout` and the mapping in the YAML text `options`. Raises `RigError`."""
    kind = _rig_class(_module(name), name)
    try:
        return kind(layout=layout, **_mapping(options))
    except TypeError as error:
        raise RigError(f"{name}: {error}; rig_options gives what __init__ takes besides layout") from error
    except SkinError:
        raise
    except Exception as error:  # somebody else's code
        raise RigError(f"cannot make the rig {name}: {type(error).__name__}: {error}") from error


def _module(name: str) -> ModuleType:
    if name.endswith(".py") and not Path(name).exists():
        raise RigError(f"cannot load the rig {name}: no such file")
    try:
        if not name.endswith(".py"):
            return importlib.import_module(name)
        path = Path(name)
        spec = importlib.util.spec_from_file_location(path.stem, path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    except Exception as error:  # somebody else's code
        raise RigError(f"cannot load the rig {name}: {type(error).__name__}: {error}") from error
    return module


def _rig_class(module: ModuleType, name: str) -> type[Rig]:
    found = [c for _, c in inspect.getmembers(module, inspect.isclass) if issubclass(c, Rig) and c.__module__ == module.__name__]
    if len(found) != 1:
        there = ", ".join(c.__name__ for c in found) or "none"
        raise RigError(f"{name} needs one class of skin_testbed_driver.rig.Rig, and has {there}")
    if inspect.isabstract(found[0]):
        raise RigError(f"{name}: {found[0].__name__} lacks {', '.join(sorted(found[0].__abstractmethods__))}")
    return found[0]


def _mapping(text: str) -> dict[str, Any]:
    try:
        options = yaml.safe_load(text) if text else {}
    except yaml.YAMLError as error:
        raise RigError(f"rig_options is not YAML: {' '.join(str(error).split())}") from error
    if not isinstance(options, dict):
        raise RigError(f"rig_options must be a mapping such as {{port: /dev/ttyUSB0}}, not {text!r}")
    return options
