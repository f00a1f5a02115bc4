"""Requests for a lifecycle transition that does not exist from the present state are answered with failure.

rclpy of Jazzy lets the error of its state machine through instead, which ends the node: activating twice would be enough.
"""

from lifecycle_msgs.srv import ChangeState
from rclpy.lifecycle import LifecycleNode


def bear_wrong_transitions(node: LifecycleNode) -> None:
    """Call this before the node is spun."""
    for service in node.services:
        if service.srv_type is ChangeState:
            service.callback = _forgiving(node, service.callback)


def _forgiving(node: LifecycleNode, change_state):
    def changed(request: ChangeState.Request, response: ChangeState.Response) -> ChangeState.Response:
        try:
            return change_state(request, response)
        except RuntimeError:  # what rcl raises: it changed nothing
            wanted = request.transition.label or request.transition.id
            node.get_logger().error(f"there is no transition {wanted} from the present state")
            response.success = False
            return response

    return changed
