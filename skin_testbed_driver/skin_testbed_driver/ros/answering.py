"""Services that answer later, from any thread: the events executor of Jazzy cannot await a service's callback."""

from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.service import Service


def create_answering_service(node: Node, kind: type, name: str, callback: Callable[[Any, Callable[[Any], None]], None]) -> Service:
    """A service whose `callback(request, answer)` calls `answer(response)` once, whenever it knows."""
    # What an executor does is: service.send_response(service.callback(request, empty_response), header).
    service = node.create_service(kind, name, lambda request, _: request)

    def send_response(request: Any, header: Any) -> None:
        callback(request, lambda response: Service.send_response(service, response, header))

    service.send_response = send_response
    return service
