"""Outcomes of every sort, made by simulating two models and calling the richer one the truth."""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.telling.outcome import Outcome, Round, ScanTrace, Trace
from skin_ident.thesis_spread import thesis_scan
from skin_models.catalogue import effect_class
from skin_models.dispersion import Dispersion
from skin_models.model import Model
from skin_models.parameter import parameters_of
from skin_models.signals import motion

SILICONE = Dispersion(m=0.000432, b1=939.5, k1=9619.0, b2=629.2, k2=2766.0)
RATE = 100.0


def path(seconds: float, seed: int) -> np.ndarray:
    """Depth (m): free air, holds, ramps and a sine."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, seconds, 1.0 / RATE)
    knots = np.arange(0.0, seconds + 2.0, 2.0)
    depth = np.repeat(rng.uniform(0.2e-3, 0.9e-3, knots.size // 2 + 1), 2)[: knots.size]
    depth[:2] = depth[-3:] = -0.2e-3
    wave = 0.1e-3 * np.sin(2 * np.pi * 0.7 * t) * ((t > 0.4 * seconds) & (t < 0.7 * seconds))
    smooth = np.hanning(31) / np.hanning(31).sum()
    return np.convolve(np.pad(np.interp(t, knots, depth) + wave, 15, mode="edge"), smooth, mode="valid")


def trace(name: str, held_out: bool, truth: Model, before: Model, after: Model, seconds=60.0, seed=0, level=0.02) -> Trace:
    """One session of `truth` with noise, as two models simulate it."""
    x = path(seconds, seed)
    s = motion(np.arange(x.size) / RATE, x)
    rng = np.random.default_rng(seed + 100)

    def rows(model: Model) -> np.ndarray:
        r = model.simulate(s)
        return np.vstack([r.force, r.taxels]) if model.shares else np.atleast_2d(r.force)

    y = rows(truth)
    channels = ("force", *(f"taxel_{i}" for i in range(len(truth.shares))))
    return Trace(name, held_out, s.t, s.x, s.v, channels, y + level * rng.standard_normal(y.shape), rows(before), rows(after))


def fitted(truth: Model, seeds, seconds=60.0) -> Model:
    """The plain model that fits `truth` best by least squares (thesis eqs 27 and 28): what a missing effect does to it."""
    rows, forces, taxels = [], [], []
    for seed in seeds:
        x = path(seconds, seed)
        s = motion(np.arange(x.size) / RATE, x)
        r = truth.simulate(s)
        rows.append(np.array([s.v, s.x]).T * (s.x > 0)[:, None])
        forces.append(r.force)
        taxels.append(r.taxels[0] if truth.shares else 0.0 * r.force)
    (b, k), (b1, k1) = (np.linalg.lstsq(np.concatenate(rows), np.concatenate(y), rcond=None)[0] for y in (forces, taxels))
    return Model(Dispersion(m=truth.dispersion.m, b1=b1, k1=max(k1, 0.0), b2=b - b1, k2=k - k1), truth.shares)


def parameters(thing, spread=0.01) -> dict:
    return {p.name: {"value": p.value, "unit": p.unit, "std": abs(p.value) * spread} for p in parameters_of(thing)}


def errors(traces, which) -> dict:
    """rmse entries of findings.json."""

    def size(c, held) -> float | None:
        left = [(t.measured - getattr(t, which))[c] for t in traces if t.held_out == held]
        return float(np.sqrt(np.mean(np.concatenate(left) ** 2))) if left else None

    return {c: {"train": size(i, False), "held_out": size(i, True), "unit": "N"} for i, c in enumerate(traces[0].channels)}


def finding(effect, before: float, after: float, channels, alternatives=(), separating="") -> dict:
    step = before - after
    return {
        "cause": effect.cause, "where": effect.where, "channels": list(channels), "parameters": parameters(effect),
        "evidence": {"log_likelihood_ratio": 812.4, "explained_share": 0.93, "margin_over_next": 402.0},
        "gain": {"held_out_rmse_before": before, "held_out_rmse_after": after, "ci95": [0.9 * step, 1.1 * step]},
        "alternatives": list(alternatives), "separating_experiment": separating,
    }  # fmt: skip


EXCLUDED = [
    {"cause": "backlash", "where": "rig", "below": 1.3e-5, "unit": "m"},
    {"cause": "friction", "where": "rig", "below": 0.0123, "unit": "N"},
    {"cause": "lag", "where": "taxel", "below": 0.0042, "unit": "s"},
    {"cause": "gain_error", "where": "taxel_0", "below": 0.012, "unit": "1"},
    {"cause": "nonlinear_stiffness", "where": "skin", "below": 3.2e8, "unit": "N/m^3"},
]  # fmt: skip
UNTESTABLE = [
    {"cause": "off_centre", "where": "rig", "because": "there is only one taxel", "needs": "three or more taxels, or a lateral scan"},
    {"cause": "mount_compliance", "where": "rig", "because": "it equals a lower stiffness", "needs": "a press on a rigid target"},
]  # fmt: skip


def outcome(verdict, traces, findings, before: Model, after: Model, rounds=(), **more) -> Outcome:
    floor = {c: {"value": 0.02, "unit": "N"} for c in traces[0].channels}
    labelled = {f"{e.cause}.{e.where}.{k}": p for e in after.effects for k, p in parameters(e).items()}
    content = {
        "schema": 1, "recordings": [{"name": t.session, "samples": t.t.size, "held_out": t.held_out} for t in traces],
        "baseline": {"model": "dispersion", "parameters": parameters(before.dispersion), "rmse": errors(traces, "baseline")},
        "findings": findings, "excluded": EXCLUDED, "untestable": UNTESTABLE,
        "extended": {"model": "extended", "parameters": {**parameters(after.dispersion), **labelled}, "rmse": errors(traces, "extended")},
        "noise_floor": floor, "verdict": verdict, **more,
    }  # fmt: skip
    return Outcome(content, before, after, {}, tuple(traces), (), tuple(rounds))


def effect(cause, where, **values):
    return effect_class(cause, where).typical(where, **values)


RELAXATION_ROUND = Round(
    (("stress_relaxation", "skin", 9120.0), ("hysteresis", "skin", 4410.0), ("rate_dependence", "skin", 2210.0), ("lag", "taxel", 1402.0),
     ("cyclic_softening", "skin", 800.0), ("friction", "rig", 330.0), ("drift", "load_cell", 61.0)), "stress_relaxation",
)  # fmt: skip
LAST_ROUND = Round((("drift", "taxel", 14.2), ("time_shift", "clock", 9.1), ("interference", "load_cell", 6.4)), None)


def explained(taxels=1) -> Outcome:
    """Stress relaxation, found."""
    shares = tuple(np.exp(-((np.arange(taxels) * 1.5 / 5.25) ** 2)))
    relaxation = effect("stress_relaxation", "skin", tau=0.8)
    truth = Model(SILICONE, shares, (relaxation,))
    before = fitted(truth, (1, 2))
    traces = [trace("battery_1", False, truth, before, truth, seed=1), trace("battery_2", False, truth, before, truth, seed=2),
              trace("battery_3", True, truth, before, truth, 75.0, seed=3)]  # fmt: skip
    b, a = errors(traces, "baseline")["force"], errors(traces, "extended")["force"]
    f = finding(relaxation, b["held_out"], a["held_out"], traces[0].channels)
    return outcome("explained", traces, [f], before, truth, (RELAXATION_ROUND, LAST_ROUND))


def nothing_wrong() -> Outcome:
    truth = Model(SILICONE)
    traces = [trace(f"session_{i}", i == 2, truth, truth, truth, seed=i) for i in range(3)]
    return outcome("nothing_wrong", traces, [], truth, truth, (LAST_ROUND,))


def ambiguous() -> Outcome:
    """A loop at a single rate: two names and an experiment."""
    loop = effect("hysteresis", "skin")
    truth = Model(SILICONE, (1.0,), (loop,))
    before = fitted(truth, (4,))
    traces = [trace("triangles_a", False, truth, before, truth, seed=4), trace("triangles_b", True, truth, before, truth, seed=5)]
    b, a = errors(traces, "baseline")["taxel_0"], errors(traces, "extended")["taxel_0"]
    rivals = [{"cause": "stress_relaxation", "where": "skin", "short_by": 3.2}, {"cause": "lag", "where": "taxel", "short_by": 7.9}]
    run = "hold at 0.8 mm for 10 s after a 4 mm/s ramp (battery separating.yaml); expected log-likelihood ratio 240"
    f = finding(loop, b["held_out"], a["held_out"], ("taxel_0", "force"), rivals, run)
    ranked = (("hysteresis", "skin", 5210.0), ("stress_relaxation", "skin", 5207.0), ("lag", "taxel", 5202.0), ("friction", "rig", 900.0))
    return outcome("partly_explained", traces, [f], before, truth, (Round(ranked, "hysteresis"), LAST_ROUND))


def unexplained() -> Outcome:
    odd = effect("stress_relaxation", "skin", tau=8.0)
    truth = Model(SILICONE, (1.0,), (odd, effect("hysteresis", "skin")))
    before = fitted(truth, (4,))
    traces = [trace("one", False, truth, before, before, seed=4), trace("two", True, truth, before, before, seed=5)]
    return outcome("unexplained", traces, [], before, before, (Round((("drift", "skin", 31.0),), None),))


def one_session_material_test() -> Outcome:
    """Depth and force, no taxel, nothing held out."""
    curve = effect("nonlinear_stiffness", "skin")
    truth = Model(SILICONE, (), (curve,))
    before = fitted(truth, (7,), 20.0)
    traces = [trace("tensile_tester", False, truth, before, truth, 20.0, seed=7)]
    b, a = errors(traces, "baseline")["force"], errors(traces, "extended")["force"]
    f = finding(curve, b["train"], a["train"], ("force",))
    f["gain"] = {"held_out_rmse_before": None, "held_out_rmse_after": None, "ci95": None}
    return outcome("explained", traces, [f], before, truth, (Round((("nonlinear_stiffness", "skin", 88210.0),), "nonlinear_stiffness"),))


MANY = (
    ("stress_relaxation", "skin"),
    ("nonlinear_stiffness", "skin"),
    ("hysteresis", "skin"),
    ("friction", "rig"),
    ("gain_error", "taxel_2"),
    ("dead_taxel", "taxel_3"),
)


def six_findings() -> Outcome:
    """Four taxels, six causes, long names, warnings."""
    shares = (1.0, 0.8, 0.5, 0.2)
    effects = tuple(effect(c, w) for c, w in MANY)
    truth = Model(SILICONE, shares, effects)
    before = fitted(truth, range(6), 45.0)
    names = [
        f"2014-03-11T16-22-05_silicone_shore_00-30_thickness_4mm_plunger_8mm_operator_{i}_a_name_that_nobody_would_type" for i in range(8)
    ]
    traces = [trace(n, i > 5, truth, before, truth, 45.0, seed=i) for i, n in enumerate(names)]
    b, a = errors(traces, "baseline"), errors(traces, "extended")
    found = [finding(e, b["taxel_2"]["held_out"], a["taxel_2"]["held_out"], ("taxel_2", "force")) for e in effects]
    rounds = [Round(tuple((c, w, 9000.0 / (j + 1) ** 1.5) for j, (c, w) in enumerate(MANY[i:])), MANY[i][0]) for i in range(len(MANY))]
    warnings = ["battery_1: 12 repeated stamps were dropped", "taxel_3 reads the same value in 4120 of 4500 samples <b>not markup</b>"]
    return outcome("partly_explained", traces, found, before, truth, (*rounds, LAST_ROUND), warnings=warnings)


def spread_scan() -> Outcome:
    """Thesis Table 4-10 against one Gaussian for all depths, and against one with a flatter top."""
    scan = thesis_scan("4-10")

    def kernel(width: float, power: float) -> np.ndarray:
        shape = np.exp(-((scan.distance / width) ** power))
        return np.outer(scan.force @ shape / (shape @ shape), shape)

    before, after = kernel(4.9e-3, 2.0), kernel(5.2e-3, 2.3)
    s = ScanTrace(scan.name, scan.depth, scan.distance, scan.force, before, after)
    sizes = [float(np.sqrt(np.nanmean((scan.force - y) ** 2))) for y in (before, after)]
    fall = sizes[0] - sizes[1]
    rmse = [{"taxel_0": {"train": 0.9 * v, "held_out": v, "unit": "N"}} for v in sizes]
    f = {
        "cause": "spread_shape", "where": "skin", "channels": ["taxel_0"],
        "parameters": {"width": {"value": 5.2e-3, "unit": "m", "std": 5e-5}, "power": {"value": 2.3, "unit": "1", "std": 0.05}},
        "evidence": {"held_out_by": "depth, each in turn"},
        "gain": {"held_out_rmse_before": sizes[0], "held_out_rmse_after": sizes[1], "ci95": [0.5 * fall, 1.5 * fall]},
        "alternatives": [], "separating_experiment": None,
    }  # fmt: skip
    content = {
        "schema": 1, "recordings": [{"name": scan.name, "kind": "static spread scan"}],
        "baseline": {"model": "gaussian", "parameters": {"c": {"value": 5.25e-3, "unit": "m"}}, "rmse": rmse[0]},
        "findings": [f], "excluded": [],
        "untestable": [{"cause": "anisotropy", "because": "one direction", "needs": "lateral scans in x and in y"}],
        "extended": {"model": "gaussian", "parameters": {}, "rmse": rmse[1]},
        "noise_floor": {"taxel_0": 0.01}, "verdict": "partly_explained",
    }  # fmt: skip
    return Outcome(content, scans=(s,))


def seen_in_the_record() -> Outcome:
    """A dead taxel and coarse steps: faults that need no model, in sessions held out in turn."""
    truth = Model(SILICONE, (1.0, 0.4))
    traces = [trace(f"press_{i}", False, truth, truth, truth, 30.0, seed=i) for i in range(2)]

    def symptom(cause: str, where: str, channel: str, why: str, **more) -> dict:
        gain = {"held_out_rmse_before": None, "held_out_rmse_after": None, "ci95": [0.0, 0.0], "channel": channel}
        return {
            "cause": cause, "where": where, "channels": [channel], "parameters": more, "evidence": {"why": why, "stuck": True},
            "gain": gain, "alternatives": [], "separating_experiment": "",
        }  # fmt: skip

    found = [
        symptom("dead_taxel", "taxel_1", "taxel_1", "taxel_1 holds one value throughout"),
        symptom(
            "quantization",
            "load_cell",
            "force",
            "the levels of force are 5.0 times as far apart as declared",
            step={"value": 0.05, "unit": "N"},
        ),
    ]
    result = outcome("explained", traces, found, truth, truth, (LAST_ROUND,))
    arm = {
        "cause": "stress_relaxation",
        "where": "skin",
        "parameter": "k_sensed",
        "below": 41.0,
        "unit": "N/m",
        "at": {"tau": {"value": 0.5, "unit": "s"}},
    }
    seen = {"cause": "outliers", "below": None, "unit": "", "because": "looked for and not seen"}
    return replace(result, findings={**result.findings, "excluded": [arm, seen] * 9})


EXAMPLES = {
    f.__name__: f
    for f in (
        explained, nothing_wrong, ambiguous, unexplained, one_session_material_test, six_findings, spread_scan, seen_in_the_record,
    )
}  # fmt: skip
