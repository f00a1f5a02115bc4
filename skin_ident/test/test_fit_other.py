"""`fit --what`: spectra, calibrations and stiffnesses as a user meets them."""

import json
from dataclasses import replace

import numpy as np
import pytest
from making import KINDS, noise, recording, serialised, typestore, write_table

from skin_ident.cli.fit import main
from skin_ident.recordings.declared import declared_from
from skin_ident.recordings.load import load
from skin_models.model_file import load_model
from skin_testbed_driver.bag import BagWriter, TopicInfo


def written(tmp_path, *arguments):
    assert main([*map(str, arguments), "--out", str(tmp_path / "out")]) == 0
    return json.loads((tmp_path / "out" / "fit.json").read_text())


def test_a_spectrum_without_relaxation_has_no_arm(tmp_path, capsys):
    found = written(tmp_path, write_table(tmp_path / "a.csv", recording(n=1500)), "--what", "prony")
    said = capsys.readouterr().out
    assert found["arms"] == [] and "relaxation spectrum, 0 arms" in said and "k at rest" in said
    assert found["stiffness"]["force"][0] == pytest.approx(12385, rel=0.01)
    assert load_model(tmp_path / "out" / "model.yaml").dispersion.k1 == pytest.approx(9619, rel=0.01)


def test_a_calibration_is_printed_as_rig_yaml_takes_it(tmp_path, capsys):
    force = np.repeat(np.r_[0:20, 20:-1:-1] * 2.0, 100)
    volts = force / 9.4 + 0.31 + noise(np.random.default_rng(0), force.size, 0.01)
    rows = zip(force.tolist(), volts.tolist(), strict=True)
    path = tmp_path / "stairs.csv"
    path.write_text("t_s,force_n,ai1_v\n" + "".join(f"{0.01 * i},{f},{v}\n" for i, (f, v) in enumerate(rows)))
    line = written(tmp_path, path, "--what", "calibration")["calibration"]["ai1"]
    said = capsys.readouterr().out
    declared = declared_from(said[said.index("calibration:\n") :].partition("note:")[0])
    assert line["slope"] == pytest.approx(9.4, rel=0.01) and declared.calibration["ai1"].slope_n_per_v == pytest.approx(9.4, rel=0.01)


def test_the_raw_volts_beside_the_newtons_of_a_bag_are_calibrated(tmp_path, capsys):
    """As the driver records them, in the MCAP that its own writer writes."""

    def with_volts(store, i, message):
        return replace(message, voltage=message.force / 9.4 + 0.31) if hasattr(message, "voltage") else message

    r = recording(n=800, sigma=0.01)
    r = replace(r, force=r.taxels[0])
    bag, store = BagWriter(tmp_path / "session_1"), typestore()
    topics = {name: bag.add_topic(TopicInfo(name, kind, store.generate_msgdef(kind, ros_version=2)[0])) for name, kind in KINDS.items()}
    for topic, log_ns, data in serialised(r, change=with_volts):
        bag.write(topics[topic], data, log_ns, log_ns)
    bag.close()
    line = written(tmp_path, tmp_path / "session_1", "--what", "calibration")["calibration"]["taxel_0"]
    assert (line["slope"], line["zero"]) == pytest.approx((9.4, 0.31), rel=1e-3)
    assert load(tmp_path / "session_1")[0].taxel_units == ("N",)  # everywhere else newtons are read


def test_stiffness_of_every_channel(tmp_path, capsys):
    path = write_table(tmp_path / "a.csv", recording(hz=0.01, n=10_000, sigma=0.01))
    found = written(tmp_path, path, "--what", "stiffness")["stiffness"]
    assert found["force"]["slope"] == pytest.approx(12385, rel=0.01) and "N/m, zero at" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("more", "says"),
    [(["--what", "calibration"], "no taxel in volts"), (["--arms", "2"], "--what prony"), (["--what", "prony", "--arms", "9"], "between 0"),
     (["--what", "prony", "--profile"], "dispersion model"), (["--what", "stiffness", "--each"], "dispersion model")],
)  # fmt: skip
def test_what_does_not_go_together_is_refused(tmp_path, capsys, more, says):
    path = write_table(tmp_path / "a.csv", recording(n=800))
    assert main([str(path), *more, "--out", str(tmp_path / "out")]) == 2
    assert says in capsys.readouterr().err and not (tmp_path / "out").exists()
