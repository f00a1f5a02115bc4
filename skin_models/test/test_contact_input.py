"""From messages to presses: the rule for silence, unusable contacts, and Gazebo's contacts (whose package has no wheel)."""

import math
from types import SimpleNamespace as Thing

import numpy as np
import pytest

pytest.importorskip("skin_testbed_msgs")

from skin_models.ros.contact_input import BAD_RADIUS, NO_FORCE, NO_PLACE, NOTHING, TOO_DEEP, TOO_HARD, ContactInput, from_gazebo

HERE = (1e-3, 0.0, 0.0)


def test_a_message_holds_then_fades_then_is_gone():
    got = ContactInput()
    got.take("contacts", [("a", HERE, 8.0, math.nan, 0.0)], now=10.0)
    fresh, stale = got.at(10.2, timeout=0.2, decay=0.1)
    assert fresh.force == pytest.approx([8.0]) and not stale
    faded, stale = got.at(10.4, timeout=0.2, decay=0.1)
    assert faded.force == pytest.approx([8.0 * math.exp(-2)]) and stale
    gone, stale = got.at(11.0, timeout=0.2, decay=0.1)
    assert gone.key == () and not stale


def test_a_clock_that_is_set_back_leaves_no_contact_behind():
    got = ContactInput()
    got.take("gz_contacts", [("a", HERE, 8.0, math.nan, 0.0)], now=1000.0)
    assert got.at(1.0, timeout=0.2, decay=0.1)[0].force == pytest.approx([8.0])
    assert got.at(1.1, timeout=0.2, decay=0.1)[1] is False
    assert got.at(3.0, timeout=0.2, decay=0.1)[0].key == ()


def test_sources_add_up_and_replace_only_themselves():
    got = ContactInput()
    got.take("contacts", [("a", HERE, 1.0, math.nan, 0.0), ("", HERE, math.nan, 1e-3, 2e-3)], now=0.0)
    got.take("wrench", [("", HERE, 2.0, math.nan, 0.0)], now=0.0)
    both, _ = got.at(0.0, 1.0, 1.0)
    assert both.key == ("contacts/a", "contacts/1", "wrench/0") and both.position.shape == (3, 3)
    got.take("contacts", [], now=0.0)
    assert got.at(0.0, 1.0, 1.0)[0].key == ("wrench/0",)


def test_unusable_contacts_are_left_out_and_counted_and_pulling_does_not_press():
    got, nan = ContactInput(), math.nan
    bad = [("", HERE, nan, nan, 0.0), ("", (nan, 0.0, 0.0), 1.0, nan, 0.0), ("", HERE, 1.0, nan, -1.0), ("", HERE, math.inf, nan, 0.0)]
    bad += [("", HERE, 1e9, nan, 0.0), ("", HERE, nan, 1.0, 0.0), ("", HERE, nan, -math.inf, 0.0)]
    got.take("contacts", [*bad, ("pull", HERE, -3.0, nan, 0.0)], now=0.0)
    presses, _ = got.at(0.0, 1.0, 1.0)
    assert got.unusable == {NOTHING: 1, NO_PLACE: 1, BAD_RADIUS: 1, TOO_HARD: 2, TOO_DEEP: 2}
    assert presses.key == ("contacts/pull",) and presses.force == pytest.approx([0.0])


def test_a_depth_beside_a_force_of_exactly_zero_is_doubted_and_the_force_counts():
    got, nan = ContactInput(), math.nan
    sound = [("", HERE, nan, 1e-3, 0.0), ("", HERE, 1.0, 1e-3, 0.0), ("", HERE, 0.0, nan, 0.0), ("", HERE, 0.0, 0.0, 0.0)]
    got.take("contacts", [*sound, ("", HERE, 0.0, 1e-3, 0.0)], now=0.0)
    got.take("gz", [("", HERE, 0.0, 1e-3, 0.0)], now=0.0)  # Gazebo cannot leave a force out
    assert got.doubtful == {NO_FORCE: 1} and not got.unusable.total()
    assert got.at(0.0, 1.0, 1.0)[0].force[4] == 0.0


def test_two_contacts_of_one_name_stay_two():
    got = ContactInput()
    got.take("contacts", [("tip", HERE, 1.0, math.nan, 0.0)] * 2, now=0.0)
    assert got.at(0.0, 1.0, 1.0)[0].key == ("contacts/tip#0", "contacts/tip#1")


def test_gazebo_contacts_give_force_along_the_normal_or_depth():
    def vector(x, y, z):
        return Thing(x=x, y=y, z=z)

    contact = Thing(
        collision1=Thing(name="finger"), collision2=Thing(name="skin"),
        positions=[vector(1e-3, 2e-3, 0.0), vector(0.0, 0.0, 0.0)],
        normals=[vector(0.0, 0.0, 1.0)], depths=[1e-4, 2e-4],
        wrenches=[Thing(body_1_wrench=Thing(force=vector(3.0, 0.0, -4.0)))],
    )  # fmt: skip
    (first, second) = from_gazebo(Thing(contacts=[contact]))
    assert first[0] == "finger|skin|0" and first[1] == (1e-3, 2e-3, 0.0) and first[2:4] == (4.0, 1e-4)
    assert math.isnan(second[2]) and second[3] == 2e-4
    got = ContactInput()
    got.take("gz", [first, second], now=0.0)
    assert np.isnan(got.at(0.0, 1.0, 1.0)[0].force).tolist() == [False, True]
