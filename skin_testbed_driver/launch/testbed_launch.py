"""Bring up the testbed: driver, profile server and, where asked for, simulated skin beside the rig, recorder and viewers.

ros2 launch skin_testbed_driver testbed_launch.py
ros2 launch skin_testbed_driver testbed_launch.py time_scale:=5.0 record:=session_1
ros2 launch skin_testbed_driver testbed_launch.py params:=my_rig.yaml rviz:=true
ros2 launch skin_testbed_driver testbed_launch.py compare:=model.yaml      the same contacts on a fitted model, as simulated/…
"""

from launch.actions import DeclareLaunchArgument, Shutdown
from launch.conditions import IfCondition, UnlessCondition
from launch.substitutions import (
    Command,
    EqualsSubstitution,
    LaunchConfiguration,
    OrSubstitution,
    PathJoinSubstitution,
    PythonExpression,
)
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

from launch import LaunchDescription

PACKAGE = "skin_testbed_driver"


def shared(*parts: str) -> PathJoinSubstitution:
    """A file that the package installs."""
    return PathJoinSubstitution([FindPackageShare(PACKAGE), *parts])


ARGUMENTS = (
    ("params", shared("config", "testbed.yaml"), "parameters of all nodes"),
    ("namespace", "", "namespace of all nodes"),
    ("time_scale", "1.0", "simulated seconds per second; other than 1.0 everybody lives by /clock"),
    ("model", "silicone_4mm", "specimen of the simulated rig: a shipped material, or a YAML file with hidden effects"),
    ("record", "", "directory to record into, must not exist; empty: no recording"),
    ("compare", "", "a fitted model: a simulated skin beside the rig publishes simulated/force and simulated/taxels"),
    ("rviz", "false", "open RViz; publishes the frames, too"),
    ("describe", "false", "publish the frames of the testbed with robot_state_publisher"),
)


def generate_launch_description() -> LaunchDescription:
    """Launch entry point."""
    params, namespace = LaunchConfiguration("params"), LaunchConfiguration("namespace")
    time_scale = LaunchConfiguration("time_scale")
    simulated_time = {"use_sim_time": ParameterValue(PythonExpression([time_scale, " != 1.0"]), value_type=bool)}
    common = {"namespace": namespace, "output": "screen"}
    driver = Node(
        package=PACKAGE,
        executable="driver_node",
        name="testbed_driver",
        on_exit=Shutdown(),
        parameters=[params, {"time_scale": ParameterValue(time_scale, value_type=float), "model": LaunchConfiguration("model")}],
        **common,
    )
    profiles = Node(
        package="skin_motion_profiles", executable="profile_server", name="profile_server", parameters=[params, simulated_time], **common
    )
    recorder = Node(
        package=PACKAGE,
        executable="recorder",
        name="recorder",
        condition=_unless_empty("record"),
        parameters=[params, simulated_time, {"directory": LaunchConfiguration("record")}],
        **common,
    )
    return LaunchDescription(
        [
            *(DeclareLaunchArgument(name, default_value=default, description=text) for name, default, text in ARGUMENTS),
            driver,
            profiles,
            recorder,
            _simulated_skin(params, simulated_time, common),
            *_viewers(simulated_time, common),
        ]
    )


def _simulated_skin(params, simulated_time: dict, common: dict) -> Node:
    topics = ("force", "taxels", "taxels_truth", "taxel_layout", "markers", "heat_map", "points")
    return Node(
        package="skin_models",
        executable="skin_node",
        name="simulated_skin",
        condition=_unless_empty("compare"),
        parameters=[params, simulated_time, {"model": LaunchConfiguration("compare"), "drive": "encoder"}],
        remappings=[(topic, f"simulated/{topic}") for topic in topics],
        **common,
    )


def _viewers(simulated_time: dict, common: dict) -> list[Node]:
    urdf = ParameterValue(Command(["cat ", shared("urdf", "testbed.urdf")]), value_type=str)
    return [
        Node(
            package="robot_state_publisher",
            executable="robot_state_publisher",
            condition=IfCondition(OrSubstitution(LaunchConfiguration("describe"), LaunchConfiguration("rviz"))),
            parameters=[simulated_time, {"robot_description": urdf}],
            remappings=[("joint_states", "encoder")],
            **common,
        ),
        Node(
            package="rviz2",
            executable="rviz2",
            condition=IfCondition(LaunchConfiguration("rviz")),
            arguments=["-d", shared("rviz", "testbed.rviz")],
            parameters=[simulated_time],
            **common,
        ),
    ]


def _unless_empty(name: str) -> UnlessCondition:
    return UnlessCondition(EqualsSubstitution(LaunchConfiguration(name), ""))
