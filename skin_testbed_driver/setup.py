"""Packaging of skin_testbed_driver; what it needs at run time is in package.xml and requirements.txt."""

from pathlib import Path

from setuptools import find_packages, setup

NAME = "skin_testbed_driver"
SHARED = ["launch", "config", "rviz", "foxglove", "batteries", "urdf", "worlds"]

setup(
    name=NAME,
    version="0.1.0",
    description="The testbed rig as a lifecycle driver, and a recorder",
    maintainer="Skin testbed maintainers",
    maintainer_email="maintainers@example.org",
    license="Apache-2.0",
    python_requires=">=3.10",
    packages=find_packages(include=[NAME, NAME + ".*"]),
    package_data={NAME: ["data/**"]},  # read with importlib.resources
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        *((f"share/{NAME}/{file.parent}", [str(file)]) for folder in SHARED for file in sorted(Path(folder).rglob("*")) if file.is_file()),
    ],
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "driver_node = skin_testbed_driver.executables:driver_node",
            "recorder = skin_testbed_driver.executables:recorder",
            "call = skin_testbed_driver.executables:call",
            "export_table = skin_testbed_driver.executables:export_table",
            "import_table = skin_testbed_driver.executables:import_table",
        ]
    },
)
