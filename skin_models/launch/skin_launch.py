"""Start one patch of simulated skin.

ros2 launch skin_models skin_launch.py [model:=FILE or MATERIAL] [config:=FILE] [namespace:=NAME]
"""

from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """One node, its parameters from a file, the model from the command line."""
    config = PathJoinSubstitution([FindPackageShare("skin_models"), "config", "skin.yaml"])
    return LaunchDescription(
        [
            DeclareLaunchArgument("model", default_value="silicone_4mm", description="model file, or the name of a shipped material"),
            DeclareLaunchArgument("config", default_value=config, description="parameters of the node"),
            DeclareLaunchArgument("namespace", default_value="", description="where topics and node live"),
            Node(
                package="skin_models",
                executable="skin_node",
                namespace=LaunchConfiguration("namespace"),
                parameters=[LaunchConfiguration("config"), {"model": LaunchConfiguration("model")}],
                output="screen",
            ),
        ]
    )
