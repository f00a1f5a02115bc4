"""What is written is what is read, whichever file it comes in; what is wrong is said in one sentence."""

import numpy as np
import pytest
from making import KINDS, START_NS, recording, same, serialised, typestore, write_bag, write_mcap, write_table
from rosbags.rosbag2 import StoragePlugin, Writer

from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.load import load
from skin_ident.recordings.recording import DISPLACEMENT, FORCE_TO_FORCE, MATERIAL_TEST, TAXELS_ONLY, Recording

R = recording(n=300, shares=(1.0, 0.4))


@pytest.mark.parametrize("storage", ["mcap", "sqlite3", "NONE", "LZ4", "ZSTD"])
def test_bag_gives_back_what_was_written(tmp_path, storage):
    bare = storage.isupper()
    read = load(write_mcap(tmp_path / "a.mcap", R, storage) if bare else write_bag(tmp_path / "bag", R, storage))
    assert len(read) == 1 and same(read[0], R, 1e-15) and read[0].kind == DISPLACEMENT
    assert read[0].warnings == () and read[0].taxel_names == ("taxel_0", "taxel_1") and abs(read[0].dt - 0.01) < 1e-12


def test_bare_mcap_and_folder_of_sessions(tmp_path):
    write_bag(tmp_path / "a", R)
    write_bag(tmp_path / "b", R, "sqlite3")
    write_table(tmp_path / "c.csv", R)
    write_table(tmp_path / "d.tsv", R, "\t")
    (tmp_path / "README.txt").write_text("These were recorded,\non a Monday, by me.\n")
    read = load(tmp_path)
    assert [r.name for r in read] == ["a", "b", "c.csv", "d.tsv"] and all(same(r, R, 1e-6) for r in read)
    assert same(load(tmp_path / "a" / "a.mcap")[0], R)


@pytest.mark.parametrize(
    ("header", "kind"),
    [("t_s,x_mm,force_n", MATERIAL_TEST), ("t_s,force_N,taxel_0_N", FORCE_TO_FORCE),
     ("Time (ms),Position [um],F [mN],taxel 3 (V)", DISPLACEMENT),
     ("t_s,ai0_V,ai1_V", TAXELS_ONLY)],
)  # fmt: skip
def test_headers_say_kind_and_unit(tmp_path, header, kind):
    rows = ["".join(f"{1 + 0.01 * i * (k + 1)}," for k in range(header.count(",") + 1))[:-1] for i in range(50)]
    (tmp_path / "a.csv").write_text("\n".join([header, *rows]))
    r = load(tmp_path / "a.csv")[0]
    assert r.kind == kind
    if "um" in header:
        assert r.dt == pytest.approx(1e-5) and r.depth[1] == pytest.approx(1.02e-6) and r.force[1] == pytest.approx(1.03e-3)
        assert r.taxel_units == ("V",) and "no calibration" in " ".join(r.warnings)


BAD_TABLES = {
    "empty": ("", "empty"),
    "no rows": ("t_s,x_mm,force_n\n", "no rows"),
    "no header": ("0,0,1\n" * 30, "no header"),
    "no unit": ("t_s,x,force_n\n" + "0,1,2\n" * 30, "no unit"),
    "unit of another quantity": ("t_s,x_n,force_n\n" + "0,1,2\n" * 30, "'n'"),
    "grams": ("t_s,x_mm,taxel_1_g\n" + "0,1,2\n" * 30, "write taxel_1_gf for what it weighs, or taxel_1_n (in N; 1 gf = 9.80665 mN)"),
    "grams in brackets": ("t_s,x_mm,force (g)\n" + "0,1,2\n" * 30, "write force_gf for what it weighs, or force_n"),
    "no unit after a number": ("t_s,x_mm,taxel_1_psi\n" + "0,1,2\n" * 30, "as in taxel_1_n;"),
    "no time": ("x_mm,force_n\n" + "1,2\n" * 30, "time"),
    "short rows": ("t_s,x_mm,force_n\n" + "0,1\n" * 30, "columns"),
    "rows longer than the header": ("t_s,x_mm,force_n\n" + "".join(f"{i},{0.01 * i},1,2\n" for i in range(30)), "4 columns"),
    "spaces between columns": ("t_s x_mm force_n\n" + "0 1 2\n" * 30, "not by spaces"),
    "a column of no numbers": ("t_s,x_mm,force_n\n" + "".join(f"{0.01 * i},,2\n" for i in range(30)), "x holds no number"),
    "force in volts": ("t_s,x_mm,force_v\n" + "".join(f"{0.01 * i},1,{i}\n" for i in range(30)), "volts"),
    "few": ("t_s,x_mm,force_n\n0,1,2\n0.01,1,2\n", "at least 20"),
    "metres that are millimetres": ("t_s,x_m,force_n\n" + "".join(f"{0.01 * i},{0.1 * i},{i}\n" for i in range(30)), "mm"),
    "all the same time": ("t_s,x_mm,force_n\n" + "0,1,2\n" * 30, "29 repeated time stamps"),
    "clock steps back": ("t_s,x_mm,force_n\n" + "".join(f"{0.01 * (i % 40)},1,2\n" for i in range(80)), "steps back"),
    "unknown column": ("t_s,x_mm,banana\n" + "0,1,2\n" * 30, "not known"),
    "two forces": ("t_s,x_mm,force_n,load_n\n" + "".join(f"{0.01 * i},1,2,3\n" for i in range(30)), "more than one force"),
}


@pytest.mark.parametrize("case", BAD_TABLES)
def test_bad_table_is_refused_in_one_sentence(tmp_path, case):
    text, says = BAD_TABLES[case]
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(RecordingError) as error:
        load(tmp_path / "a.csv")
    assert says in str(error.value) and "\n" not in str(error.value)


def test_cells_in_quotes_are_numbers(tmp_path):
    text = write_table(tmp_path / "a.csv", R).read_text()
    (tmp_path / "a.csv").write_text("\n".join(",".join(f'"{cell}"' for cell in line.split(",")) for line in text.splitlines()))
    assert same(load(tmp_path / "a.csv")[0], R, 1e-6)


def test_rig_yaml_calibrates_and_declares(tmp_path):
    (tmp_path / "rig.yaml").write_text("skin_thickness_mm: 4\ncalibration:\n  ai0: {channel: force, slope_n_per_v: -4.0, zero_v: 0.5}\n")
    (tmp_path / "a.csv").write_text("t_s,ai0_V,ai1_V\n" + "".join(f"{0.01 * i},{0.5 - 0.25 * (i % 7)},{i % 7}\n" for i in range(50)))
    r = load(tmp_path)[0]
    assert r.kind == FORCE_TO_FORCE and r.force[1] == pytest.approx(1.0) and r.declared.skin_thickness_mm == 4 and r.taxel_units == ("V",)


@pytest.mark.parametrize(
    ("text", "says"),
    [("skin_thickness_mm: thick", "number"), ("skin_thickness_mm: -1", "positive"), ("[1", "YAML"),
     ("calibration: {force: {slope: 3}}", "slope"), ("taxel_positions_mm: 3", "list"),
     ("taxel_positions_mm: [[0, 0], [1, 0], [2, 0]]", "has 3 positions, but the recording has 2 taxels"),
     ("taxel_positions_mm: [[0, 0], [0, 0]]", "same place"),
     ("taxel_step_n: [0.1, 0.2, 0.3]", "has 3 numbers, .*one number for all, or one for each"),
     ("skin_thickness_mm: 0.004", "cannot be less than 0.02"), ("taxel_positions_mm: [[0, 0], [0.01, 0]]", "in millimetres"),
     ("encoder_step_um: 9999", "cannot have read a travel"), ("moving_mass_kg: 1.0e+9", "cannot be more than 100"),
     ("taxel_gain_uncertainty: 3", "unit"), ("taxel_noise_n: [null, 0.05]", "taxel_noise_n: taxel 0 has no value: give every taxel"),
     ("sample_rate_hz: 1" + 400 * "0", "sample_rate_hz must be a number"), ("sample_rate_hz: .nan", "must be a number"),
     ("sample_rate_hz: 1" + 5000 * "0", "integer")],
)  # fmt: skip
def test_bad_rig_yaml(tmp_path, text, says):
    (tmp_path / "rig.yaml").write_text(text)
    write_table(tmp_path / "a.csv", R)
    with pytest.raises(RecordingError, match=says):
        load(tmp_path)


def test_a_rig_yaml_that_is_a_folder_is_refused(tmp_path):
    (tmp_path / "rig.yaml").mkdir()
    with pytest.raises(RecordingError, match=r"rig\.yaml: Is a directory"):
        load(write_table(tmp_path / "a.csv", R))


def test_a_misspelt_key_is_passed_over_and_the_known_one_said(tmp_path):
    (tmp_path / "rig.yaml").write_text("sample_rate_hzz: 100\n")
    write_table(tmp_path / "a.csv", R)
    assert "sample_rate_hzz (is sample_rate_hz meant?)" in " ".join(load(tmp_path)[0].warnings)


def test_topics_are_mapped_and_missing_ones_named(tmp_path):
    bag = write_bag(tmp_path / "bag", R)
    assert same(load(bag, {"force": "/force", "encoder": "/encoder:indentation"})[0], R)
    with pytest.raises(RecordingError, match="/encoder, /force, /taxels"):
        load(bag, {"force": "/ft"})
    with pytest.raises(RecordingError, match="JointState"):
        load(bag, {"force": "/encoder"})


def test_repairs_are_counted(tmp_path):
    lines = write_table(tmp_path / "a.csv", R).read_text().splitlines()
    lines[50] = lines[51]
    cells = lines[100].split(",")
    lines[100] = ",".join([cells[0], "nan", *cells[2:]])
    lines[150], lines[151] = lines[151], lines[150]
    (tmp_path / "a.csv").write_text("\n".join(lines))
    r = load(tmp_path / "a.csv")[0]
    said = " ".join(r.warnings)
    assert "1 repeated time stamp" in said and "1 missing number" in said and "1 sample out of order" in said
    assert len(r) == len(R) and np.max(np.abs(r.depth - R.depth)) < 1e-6


def test_long_gap_keeps_the_longest_stretch(tmp_path):
    lines = write_table(tmp_path / "a.csv", R).read_text().splitlines()
    (tmp_path / "a.csv").write_text("\n".join(lines[:101] + lines[160:]))
    r = load(tmp_path / "a.csv")[0]
    assert len(r) == len(lines) - 160 and "1 gap" in " ".join(r.warnings)


def test_force_counted_negative_in_compression_is_turned_round(tmp_path):
    r = Recording("a", R.t, R.depth, -R.force, R.taxels)
    read = load(write_table(tmp_path / "a.csv", r))[0]
    assert np.allclose(read.force, R.force, atol=1e-6) and "sign" in " ".join(read.warnings)


def test_all_loads_counted_negative_are_one_convention_and_one_warning(tmp_path):
    quiet = 1e-3 * np.random.default_rng(1).standard_normal(R.t.size)  # a taxel that feels nothing
    taxels = np.vstack([R.taxels, quiet])
    read = load(write_table(tmp_path / "a.csv", Recording("a", R.t, R.depth, -R.force, -taxels)))[0]
    assert np.allclose(read.force, R.force, atol=1e-6) and np.allclose(read.taxels, taxels, atol=1e-6)
    assert len([w for w in read.warnings if "sign of all of them" in w]) == 1 and len(read.warnings) == 1
    one = load(write_table(tmp_path / "b.csv", Recording("b", R.t, R.depth, -R.force, np.vstack([R.taxels, -R.taxels]))))[0]
    assert np.allclose(one.taxels, np.vstack([R.taxels, -R.taxels]), atol=1e-6)


def test_milliseconds_under_a_title_that_says_seconds_are_asked_about(tmp_path):
    assert not load(write_table(tmp_path / "a.csv", R))[0].warnings
    slow = load(write_table(tmp_path / "b.csv", Recording("b", 1e3 * R.t, R.depth, R.force, R.taxels)))[0]
    assert "milliseconds" in slow.warnings[0]


def test_taxels_of_a_table_are_in_the_order_of_their_numbers(tmp_path):
    rows = np.column_stack([R.t, 1e3 * R.depth, R.force, R.taxels[1], R.taxels[0]])
    path = tmp_path / "a.csv"
    np.savetxt(path, rows, "%.9g", ",", header="t_s,x_mm,force_n,taxel_1_n,taxel_0_n", comments="")
    read = load(path)[0]
    assert np.allclose(read.taxels, R.taxels, atol=1e-6) and not read.warnings
    np.savetxt(path, rows, "%.9g", ",", header="t_s,x_mm,force_n,taxel_7_n,taxel_5_n", comments="")
    read = load(path)[0]
    assert np.allclose(read.taxels, R.taxels, atol=1e-6) and "taxel_0 is taxel_5, taxel_1 is taxel_7" in read.warnings[0]


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("shown", [{}, {"taxels": np.empty((0, 0))}])
def test_a_depth_counted_away_from_the_skin_is_turned_round(tmp_path, shown, sign):
    t = np.arange(3000) / 100.0
    x = 1e-3 * np.sin(1.3 * t) - 3e-4
    force = 1500.0 * np.maximum(x, 0.0) + 0.02 * np.sin(40.0 * t)
    rows = {"force": force, "taxels": 0.6 * force[None]} | shown
    read = load(write_table(tmp_path / "a.csv", Recording("a", t, -x, **{k: sign * row for k, row in rows.items()})))[0]
    assert np.allclose(read.depth, x, atol=1e-8) and "counts away from the skin" in " ".join(read.warnings)
    assert np.allclose(read.force, force, atol=1e-6)


def test_message_and_file_compression(tmp_path):
    for mode in ("FILE", "MESSAGE"):
        assert same(load(write_bag(tmp_path / mode, R, "sqlite3", mode=mode))[0], R, 1e-15)


def test_bulk_reading_equals_rosbags(tmp_path):
    """Frames, joints and lengths that change on the way: whatever the fast way cannot read goes the slow way, and none is lost."""
    from rosbags.highlevel import AnyReader

    def varied(store, i, message):
        if i % 7 == 3:
            message.header.frame_id = "another frame"
        if i % 11 == 5 and hasattr(message, "name"):
            message.name, message.position = ["other", "indentation"], np.array([7.0, message.position[0]])
        return message

    path = write_mcap(tmp_path / "a.mcap", R, change=varied)
    with AnyReader([path]) as bag:
        slow = [(c.topic, bag.deserialize(raw, c.msgtype)) for c, _, raw in bag.messages()]
    force = [-m.wrench.force.z for topic, m in slow if topic == "/force"]
    r = load(path)[0]
    assert np.array_equal(r.force, force) and same(r, R, 1e-15)


def test_plain_types_by_name_and_by_log_time(tmp_path):
    """Float64 and Float64MultiArray say nothing of what they are: named topics, and the times at which they were recorded."""
    store = typestore()
    t = store.types
    layout = t["std_msgs/msg/MultiArrayLayout"]([], 0)
    kinds = {"/p": "std_msgs/msg/Float64", "/q": "std_msgs/msg/Float64", "/s": "std_msgs/msg/Float64MultiArray"}
    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        lines = {topic: writer.add_connection(topic, kind, typestore=store) for topic, kind in kinds.items()}
        for i in range(len(R)):
            stamp = START_NS + i * 10_000_000
            for topic, value in (("/p", R.depth[i]), ("/q", R.force[i])):
                writer.write(lines[topic], stamp, store.serialize_cdr(t[kinds[topic]](float(value)), kinds[topic]))
            many = t[kinds["/s"]](layout, R.taxels[:, i].copy())
            writer.write(lines["/s"], stamp, store.serialize_cdr(many, kinds["/s"]))
    with pytest.raises(RecordingError, match="--topics"):
        load(tmp_path / "bag", {})
    r = load(tmp_path / "bag", {"depth": "/p", "force": "/q", "taxels": "/s"})[0]
    assert same(r, R, 1e-15) and "carries no time stamps" in " ".join(r.warnings)


def test_channels_of_different_rates_meet_on_the_encoders_stamps(tmp_path):
    every = 2

    def thinned():
        for i, (topic, log, data) in enumerate(serialised(R)):
            if topic != "/taxels" or (i // 3) % every == 0:
                yield topic, log, data

    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        lines = {topic: writer.add_connection(topic, kind, typestore=typestore()) for topic, kind in KINDS.items()}
        for topic, log, data in thinned():
            writer.write(lines[topic], log, data)
    r = load(tmp_path / "bag")[0]
    assert np.allclose(r.taxels[:, ::2], R.taxels[:, : len(r) : 2]) and "taxels: interpolated" in " ".join(r.warnings)
    assert np.array_equal(r.force, R.force[: len(r)])


def test_steps_of_a_converter_are_known_where_topics_have_stamps_of_their_own(tmp_path):
    coarse = Recording("a", R.t, R.depth, R.force, np.round(R.taxels / 0.05) * 0.05)

    def late(store, i, message):
        if "TaxelArray" in type(message).__name__:
            message.header.stamp.nanosec += 3_000_000
        return message

    r = load(write_bag(tmp_path / "bag", coarse, change=late))[0]
    assert "taxels: interpolated" in " ".join(r.warnings) and r.step("force") is None
    assert [r.step("taxel_0"), r.step("taxel_1")] == pytest.approx([0.05, 0.05])


def test_log_times_on_request(tmp_path):
    """Stamps that stand still, as of a driver that never sets its clock, and good log times."""
    bag = write_mcap(tmp_path / "a.mcap", R, log_delay_ns=0, change=lambda store, i, message: frozen_stamp(message))
    with pytest.raises(RecordingError, match="log-time"):
        load(bag)
    assert same(load(bag, log_time=True)[0], R, 1e-15)


def frozen_stamp(message):
    message.header.stamp.sec, message.header.stamp.nanosec = 5, 0
    return message


def without_taxels(tmp_path, topics):
    """A bag of force and encoder, and the named topics without a message."""
    path = tmp_path / "bag"
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        lines = {topic: writer.add_connection(topic, KINDS[topic], typestore=typestore()) for topic in ("/encoder", "/force", *topics)}
        for topic, log, data in serialised(R):
            if topic != "/taxels":
                writer.write(lines[topic], log, data)
    return path


def test_an_empty_topic_makes_no_other_kind_of_test(tmp_path):
    path = without_taxels(tmp_path, ["/taxels"])
    with pytest.raises(RecordingError, match=r"/taxels holds no message; .*--topics encoder=/encoder force=/force"):
        load(path)
    r = load(path, {"force": "/force", "encoder": "/encoder"})[0]
    assert r.kind == MATERIAL_TEST and "/taxels holds no message" in " ".join(r.warnings)


def test_a_cut_off_file_without_taxels_makes_no_other_kind_of_test(tmp_path):
    path = next(without_taxels(tmp_path, []).glob("*.mcap"))
    assert load(path)[0].kind == MATERIAL_TEST
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(RecordingError, match="cut off, and what is left holds no taxels"):
        load(path)


def test_a_taxel_of_no_numbers_keeps_its_place(tmp_path):
    r = recording(n=300, shares=(1.0, 0.4, 0.3))
    r.taxels[1] = 0.0
    lines = write_table(tmp_path / "a.csv", r).read_text().splitlines()
    holes = [",".join("" if i == 4 else cell for i, cell in enumerate(line.split(","))) for line in lines[1:]]
    (tmp_path / "a.csv").write_text("\n".join([lines[0], *holes]))
    read = load(tmp_path / "a.csv")[0]
    assert read.taxel_names == ("taxel_0", "taxel_1", "taxel_2") and not read.taxels[1].any()
    assert np.allclose(read.taxels[2], r.taxels[2]) and "taxel_1: most of its samples are no numbers" in " ".join(read.warnings)
    holes = [",".join("" if i > 2 else cell for i, cell in enumerate(line.split(","))) for line in lines[1:]]
    (tmp_path / "a.csv").write_text("\n".join([lines[0], *holes]))
    with pytest.raises(RecordingError, match="every taxel is dead"):
        load(tmp_path / "a.csv")


def test_a_file_named_in_capitals_is_the_same(tmp_path):
    write_mcap(tmp_path / "a.mcap", R).rename(tmp_path / "RUN.MCAP")
    assert same(load(tmp_path)[0], R, 1e-15)


def test_a_rig_description_is_read_as_people_mean_it(tmp_path):
    write_table(tmp_path / "a.csv", R)
    (tmp_path / "rig.yaml").write_text("moving_mass_kg: 4e-4\n")
    assert load(tmp_path)[0].declared.moving_mass_kg == pytest.approx(4e-4)
    (tmp_path / "rig.yaml").write_text("skin_thickness_mm: 4\nskin_thickness_mm: 6\n")
    with pytest.raises(RecordingError, match="stands twice"):
        load(tmp_path)
