"""Hardware that knows nothing of this suite, one process each: `axis`, `load_cell`, `taxels`. Speaks standard messages only.

    python hardware.py axis JointTrajectory|Float64MultiArray
    python hardware.py load_cell STIFFNESS
    python hardware.py taxels

The axis goes at once where it is told, counting away from the skin; the others know its place from joint_states.
"""

import sys

import rclpy
from geometry_msgs.msg import WrenchStamped
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory

PERIOD = 0.01
SURFACE = -0.052  # of the joint: the skin lies 2 mm below where the axis starts


class Axis(Node):
    def __init__(self, kind: str) -> None:
        super().__init__("axis")
        self.position = SURFACE + 0.002
        self.publisher = self.create_publisher(JointState, "joint_states", 10)
        if kind == "JointTrajectory":
            self.create_subscription(JointTrajectory, "axis_trajectory", self.on_trajectory, 10)
        else:
            self.create_subscription(Float64MultiArray, "axis_trajectory", self.on_array, 10)
        self.create_timer(PERIOD, self.tell)

    def on_trajectory(self, message: JointTrajectory) -> None:
        """As joint_trajectory_controller of Jazzy: what is empty is discarded, what ends with speed is refused."""
        if message.points and not any(message.points[-1].velocities):
            self.position = message.points[-1].positions[0]

    def on_array(self, message: Float64MultiArray) -> None:
        self.position = message.data[0]

    def tell(self) -> None:
        message = JointState(name=["other", "z_axis"], position=[1.0, self.position])
        message.header.stamp = self.get_clock().now().to_msg()
        self.publisher.publish(message)


class Sensor(Node):
    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.depth = 0.0
        self.create_subscription(JointState, "joint_states", self.on_state, 10)
        self.create_timer(PERIOD, self.tell)

    def on_state(self, message: JointState) -> None:
        self.depth = max(SURFACE - message.position[1], 0.0)


class LoadCell(Sensor):
    def __init__(self, stiffness: float) -> None:
        super().__init__("load_cell")
        self.stiffness, self.noise = stiffness, 0.001
        self.publisher = self.create_publisher(WrenchStamped, "wrench", 10)

    def tell(self) -> None:
        self.noise = -self.noise
        message = WrenchStamped()
        message.wrench.force.z = -self.stiffness * self.depth + self.noise
        self.publisher.publish(message)


class Taxels(Sensor):
    def __init__(self) -> None:
        super().__init__("taxels")
        self.publisher = self.create_publisher(Float64MultiArray, "tactile", 10)

    def tell(self) -> None:
        self.publisher.publish(Float64MultiArray(data=[8000.0 * self.depth, 4000.0 * self.depth]))


if __name__ == "__main__":
    rclpy.init()
    make = {"axis": lambda: Axis(sys.argv[2]), "load_cell": lambda: LoadCell(float(sys.argv[2])), "taxels": Taxels}
    rclpy.spin(make[sys.argv[1]]())
