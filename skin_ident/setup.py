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
            "ident_node = skin_ident.ros.ident_node:main",
            "demo = skin_ident.ros.demo:main",
            "fit = skin_ident.cli.fit:main",
            "diagnose = skin_ident.cli.diagnose:main",
            "report = skin_ident.cli.report:main",
            "hide = skin_ident.cli.hide:main",
            "challenge = skin_ident.cli.challenge:main",
            "identify = skin_ident.cli.identify:main",
            "thesis = skin_ident.cli.thesis:main",
        ]
    },
)
