import subprocess
import sys

SCRIPT = """
import importlib, pkgutil, sys
class Block:
    def find_spec(self, name, *_):
        if name.split(".")[0] in ("rclpy", "rosidl_runtime_py", "ament_index_python") or name.split(".")[0].endswith("_msgs"):
            raise ImportError(name + " is blocked")
sys.meta_path.insert(0, Block())
import skin_testbed_driver as package
for module in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
    if ".ros" not in module.name:
        importlib.import_module(module.name)
        print(module.name)
"""


def test_everything_outside_ros_imports_without_ros():
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert "skin_testbed_driver.testbed" in done.stdout
