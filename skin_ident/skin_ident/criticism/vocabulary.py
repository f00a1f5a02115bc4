"""The vocabulary of findings: the name of each cause and place, what a cause means, what to do about it, and which experiment would show
it.

Names and meanings are fixed: reports, tests and other people's tools rely on them.
"""

from dataclasses import dataclass

Key = tuple[str, str]  # a cause and its place
SENSORS = ("load_cell", "taxel")  # beginnings of the places of sensors

# Causes that other code refers to, wherever they are.
FORCE_OFFSET, POSITION_OFFSET, GAIN_ERROR, DEAD_ZONE = "force_offset", "position_offset", "gain_error", "dead_zone"
# A tone may explain part of the residual, but it is looked for at full rate (`telemetry.lines`) and not named by the search: of one above
# the common band only its alias is left, a slow wave or a constant.
AT_FULL_RATE = "interference"

# Causes at their places that rules of physics refer to: those of the skin, those of other places, and those of the load cell.
PARAMETERS, DAMPING, STIFFER = ("parameters", "skin"), ("rate_dependence", "skin"), ("nonlinear_stiffness", "skin")
HYSTERESIS, RELAXATION, ADHESION = ("hysteresis", "skin"), ("stress_relaxation", "skin"), ("adhesion", "skin")
ZERO_OF_DEPTH, LATE_DEPTH, PLAY = ("position_offset", "rig"), ("time_shift", "clock_depth"), ("backlash", "rig")
LATE_TAXELS, LAG_OF_TAXELS, LEAKS = ("time_shift", "clock_taxels"), ("lag", "taxel"), ("crosstalk", "taxel")
ZERO_OF_LOAD_CELL, GAIN_OF_LOAD_CELL = ("force_offset", "load_cell"), ("gain_error", "load_cell")
CREEP_OF_LOAD_CELL, LAG_OF_LOAD_CELL, LOOP_OF_LOAD_CELL = ("drift", "load_cell"), ("lag", "load_cell"), ("hysteresis", "load_cell")
CEILING_OF_LOAD_CELL, FRICTION_OF_LOAD_CELL = ("saturation", "load_cell"), ("friction", "load_cell")

# Kinds of `data_error` that other code refers to.
EXCHANGED, SWAPPED = "exchanged columns", "swapped columns"  # for a while, or by taxel positions; in whole sessions
UNIT_FACTOR, UNIT_CHANGE = "unit factor", "unit change"  # throughout a session; from some moment on
MORE_THAN_APPLIED = "more than applied"  # the taxels feel more than presses on them


@dataclass(frozen=True)
class Cause:
    """`means` completes "the simulation lacks …"; `act` is the advice; `needs` is the experiment that excites the cause. `instead` is the
    part of the advice that holds if the extended model does not simulate the cause; "" if all of `act` does."""

    name: str
    means: str
    act: str
    needs: str
    instead: str = ""


def verdict_of(anything: bool, systematic: bool) -> str:
    """The verdict, from whether `anything` was found and whether something `systematic` is left."""
    if anything:
        return "partly_explained" if systematic else "explained"
    return "unexplained" if systematic else "nothing_wrong"


def revised(verdict: str, anything: bool, more: bool = False) -> str:
    """A verdict updated: whether `anything` is found in the end, and whether `more` is left than the verdict knew."""
    return verdict_of(anything, more or verdict in ("partly_explained", "unexplained"))


CAUSES: tuple[Cause, ...] = (
    Cause(
        "parameters",
        "the structure is right, the numbers of the given model are wrong",
        "use the refitted parameters",
        "a given model (--model) to compare with",
    ),
    Cause(
        "nonlinear_stiffness",
        "force is not proportional to depth",
        "use the extended model; keep the linear one only within the depth it was fitted on",
        "a slow sweep over the whole depth",
    ),
    Cause(
        "stress_relaxation",
        "force decays while the depth is held",
        "use the Prony terms of the extended model; calibrate static loads after the longest time constant",
        "holds of several seconds at depth",
    ),
    Cause(
        "rate_dependence",
        "damping is not proportional to speed",
        "use the extended model where speeds vary",
        "the same path at three or more speeds, each ten times the one before",
    ),
    Cause(
        "hysteresis",
        "loading and unloading follow different curves at any speed",
        "compensate with the fitted operator, or read only while loading",
        "loops of several amplitudes at two or more speeds",
    ),
    Cause(
        "cyclic_softening",
        "the first cycle to a new depth is stiffer than the next",
        "pre-cycle the skin to its full depth before use",
        "cycles on a fresh specimen that go deeper step by step, each repeated",
    ),
    Cause(
        "adhesion",
        "the skin pulls on the plunger while it leaves",
        "powder (talc) or lubricate the surface, or use the extended model near contact",
        "slow and fast withdrawals until the plunger is out of contact",
        "powder (talc) or lubricate the surface",
    ),
    Cause(
        "dead_zone",
        "nothing is transmitted below a threshold",
        "preload the taxel, or accept that it does not sense smaller forces",
        "light touches around the onset of contact",
    ),
    Cause(
        "friction",
        "the force steps with the sign of the speed",
        "look for rubbing of the plunger, its guide or the cable",
        "reversals at constant speed, in the air too",
    ),
    Cause("position_offset", "the zero of depth is not the surface", "zero at contact again", "approaches from the air into contact"),
    Cause(
        "mount_compliance",
        "the encoder moves further than the plunger's tip",
        "stiffen the mount, or subtract force divided by its stiffness from the depth",
        "a press on a rigid target, or skins of two thicknesses on the same mount",
    ),
    Cause(
        "backlash",
        "depth is lost at every reversal",
        "preload the stage, look for slack between encoder and plunger, or always approach from the same side",
        "reversals in contact with small and large strokes",
    ),
    Cause(
        "off_centre",
        "contact is not where it was declared to be",
        "centre the plunger over the taxel again, and put the stage's axes along the array's",
        "three or more taxels with known positions, or a lateral scan",
    ),
    Cause(
        "inertia",
        "a real mass moves between load cell and skin",
        "weigh plunger and adapter, and subtract their inertia",
        "quick motion in the air",
    ),
    Cause(
        "gain_error",
        "the slope of a calibration is wrong, or changed during the recording",
        "calibrate this sensor again",
        "a known load, or the same press at start and end of the session",
    ),
    Cause("force_offset", "the reading has a constant bias", "tare the sensor in the air", "free air before and after"),
    Cause(
        "drift",
        "the zero, the gain or the reading under load creeps with time",
        "warm up, tare often, or model the drift",
        "free air before and after, and long holds",
    ),
    Cause(
        "saturation",
        "the reading is clipped at a greatest value",
        "stay below this level, or extend the range of the sensor",
        "a press beyond the largest force of interest",
    ),
    Cause(
        "quantization",
        "steps are coarser than declared, or than the noise",
        "check range and resolution of the converter",
        "declared steps in rig.yaml (force_step_n, taxel_step_n, encoder_step_um)",
    ),
    Cause(
        "lag",
        "the sensor follows with a lag",
        "remove the filter, or undo the lag before using fast signals",
        "sinusoids or a multisine up to a few Hz",
    ),
    Cause(
        "time_shift",
        "a channel is late, or its clock runs at another rate",
        "synchronise the clocks, or shift the channel by what was found",
        "quick motion at the start and at the end",
    ),
    Cause(
        "crosstalk",
        "a taxel repeats its neighbour beyond what the spread explains",
        "check wiring and multiplexer",
        "two or more taxels, loaded one at a time",
    ),
    Cause(
        "interference",
        "a periodic disturbance, often aliased mains hum (50 or 60 Hz)",
        "shield, or filter before sampling",
        "half a minute of any recording",
    ),
    Cause("outliers", "spikes, drop-outs or frozen samples", "check cables and driver", "any recording"),
    Cause("dead_taxel", "a taxel is stuck or open-circuit", "replace the taxel, or leave it out", "presses that reach every taxel"),
    Cause(
        "noise",
        "the noise is not what was declared",
        "look for its source before trusting small signals",
        "declared noise levels in rig.yaml (force_noise_n, taxel_noise_n, encoder_noise_um)",
    ),
    Cause("spread_width", "the Gaussian is the right shape with the wrong width", "use the fitted width", "a lateral scan"),
    Cause("spread_shape", "the spread is not a Gaussian", "use the fitted kernel", "a lateral scan with at least six distances"),
    Cause(
        "spread_depth",
        "the width of the spread changes with depth",
        "use the depth-dependent width",
        "lateral scans at three or more depths",
    ),
    Cause("anisotropy", "the width of the spread differs by direction", "use a width per direction", "lateral scans in x and in y"),
    Cause("data_error", "the record itself is wrong", "record again; do not fit this", "any recording"),
)

BY_NAME = {c.name: c for c in CAUSES}

PLACES = {
    "skin": "the skin",
    "rig": "the rig",
    "load_cell": "the load cell",
    "taxel": "all taxels alike",
    "taxel_alone": "the taxel",
    "clock": "the clock",
    "clock_taxels": "the clock of the taxels",
    "clock_depth": "the clock of the encoder",
}


def word_of(where: str) -> str:
    """The word for a place in findings.json: every clock is `clock`."""
    return "clock" if where.startswith("clock") else where


def where_and_clock(where: str) -> dict[str, str]:
    """That word as `where`, and for a clock other than the load cell's which one it is, as `channel_clock`."""
    return {"where": word_of(where)} | ({} if word_of(where) == where else {"channel_clock": where.partition("_")[2]})


def spoken(name: str) -> str:
    """An identifier as words: `stress_relaxation` becomes `stress relaxation`."""
    return str(name).replace("_", " ").strip()


def place(where: str) -> str:
    """A place in words: `taxel_3` becomes `taxel 3`."""
    head, _, index = str(where).partition("_")
    if head == "taxel" and index.isdigit():
        return f"taxel {index}"
    return PLACES.get(where, spoken(where))


def place_of(cause: str, where: str) -> str:
    """The place of a cause in words: a time shift of `clock` alone is that of the load cell's clock."""
    return "the clock of the load cell" if (cause, where) == ("time_shift", "clock") else place(where)


def cause_at(cause: str, where: str) -> str:
    """`stress relaxation in the skin`, `time shift of the clock of the load cell`, `dead taxel 3`."""
    if cause == "dead_taxel" and where == "taxel_alone":
        return "dead taxel"
    if cause == "dead_taxel" and where.startswith("taxel_"):
        return f"dead {spoken(where)}"
    if cause == "parameters":
        return "wrong parameters of the model"
    return f"{spoken(cause)} {'of' if where.startswith('clock') else 'in'} {place_of(cause, where)}" if where else spoken(cause)
