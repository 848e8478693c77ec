#!/usr/bin/env python3
"""A ROS 2 node around dsslam: images in, odometry, path and transforms out. What it does stands in `dsslam_ros.py`."""

import dataclasses
import types

import numpy as np
import rclpy
import tf2_ros
from geometry_msgs.msg import PoseStamped, TransformStamped
from nav_msgs.msg import Odometry, Path
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import CameraInfo, Image
from std_srvs.srv import Trigger

import dsslam_ros

TYPES = types.SimpleNamespace(Odometry=Odometry, Path=Path, PoseStamped=PoseStamped, TransformStamped=TransformStamped)
SERVICES = ["save_map", "load_map", "localize", "reset"]


class DsslamNode(Node):
    def __init__(self):
        super().__init__("dsslam")
        defaults = dataclasses.asdict(dsslam_ros.Parameters())
        values = {name: self.declare_parameter(name, value).value for name, value in defaults.items()}
        self.parameters = dsslam_ros.Parameters(**values)
        say = self.get_logger().info
        self.tracker = dsslam_ros.Tracker(self.parameters, self.base_from_camera, say)
        self.odometry = self.create_publisher(Odometry, "~/odometry", 10)
        self.path = self.create_publisher(Path, "~/path", 1)
        self.broadcaster = tf2_ros.TransformBroadcaster(self)
        self.buffer = tf2_ros.Buffer()
        self.listener = tf2_ros.TransformListener(self.buffer, self)
        second = {"stereo": ["right"], "rgbd": ["depth"]}.get(self.parameters.sensor, [])
        for side in ["left", *second]:
            self.create_subscription(Image, f"{side}/image", lambda m, side=side: self.take(side, m), qos_profile_sensor_data)
        for side in ["left", "right"][: 2 if self.parameters.sensor == "stereo" else 1]:
            take = lambda m, side=side: self.tracker.camera_info(side, m)  # noqa: E731
            self.create_subscription(CameraInfo, f"{side}/camera_info", take, qos_profile_sensor_data)
        for name in SERVICES:
            self.create_service(Trigger, f"~/{name}", lambda _, answer, name=name: self.serve(name, answer))
        say(f"{self.parameters.sensor}, pairs within {self.parameters.sync_tolerance * 1e3:g} ms")

    def base_from_camera(self, frame_id):
        """The camera's place on the robot, if anyone publishes it."""
        try:
            found = self.buffer.lookup_transform(self.parameters.base_frame, frame_id, rclpy.time.Time()).transform
        except tf2_ros.TransformException:
            return None
        x, y, z, w = found.rotation.x, found.rotation.y, found.rotation.z, found.rotation.w
        pose = np.eye(4)
        pose[:3, :3] = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
        pose[:3, 3] = found.translation.x, found.translation.y, found.translation.z
        return pose

    def take(self, side, message):
        try:
            found = self.tracker.image(side, message)
        except (ValueError, TypeError, RuntimeError) as error:
            self.get_logger().error(str(error), throttle_duration_sec=5.0)
            return
        for located in found:
            self.odometry.publish(dsslam_ros.odometry(TYPES, self.parameters, located))
            links = dsslam_ros.transforms(TYPES, self.parameters, located)
            if links:
                self.broadcaster.sendTransform(links)
            if (self.tracker.n_located - 1) % self.parameters.path_every == 0:
                self.path.publish(dsslam_ros.path(TYPES, self.parameters, self.tracker.path, located.t_ns))

    def serve(self, name, answer):
        # The file may have been set since.
        self.parameters.map_file = self.get_parameter("map_file").value
        try:
            answer.success, answer.message = True, getattr(self.tracker, name)()
        except (ValueError, RuntimeError) as error:
            answer.success, answer.message = False, str(error)
        return answer


def main():
    rclpy.init()
    node = DsslamNode()
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
