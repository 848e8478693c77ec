"""ros2 launch examples/ros2/dsslam.launch.py left:=/camera/infra1 right:=/camera/infra2

Each of left, right and depth is the namespace of a camera, in which image and camera_info lie.
"""

import pathlib

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

HERE = pathlib.Path(__file__).resolve().parent


def generate_launch_description():
    arguments = [
        ("params", str(HERE / "params.yaml"), "file of parameters"),
        ("left", "left", "namespace of the left, or only, camera"),
        ("right", "right", "namespace of the right camera"),
        ("depth", "depth", "namespace of the registered depth images"),
        ("image", "image_rect", "name of the image topics in the namespaces"),
    ]
    value = LaunchConfiguration
    images = [(f"{side}/image", [value(side), "/", value("image")]) for side in ("left", "right", "depth")]
    infos = [(f"{side}/camera_info", [value(side), "/camera_info"]) for side in ("left", "right")]
    node = Node(
        executable=str(HERE / "dsslam_node.py"),
        name="dsslam",
        output="screen",
        parameters=[value("params")],
        remappings=images + infos,
    )
    declared = [DeclareLaunchArgument(name, default_value=default, description=text) for name, default, text in arguments]
    return LaunchDescription([*declared, node])
