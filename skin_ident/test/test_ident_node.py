"""The installed ident node, over real DDS: live estimates of a skin that is being pressed, and the action on recordings."""

import threading
import time

import numpy as np
import pytest
from making import SILICONE, START_NS, recording, response, sine, write_bag, write_mcap

rclpy = pytest.importorskip("rclpy")
pytest.importorskip("skin_testbed_msgs")

from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402
from geometry_msgs.msg import WrenchStamped  # noqa: E402
from rclpy.action import ActionClient  # noqa: E402
from rclpy.context import Context  # noqa: E402
from rclpy.executors import SingleThreadedExecutor  # noqa: E402
from rclpy.parameter import Parameter  # noqa: E402
from rclpy.qos import qos_profile_sensor_data  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from skin_testbed_msgs.action import Identify  # noqa: E402
from skin_testbed_msgs.msg import ParameterEstimates, TaxelArray  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402

from skin_ident.recordings.declared import Declared  # noqa: E402
from skin_ident.recordings.mass import known_mass  # noqa: E402
from skin_ident.ros.ident_node import IdentNode  # noqa: E402
from skin_models.model_file import load_model  # noqa: E402
from skin_models.ros.processes import Domain, Processes, wait_until  # noqa: E402


class Bench:
    """A node that stands for the rig and for the user."""

    def __init__(self, domain):
        self.context = Context()
        rclpy.init(context=self.context, domain_id=domain.id)
        self.node = rclpy.create_node("bench", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.heard, self.feedback, self.said = [], [], []
        publisher = self.node.create_publisher
        self.encoder = publisher(JointState, "encoder", qos_profile_sensor_data)
        self.force = publisher(WrenchStamped, "force", qos_profile_sensor_data)
        self.taxels = publisher(TaxelArray, "taxels", qos_profile_sensor_data)
        self.node.create_subscription(ParameterEstimates, "estimates", self.heard.append, 10)
        self.node.create_subscription(DiagnosticArray, "/diagnostics", lambda m: self.said.extend(s.message for s in m.status), 10)
        self.identify = ActionClient(self.node, Identify, "identify")
        self.save = self.node.create_client(Trigger, "/ident_node/save")
        self.thread = threading.Thread(target=self.executor.spin, daemon=True)
        self.thread.start()

    def press(self, seconds, truth, silent=None):
        """Publish a sine at ten times its speed: 100 Hz stamps, sent at 1 kHz; nothing of the topic that is `silent`."""
        xva = sine(n=int(100 * seconds), hz=0.5)
        force, taxels = response(xva, truth, (1.0, 0.3))
        rng = np.random.default_rng(0)
        for i in range(force.size):
            stamp = {"sec": 1000 + i // 100, "nanosec": (i % 100) * 10_000_000}
            x, f, s = (JointState(name=["indentation"], position=[xva[0, i]]), WrenchStamped(), TaxelArray(force=(taxels[:, i]).tolist()))
            f.wrench.force.z = -force[i] + 0.02 * rng.normal()
            for publisher, message in ((self.encoder, x), (self.force, f), (self.taxels, s)):
                message.header.stamp.sec, message.header.stamp.nanosec = stamp["sec"], stamp["nanosec"]
                if publisher is not silent:
                    publisher.publish(message)
            time.sleep(0.001)

    def ask(self, start, timeout=20.0):
        """Call in the thread that handles the answer: from another one, rclpy may see the answer before it knows of the question."""
        futures = []
        self.executor.create_task(lambda: futures.append(start()))
        wait_until(lambda: futures and futures[0].done(), timeout, "an answer")
        return futures[0].result()

    def send(self, **goal):
        wait_until(lambda: self.identify.wait_for_server(0.1), 20.0, "the action identify")
        return self.ask(lambda: self.identify.send_goal_async(Identify.Goal(**goal), lambda m: self.feedback.append(m.feedback)))

    def close(self):
        self.executor.shutdown()
        self.thread.join(5.0)
        self.node.destroy_node()
        self.context.shutdown()


@pytest.fixture(scope="module")
def world(tmp_path_factory):
    folder = tmp_path_factory.mktemp("ident")
    with Domain() as domain, Processes(domain.environment()) as processes:
        node = processes.start("skin_ident", "ident_node", parameters={"publish_period": 0.1, "model_path": str(folder / "live.yaml")})
        node.wait_for_output("ready", 20.0)
        bench = Bench(domain)
        yield bench, folder, node
        bench.close()


def test_live_estimates_approach_the_truth_and_can_be_saved(world):
    bench, folder, _ = world
    wait_until(lambda: bench.encoder.get_subscription_count() and bench.taxels.get_subscription_count(), 20.0, "the node's subscriptions")
    bench.press(12.0, SILICONE[4])

    def near(message):
        values = dict(zip(message.names, message.values, strict=True))
        return [values.get(n) for n in ("b1", "k1", "b2", "k2", "share_1")] == pytest.approx([*SILICONE[4][1:], 0.3], rel=0.03)

    def sure(message):
        return dict(zip(message.names, message.verdicts, strict=True))["k1"] == "identifiable" and message.effective_samples > 50

    wait_until(lambda: next((m for m in bench.heard[-1:] if near(m) and sure(m)), None), 20.0, "a sure estimate near the truth")
    assert bench.ask(lambda: bench.save.call_async(Trigger.Request())).success
    assert load_model(folder / "live.yaml").dispersion.k1 == pytest.approx(9619, rel=0.03)


def test_a_topic_that_falls_silent_is_named(world):
    bench, _, _ = world
    wait_until(lambda: bench.force.get_subscription_count() and bench.taxels.get_subscription_count(), 20.0, "the node's subscriptions")
    bench.press(4.0, SILICONE[4])
    bench.press(4.0, SILICONE[4], silent=bench.force)
    said = "no complete samples since the last look: nothing came on force"
    wait_until(lambda: said in bench.said, 10.0, "the name of the silent topic")
    wait_until(lambda: bench.said[-1].endswith("nothing came on encoder and force and taxels"), 10.0, "all three")


def test_the_mass_it_holds_is_that_of_fit(world):
    bench, _, _ = world
    newest = wait_until(lambda: bench.heard[-1:], 10.0, "estimates")[0]
    assert dict(zip(newest.names, newest.values, strict=True))["m"] == known_mass(Declared()).kg == pytest.approx(0.432e-3)


def test_rude_messages_do_not_end_it(world):
    bench, _, node = world
    for message in (JointState(name=["indentation"]), JointState(), JointState(name=["indentation"], position=[float("nan")])):
        bench.encoder.publish(message)
    bench.taxels.publish(TaxelArray(force=[float("inf")] * 500))
    heard = len(bench.heard)
    wait_until(lambda: len(bench.heard) > heard + 3, 10.0, "estimates after rude messages")
    assert node.status is None


def test_identify_fits_recordings(world):
    bench, folder, _ = world
    bags = [str(write_bag(folder / f"s{i}", recording(i, n=500))) for i in range(2)]
    answer = bench.ask(bench.send(recordings=bags, output_directory=str(folder / "out")).get_result_async).result
    values = dict(zip(answer.parameter_names, answer.values, strict=True))
    assert answer.error_code == 0 and values["k1"] == pytest.approx(9619, rel=0.02)
    assert load_model(folder / "out" / "model.yaml").dispersion.k1 == pytest.approx(values["k1"])
    # the client stops listening when the result comes, so that the last feedback may be missing
    assert bench.feedback and [f.progress for f in bench.feedback] == sorted(f.progress for f in bench.feedback)


@pytest.mark.parametrize("paths", [[], [""], ["/does/not/exist"]])
def test_identify_refuses_what_it_cannot_use(world, paths):
    bench, folder, _ = world
    answer = bench.ask(bench.send(recordings=paths, output_directory=str(folder / "none")).get_result_async).result
    assert answer.error_code == Identify.Result.UNUSABLE_INPUT and answer.error_string and not (folder / "none").exists()


def test_identify_says_when_it_cannot_write(world):
    bench, folder, _ = world
    bench.feedback.clear()
    bag = str(write_bag(folder / "unwritten", recording(n=500)))
    answer = bench.ask(bench.send(recordings=[bag], output_directory="/dev/full").get_result_async).result
    assert answer.error_code == Identify.Result.WRITE_FAILED and "/dev/full" in answer.error_string
    assert not bench.feedback  # before it reads and fits


def frozen(store, i, message):
    """Stamps that stand still."""
    message.header.stamp.sec, message.header.stamp.nanosec = 5, 0
    return message


def test_identify_reads_as_fit_does(world):
    """By the times of recording, by named topics, and with a robust loss."""
    bench, folder, _ = world
    bag = str(write_mcap(folder / "frozen.mcap", recording(n=800), log_delay_ns=0, change=frozen))
    by_stamp, by_log, no_topic, no_loss = (
        bench.ask(bench.send(recordings=[bag], **more).get_result_async).result
        for more in ({}, {"log_time": True, "loss": "huber", "topics": ["force=/force"]}, {"topics": ["force=/ft"]}, {"loss": "hubert"})
    )
    assert by_stamp.error_code == Identify.Result.UNUSABLE_INPUT and "--log-time" in by_stamp.error_string
    assert by_log.error_code == 0 and dict(zip(by_log.parameter_names, by_log.values, strict=True))["k1"] == pytest.approx(9619, rel=0.03)
    assert "/ft" in no_topic.error_string and "huber" in no_loss.error_string


def test_identify_keeps_stamps(world):
    bench, folder, _ = world
    r = recording(n=800)
    jitter = np.random.default_rng(0).uniform(-2e6, 2e6, len(r)).astype(int)
    stamps = START_NS + np.rint(1e9 * r.t).astype(np.int64) + jitter
    bag = str(write_mcap(folder / "uneven.mcap", r, stamps_ns=stamps))
    for keep in (False, True):
        out = folder / f"kept_{keep}"
        answer = bench.ask(bench.send(recordings=[bag], keep_stamps=keep, output_directory=str(out)).get_result_async).result
        assert answer.error_code == 0 and ("stamps kept" in (out / "fit.json").read_text()) == keep


def test_identify_can_be_cancelled(world):
    bench, folder, _ = world
    bag = str(write_bag(folder / "long", recording(n=2000)))
    handle = bench.send(recordings=[bag] * 40, output_directory=str(folder / "cancelled"))
    wait_until(lambda: bench.feedback, 10.0, "feedback")
    bench.ask(handle.cancel_goal_async)
    answer = bench.ask(handle.get_result_async, 30.0).result
    assert answer.error_code == Identify.Result.CANCELLED and not (folder / "cancelled").exists()


def test_a_goal_that_waits_for_another_can_be_cancelled_before_that_ends(world):
    bench, folder, _ = world
    bag = str(write_bag(folder / "first", recording(n=2000)))
    first, second = bench.send(recordings=[bag] * 40), bench.send(recordings=[bag])
    bench.ask(second.cancel_goal_async)
    assert bench.ask(second.get_result_async, 5.0).result.error_code == Identify.Result.CANCELLED
    bench.ask(first.cancel_goal_async)  # it was still at work
    assert bench.ask(first.get_result_async, 30.0).result.error_code == Identify.Result.CANCELLED


def test_identify_criticises(world):
    bench, folder, _ = world
    bags = [str(write_bag(folder / f"c{i}", recording(i, n=1500, offset=0.2e-3))) for i in range(2)]
    goal = bench.send(recordings=bags[:1], hold_out=bags[1:], criticise=True, output_directory=str(folder / "criticised"))
    answer = bench.ask(goal.get_result_async, 60.0).result
    assert answer.error_code == 0 and answer.verdict == "nothing_wrong" and not answer.causes, answer
    assert (folder / "criticised" / "findings.json").samefile(answer.findings) and "k1" in answer.parameter_names


def test_what_was_learnt_is_forgotten_only_where_other_settings_make_another_estimate(monkeypatch):
    with Domain() as domain:
        for name, value in domain.environment().items():
            monkeypatch.setenv(name, value)
        rclpy.init()
        node = IdentNode()

        def kept(accepted=True, **values):
            """Whether the estimate is still the same after setting parameters, all of them or none."""
            before = node.fit
            assert node.set_parameters_atomically([Parameter(k, value=v) for k, v in values.items()]).successful == accepted
            return node.fit is before

        try:
            assert kept(model_path="other.yaml") and kept(window=30.0, cutoff=5.0)  # no estimate depends on it; as they are
            assert kept(accepted=False, window=20.0, publish_period=0.2) and kept(accepted=False, window=-1.0)
            assert not any(kept(**change) for change in ({"window": 20.0}, {"cutoff": 4.0}, {"mass": 1e-3}, {"joint": "stage"}))
            assert (node.fit.window, node.fit.cutoff, node.fit.mass) == (20.0, 4.0, 1e-3) and kept(window=20.0)
        finally:
            node.destroy_node()
            rclpy.shutdown()


def test_ends_cleanly(world):
    assert world[2].status is None and world[2].end() == 0
