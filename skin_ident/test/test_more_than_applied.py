"""A taxel that reads more than what presses on it is an error of data, or of a calibration; whatever a skin can do is not."""

from dataclasses import replace

import numpy as np
import pytest
from test_faults import SKIN, session

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.telemetry.more_than_applied import find_more_than_applied
from skin_ident.criticism.telemetry.odd_session import put_right
from skin_ident.criticism.vocabulary import MORE_THAN_APPLIED
from skin_ident.recordings.declared import Declared
from skin_models.signals import motion

SHALLOW, DEEP = 4.0, 8.0  # of the usual strokes, of which nearly half is in the air
RIVALS = {("gain_error", "load_cell"), ("gain_error", "taxel"), ("data_error", "taxel")}


def sessions(change=lambda r: r, count=3):
    """Sessions with one taxel."""
    return [change(replace(r, taxels=r.taxels[:1], taxel_names=(), taxel_units=())) for r in map(session, range(count))]


def exchanged(r):
    return replace(r, force=r.taxels[0], taxels=r.force[None])


def kilograms(r):
    return replace(r, force=r.force / 9.80665)


def reading(factor):
    return lambda r: replace(r, taxels=factor * r.taxels)


def share():
    r = session(0)
    return float(np.polyfit(r.force, r.taxels[0], 1)[0])


@pytest.mark.parametrize(("change", "said"), [(exchanged, "exchanged"), (kilograms, "kilograms-force")])
def test_what_no_skin_does_is_said_with_what_would_explain_it(change, said):
    (symptom,) = find_more_than_applied(sessions(change))
    assert (symptom.cause, symptom.where, symptom.evidence["kind"]) == ("data_error", "load_cell", MORE_THAN_APPLIED)
    assert set(symptom.alternatives) == RIVALS and said in symptom.evidence["why"]
    expected = 1.0 / share() if change is exchanged else 9.80665 * share()
    assert symptom.parameters["ratio"]["value"] == pytest.approx(expected, rel=0.03)


def test_of_several_taxels_another_may_leak_into_the_one_that_reads_too_much():
    loud = np.array([[1.2 / share()], [1.0]])
    made = [replace(r, taxels=loud * r.taxels[:2], taxel_names=(), taxel_units=()) for r in map(session, range(3))]
    (symptom,) = find_more_than_applied(made)
    assert ("crosstalk", "taxel_0") in symptom.alternatives and symptom.channels == ("force", "taxel_0")


@pytest.mark.parametrize("change", [lambda r: r, reading(1.05 / share())])
def test_a_skin_may_lead_all_of_the_force_through_a_taxel(change):
    assert not find_more_than_applied(sessions(change))


def test_a_session_alone_is_no_proof_and_known_units_are_not_asked():
    odd = [exchanged(r) if i == 1 else r for i, r in enumerate(sessions())]
    assert not find_more_than_applied(odd)
    assert not find_more_than_applied(sessions(kilograms), ("force",))


def test_volts_and_counts_are_no_newtons():
    volts = sessions(lambda r: replace(r, taxels=9.0 * r.taxels, taxel_units=("V",)))
    counts = sessions(lambda r: replace(r, taxels=np.round(9.0 * r.taxels), declared=replace(r.declared, taxel_step_n=(1.0,))))
    assert not find_more_than_applied(volts) and not find_more_than_applied(counts)


def test_it_is_the_finding_and_what_may_be_so_is_not_excluded():
    findings = diagnose(sessions(exchanged)).findings
    assert [(f["cause"], f["where"]) for f in findings["findings"]] == [("data_error", "load_cell")]
    assert {(a["cause"], a["where"]) for a in findings["findings"][0]["alternatives"]} == RIVALS
    assert not {"data_error", "gain_error"} & {e["cause"] for e in findings["excluded"]} and findings["verdict"] != "nothing_wrong"


def test_steps_of_a_converter_prove_the_unit_which_is_then_put_right():
    def rounded(r):
        force = np.round(r.force / 0.05) * 0.05 / 9.80665
        written = np.array([float(f"{y:.6g}") for y in force])
        return replace(r, force=written, declared=replace(r.declared, force_step_n=0.05))

    right, (symptom,) = put_right(sessions(rounded))
    assert symptom.parameters["factor"]["value"] == pytest.approx(1.0 / 9.80665) and "judged divided" in symptom.evidence["why"]
    assert np.allclose(right[0].force, session(0).force, atol=0.026) and not find_more_than_applied(right)


def test_a_mass_that_weighs_on_the_load_cell_in_contact_alone_is_none_of_it():
    skin = replace(SKIN, dispersion=replace(SKIN.dispersion, m=0.25, k1=2619.0, k2=1346.0), shares=(1.0,))

    def heavy(scale):
        def pressed(r):
            depth = scale * (r.depth - 0.45e-3)
            out = skin.simulate(motion(r.t, depth))
            return replace(r, depth=depth, force=out.force, taxels=out.taxels)

        return pressed

    recordings = [*sessions(heavy(DEEP)), replace(sessions(heavy(SHALLOW))[0], name="shallow")]
    assert recordings[0].force.min() < -1.0  # as heavy as much of the load
    assert not find_more_than_applied(recordings[3:]) and not put_right(recordings)[1]


@pytest.mark.parametrize(("level", "noise"), [(1.0, False), (5.0, True)], ids=["as quiet as kilograms-force", "quieter still"])
def test_a_load_cell_as_quiet_as_numbers_in_another_unit_has_no_noise_of_its_own(level, noise):
    """Noise of 30 mN, written in kilograms-force, is a tenth of what is declared: that is the unit, and no finding beside it."""
    declared = Declared(force_noise_n=0.03 * level)
    found = diagnose([replace(kilograms(r), declared=declared) for r in sessions()]).findings["findings"]
    assert [f["cause"] for f in found] == ["data_error", "noise"][: 1 + noise]
    assert ("as numbers in kilograms-force are" in found[0]["evidence"]["why"]) != noise
