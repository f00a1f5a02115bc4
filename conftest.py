"""Import the packages before their tests: pytest names a test `skin_models.test.test_x` and would otherwise make an empty
package of the folder `skin_models`, hiding the real one."""

from contextlib import suppress
from importlib import import_module

for package in ("skin_models", "skin_motion_profiles", "skin_testbed_driver", "skin_ident"):
    with suppress(ModuleNotFoundError):
        import_module(package)
