"""For the tests of all packages: what must be imported before them, and which of them keep to one process."""

from contextlib import suppress
from importlib import import_module
from pathlib import Path

import pytest

# pytest names a test `skin_models.test.test_x` and would otherwise make an empty package of the folder `skin_models`, hiding the real one.
for package in ("skin_models", "skin_motion_profiles", "skin_testbed_driver", "skin_ident"):
    with suppress(ModuleNotFoundError):
        import_module(package)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Where several processes share the tests, one file is one piece; and what runs nodes in real time runs after one another."""
    if not config.pluginmanager.hasplugin("xdist"):
        return
    group = {path: "nodes" if _runs_nodes(path) else str(path) for path in {item.path for item in items}}
    for item in items:
        item.add_marker(pytest.mark.xdist_group(group[item.path]))


def _runs_nodes(test: Path) -> bool:
    return test.parts[-3] == "skin_testbed_driver" or "rclpy" in test.read_text() or ".ros." in test.read_text()
