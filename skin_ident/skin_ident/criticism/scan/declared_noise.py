"""Compares the noise of the readings with the noise that rig.yaml declares."""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.scan.fault import Fault
from skin_ident.criticism.scan.faults import Looked
from skin_ident.criticism.scan.search import Search
from skin_ident.criticism.telemetry.symptom import quantity
from skin_ident.recordings.declared import Declared

LOUDER = 1.5  # times the declared noise


def declared_noise(looked: Looked, found: Search, declared: Declared) -> Looked:
    """`looked` with one more fault where the noise, the converter's steps subtracted, is more than LOUDER times the declared one."""
    said = declared.of_taxel("taxel_noise_n", 0)
    n = found.noise.noise
    own = float(np.sqrt(max(n.sigma**2 + np.mean((n.relative * n.through) ** 2) - looked.floor**2, 0.0)))
    if not said or own < LOUDER * said:
        return looked
    why = f"the readings scatter by {own:.2g} N beside their steps, {own / said:.2g} times what rig.yaml declares"
    fault = Fault("noise", "taxel", why, np.zeros(len(looked.every), bool), {"noise": quantity(own, "N"), "declared": quantity(said, "N")})
    return replace(looked, faults=(*looked.faults, fault))
