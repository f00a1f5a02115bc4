"""A node of the test in a domain of its own, beside the processes that the test starts there."""

import os
import time

import pytest

WAIT = 30.0  # s, what a busy machine may need


class Graph:
    """The test's own node in the domain of the process under test; callbacks run while something is waited for."""

    def __init__(self, domain):
        import rclpy
        from rclpy.executors import SingleThreadedExecutor

        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain.id)
        self.node = rclpy.create_node("test", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)

    def hear(self, kind, topic, qos=200):
        heard = []
        self.node.create_subscription(kind, topic, heard.append, qos)
        return heard

    def spin(self, seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.executor.spin_once(timeout_sec=0.02)

    def until(self, condition, what):
        def check():
            self.executor.spin_once(timeout_sec=0.02)
            return condition()

        from skin_models.ros.processes import wait_until

        return wait_until(check, WAIT, what, period=0.0)

    def call(self, kind, name, request):
        client = self.node.create_client(kind, name)
        self.until(client.service_is_ready, name)
        future = client.call_async(request)
        self.until(future.done, f"an answer of {name}")
        return future.result()

    def publisher(self, kind, topic):
        publisher = self.node.create_publisher(kind, topic, 200)
        self.until(publisher.get_subscription_count, f"a subscriber of {topic}")
        return publisher

    def close(self):
        self.node.destroy_node()
        self.context.shutdown()


@pytest.fixture
def graph(monkeypatch):
    pytest.importorskip("rclpy")  # without ROS the tests of the core run all the same
    from skin_models.ros.processes import Domain, Processes

    with Domain() as domain:
        for name, value in domain.environment().items():
            monkeypatch.setenv(name, value)
        graph = Graph(domain)
        graph.environment = domain.environment()
        with Processes({**os.environ, **graph.environment}) as graph.processes:
            yield graph
        graph.close()
