"""The register of everything that can be hidden: cause, where, form."""

from dataclasses import dataclass

from . import hidden_contact, hidden_record, hidden_rig, hidden_sensor, hidden_skin, hidden_unknown

SENSORS = ("load_cell", "taxel_0")
PLACES = {
    "nonlinear_stiffness": ("skin",), "stress_relaxation": ("skin",), "rate_dependence": ("skin",),
    "hysteresis": ("skin", "taxel_0", "load_cell"), "cyclic_softening": ("skin",), "adhesion": ("skin",),
    "dead_zone": ("skin", "taxel_0"), "friction": ("rig", "load_cell"), "position_offset": ("rig",),
    "mount_compliance": ("rig",), "backlash": ("rig",), "off_centre": ("rig",), "inertia": ("rig",),
    "gain_error": SENSORS, "force_offset": SENSORS, "drift": SENSORS, "saturation": SENSORS,
    "quantization": (*SENSORS, "rig"), "lag": SENSORS, "time_shift": ("clock",), "crosstalk": ("taxel",),
    "interference": SENSORS, "outliers": (*SENSORS, "rig"), "dead_taxel": ("taxel_0",), "noise": SENSORS,
    "data_error": ("load_cell",), "parameters": ("skin",), "unknown": ("skin", "load_cell"),
}  # fmt: skip
NEEDS_ARRAY = ("off_centre", "crosstalk")  # with one taxel they cannot show
# Names that an honest critic may give beside or instead of the truth, whatever the protocol: the same equations, or nearly so.
RIVALS = {
    "mount_compliance": ("stress_relaxation", "nonlinear_stiffness", "parameters"),
    "dead_zone": ("position_offset", "force_offset", "nonlinear_stiffness"),
    "adhesion": ("force_offset",),
    "position_offset": ("nonlinear_stiffness", "force_offset"),
    "friction": ("hysteresis",),
    "cyclic_softening": ("hysteresis", "drift"),
}


ONLY_ASKED = ("pressed", "slack_encoder", "dragged_encoder", "averaged")  # not drawn: with them, earlier seeds would hide something else


@dataclass(frozen=True)
class Hide:
    """One thing to hide. `form` None: drawn. `size`: visible RMS over noise RMS in the channel that shows it best."""

    cause: str
    where: str | None = None
    form: str | None = None
    size: float = 1.0


def forms(cause, where=None) -> dict:
    """Builders by form name. Raises KeyError for a cause without any."""
    sensor = where is not None and (where.startswith("taxel") or where == "load_cell")
    tables = [hidden_skin, hidden_contact, hidden_rig, hidden_record, hidden_unknown]
    tables.insert(0 if sensor else len(tables), hidden_sensor)
    for table in tables:
        if cause in table.FORMS:
            return table.FORMS[cause]
    raise KeyError(f"no hidden cause called {cause!r}; there are {sorted(PLACES)}")


def complete(hide, rng) -> Hide:
    """The same with place and form drawn where they were left open."""
    where = hide.where or str(rng.choice(PLACES[hide.cause]))
    form = hide.form or str(rng.choice([f for f in forms(hide.cause, where) if f not in ONLY_ASKED]))
    return Hide(hide.cause, where, form, hide.size)


def build(hide, context):
    """The `Effect` of a completed `Hide`."""
    return forms(hide.cause, hide.where)[hide.form](context)
