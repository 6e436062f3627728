"""ros2 launch subskin_ros finger.launch.py finger:=/home/me/finger.toml port:=serial:/dev/skin."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description():
    """One finger."""
    arguments = {
        "finger": ("", "finger.toml"),
        "port": ("", "where the device is; that of the finger file if left out"),
        "topic": ("/subskin", "what the topics begin with"),
    }
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=usual, description=said)
                for name, (usual, said) in arguments.items()
            ),
            Node(
                package="subskin_ros",
                executable="finger",
                output="screen",
                parameters=[{name: LaunchConfiguration(name) for name in arguments}],
            ),
        ]
    )
