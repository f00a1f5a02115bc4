"""Which ranked causes are refitted before one is chosen."""

from types import SimpleNamespace

from skin_ident.criticism.search.shortlist import LONGEST, SHORTLIST, shortlisted


def cause(name: str, score: float) -> SimpleNamespace:
    return SimpleNamespace(cause=name, where="skin", key=(name, "skin"), score=score)


def listed(ranked, ruled_out=(), known=(), suspected=(), count=1000) -> list[str]:
    """Names in the order of the list, where a refit keeps what the ranking promised."""

    def tried(causes):
        return (SimpleNamespace(ranked=r, key=r.key, score=r.score) for r in causes if r.cause not in ruled_out)

    keys = ({(name, "skin") for name in names} for names in (known, suspected))
    return [t.ranked.cause for t in shortlisted(ranked, tried, *keys, count)]


def test_the_best_few_are_tried_and_none_that_explains_far_less():
    ranked = [cause(f"c{i}", 100.0 - i) for i in range(2 * LONGEST)] + [cause("far", 10.0)]
    assert listed(ranked) == [f"c{i}" for i in range(SHORTLIST)]


def test_more_are_tried_where_the_best_explains_many_times_the_noise():
    ranked = [cause(f"c{i}", 1000.0 - i) for i in range(2 * LONGEST)]
    assert listed(ranked, count=50) == [f"c{i}" for i in range(LONGEST)]
    assert listed(ranked, count=500) == [f"c{i}" for i in range(SHORTLIST)]


def test_those_that_rank_next_are_tried_where_physics_rules_out_all_that_rank_highest():
    ranked = [cause("no skin does this", 1000.0), cause("sensor", 100.0), cause("other", 90.0), cause("far", 20.0)]
    assert listed(ranked, ruled_out={"no skin does this"}) == ["sensor", "other"]
    assert listed(ranked) == ["no skin does this"]
    assert listed(ranked[:1], ruled_out={"no skin does this"}) == []


def test_what_physics_rules_out_is_no_measure_of_the_others():
    ranked = [cause("no skin does this", 160.0), cause("damping", 57.0), cause("play", 50.0), cause("far", 15.0)]
    assert listed(ranked, ruled_out={"no skin does this"}) == ["damping", "play"]
    assert listed(ranked) == ["no skin does this", "damping"]


def test_what_is_named_already_goes_before_a_rival_that_it_equals():
    ranked = [cause(f"c{i}", 100.0 - 0.1 * i) for i in range(6)]
    assert listed(ranked, known={"c5"})[0] == "c5"


def test_what_the_record_itself_has_shown_goes_first():
    ranked = [cause("a", 100.0), cause("b", 50.0), cause("shown", 40.0)]
    assert listed(ranked, suspected={"shown"})[0] == "shown"
    assert listed([*ranked[:2], cause("shown", 20.0)], suspected={"shown"})[0] == "a"


def test_of_causes_that_explain_as_much_the_commoner_goes_first():
    ranked = [cause("mount_compliance", 595.0), cause("nonlinear_stiffness", 594.0)]
    assert listed(ranked)[0] == "nonlinear_stiffness"
    assert listed([ranked[0], cause("nonlinear_stiffness", 580.0)])[0] == "mount_compliance"


def test_a_lag_of_the_taxels_is_tried_wherever_it_ranks_beside_taxels_that_are_late():
    late, lag = (
        SimpleNamespace(cause=c, where=w, key=(c, w), score=n)
        for c, w, n in (("time_shift", "clock_taxels", 1000.0), ("lag", "taxel", 5.0))
    )
    others = [cause(f"c{i}", 900.0 - i) for i in range(2 * LONGEST)]
    assert "lag" in listed([late, *others, lag])
    assert "lag" not in listed([others[0], late, *others[1:], lag])
    near, far = cause("sensor", 300.0), [cause("other", 290.0), cause("rest", 280.0)]
    assert listed([late, near, *far, lag], ruled_out={"time_shift", "lag"}) == ["sensor", "other", "rest"]
