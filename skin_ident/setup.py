"""Packaging of skin_ident; what it needs at run time is in package.xml and requirements.txt."""

from pathlib import Path

from setuptools import find_packages, setup

NAME = "skin_ident"
SHARED = ["launch", "config", "rviz", "foxglove", "batteries", "urdf", "worlds"]

setup(
    name=NAME,
    version="0.1.0",
    description="Identification and criticism of robot-skin simulations",
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
            "ident_node = skin_ident.executables:ident_node",
            "demo = skin_ident.executables:demo",
            "fit = skin_ident.executables:fit",
            "diagnose = skin_ident.executables:diagnose",
            "report = skin_ident.executables:report",
            "hide = skin_ident.executables:hide",
            "challenge = skin_ident.executables:challenge",
            "identify = skin_ident.executables:identify",
            "thesis = skin_ident.executables:thesis",
        ]
    },
)
