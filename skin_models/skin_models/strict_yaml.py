"""YAML as people mean it: a name that stands twice is a slip, and 1e-3 is a number.

PyYAML keeps the last of two entries of one name without a word, and reads 1e-3 as text, because YAML 1.1 wants a point in it. YAML 1.2
settles both as here.
"""

import re
from typing import Any

import yaml

from skin_models.errors import ModelError


class _Loader(yaml.SafeLoader):
    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict:
        names: set[str] = set()
        for key, _ in node.value:
            if isinstance(key, yaml.ScalarNode) and key.value in names:
                raise ModelError(f"{key.value!r} stands twice in one mapping, the second time in line {key.start_mark.line + 1}")
            names.add(str(key.value))
        return super().construct_mapping(node, deep)


_Loader.add_implicit_resolver("tag:yaml.org,2002:float", re.compile(r"[-+]?(\d+|\d*\.\d+|\d+\.)[eE][-+]?\d+$"), list("-+.0123456789"))


def load_yaml(text: str) -> Any:
    """The content of a YAML text. Raises `ModelError` for a name that stands twice, `yaml.YAMLError` for what is no YAML."""
    try:
        return yaml.load(text, _Loader)
    except ValueError as error:  # a date that there is not, a number of thousands of digits
        raise yaml.YAMLError(str(error)) from error
