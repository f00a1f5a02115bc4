"""Of every package only `ros/` knows ROS, no package looks where the design forbids it, and its manifest says what it needs.

Programs beside a package are no part of it: a test or a bench that runs a node imports ROS to talk to it over DDS, as any graph would.

Run as a program, this file imports the modules named on its command line in a Python where every import of ROS fails.
"""

import ast
import importlib
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

TOP = Path(__file__).resolve().parents[2]

NEVER_IMPORTS = {
    "skin_models": {"skin_ident", "skin_testbed_driver"},
    "skin_motion_profiles": {"skin_ident", "skin_testbed_driver"},
    "skin_testbed_driver": {"skin_ident"},
    "skin_ident": {"skin_testbed_driver"},
}

# Where the rosdep key is not the name that is imported; None for what is used only where it happens to be installed.
ROSDEP_KEYS = {
    "lz4": "mcap-ros2-support",
    "matplotlib": "python3-matplotlib",
    "mcap": "mcap-ros2-support",
    "mujoco": None,
    "numpy": "python3-numpy",
    "ros_gz_interfaces": None,
    "rosbags": "python3-rosbags-pip",
    "scipy": "python3-scipy",
    "yaml": "python3-yaml",
    "zlib_ng": None,
    "zstandard": "mcap-ros2-support",
}


def is_ros(module):
    """Return whether a module is there only where ROS is."""
    root = module.partition(".")[0]
    named = root in {"rclpy", "launch", "launch_ros", "ament_index_python", "rosbag2_py", "tf2_ros"}
    return named or root.startswith("rosidl") or root.endswith(("_msgs", "_interfaces", "_srvs"))


class NoRos:
    """Makes every import of ROS fail, as on a machine without it."""

    def find_spec(self, name, path=None, target=None):
        if is_ros(name):
            raise ImportError(f"{name} is imported, but there is no ROS here")


def modules(package):
    """Return the files of a package by module name, tests and packaging aside."""
    files = sorted((TOP / package / package).rglob("*.py"))
    return {".".join(file.relative_to(TOP / package).with_suffix("").parts): file for file in files}


def core(package):
    """Return those modules that must not know ROS."""
    return {name: file for name, file in modules(package).items() if not name.startswith(f"{package}.ros.")}


def imported(file):
    """Yield every module that a file imports by its full name, also inside functions."""
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield node.module


@pytest.mark.parametrize("package", NEVER_IMPORTS)
def test_core_imports_where_there_is_no_ros(package):
    names = [name for name in core(package) if not name.endswith(".__main__")]
    ran = subprocess.run([sys.executable, __file__, *names], capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr


@pytest.mark.parametrize("package", NEVER_IMPORTS)
def test_core_never_asks_for_ros(package):
    assert not [(name, ros) for name, file in core(package).items() for ros in imported(file) if is_ros(ros)]


@pytest.mark.parametrize("package", NEVER_IMPORTS)
def test_package_keeps_to_its_room(package):
    forbidden = NEVER_IMPORTS[package]
    assert not [
        (name, other) for name, file in modules(package).items() for other in imported(file) if other.partition(".")[0] in forbidden
    ]


@pytest.mark.parametrize("package", NEVER_IMPORTS)
def test_manifest_names_what_is_imported(package):
    roots = {name.partition(".")[0] for file in modules(package).values() for name in imported(file)}
    keys = {ROSDEP_KEYS.get(root, root) for root in roots - sys.stdlib_module_names - {package}} - {None}
    declared = {element.text for element in ElementTree.parse(TOP / package / "package.xml").getroot()}
    assert keys <= declared, f"{package}/package.xml lacks an exec_depend on {sorted(keys - declared)}"


if __name__ == "__main__":
    sys.meta_path.insert(0, NoRos())
    for module in sys.argv[1:]:
        importlib.import_module(module)
