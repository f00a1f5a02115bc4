"""Packaging of skin_models; what it needs at run time is in package.xml and requirements.txt."""

from pathlib import Path

from setuptools import find_packages, setup

NAME = "skin_models"
SHARED = ["launch", "config", "rviz", "foxglove", "batteries", "urdf", "worlds"]

setup(
    name=NAME,
    version="0.1.0",
    description="Robot-skin models and the simulated skin",
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
            "skin_node = skin_models.executables:skin_node",
            "mujoco_finger = skin_models.executables:mujoco_finger",
            "effects_gallery = skin_models.executables:effects_gallery",
            "skin_acuity = skin_models.executables:skin_acuity",
        ]
    },
)
