"""Contents of findings.json as small as what they are about."""


def findings(verdict="nothing_wrong", left=0.05, floor=0.05, entries=(), train=None) -> dict:
    errors = {"force": {"train": train or left, "held_out": left, "unit": "N"}, "taxel_0": {"train": 0.02, "held_out": 0.02, "unit": "N"}}
    floors = {"force": {"rms": floor, "band_hz": 8.0}, "taxel_0": {"rms": 0.02, "band_hz": 8.0}}
    model = {"model": "dispersion", "parameters": {}, "rmse": errors}
    return {"verdict": verdict, "baseline": model, "extended": model, "noise_floor": floors, "findings": list(entries)}


def rivals(*names: tuple[str, str], **more) -> dict:
    (cause, where), *others = names
    entry = {"cause": cause, "where": where, "channels": ["force"], "parameters": {}, "evidence": {}, "gain": {}, **more}
    return entry | {"alternatives": [{"cause": c, "where": w, "explains_less_by": 3.0} for c, w in others]}
