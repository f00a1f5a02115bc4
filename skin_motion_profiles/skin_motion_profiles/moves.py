"""The moves that profiles are made of: straight lines with a trapezoidal speed, rests, and an emergency brake. SI units."""

from math import copysign, sqrt

from skin_motion_profiles.trajectory import Arc, Piece, State

# Shorter pieces are left out: between set points that near, the rounding of their times would look like a jerk.
_SHORTEST = 1e-6  # s
_LEAST_WAY = 5e-10  # m


def hold(x: float, duration: float) -> tuple[Piece, ...]:
    """Stay at depth `x` (m) for `duration` s; nothing at all where that is no time."""
    return (Arc(duration, x),) if duration > _SHORTEST else ()


def line(a: float, b: float, speed: float, acceleration: float) -> tuple[Piece, ...]:
    """From rest at depth `a` to rest at `b`: accelerate, cruise at `speed`, decelerate (a trapezoid of speed).

    Where the way is shorter than speed^2 / acceleration the cruise is left out and the speed stays lower.
    """
    way, sign = abs(b - a), copysign(1.0, b - a)
    if way <= _LEAST_WAY:
        return ()
    peak = min(speed, sqrt(way * acceleration))
    ramp = peak / acceleration
    cruise = way / peak - ramp
    if cruise <= _SHORTEST:
        ramp, cruise = way / peak, 0.0
    up, push = 0.5 * peak * ramp, sign * peak / ramp
    pieces = [Arc(ramp, a, 0.0, push)]
    if cruise > 0.0:
        pieces.append(Arc(cruise, a + sign * up, sign * peak))
    # The last piece is written from its end backwards, so that it rests at `b` whatever was rounded before.
    pieces.append(Arc(ramp, b - sign * up, sign * peak, -push))
    return tuple(pieces)


def brake(state: State, acceleration: float) -> tuple[Piece, ...]:
    """From any depth and speed to rest, as quickly as `acceleration` allows."""
    if state.v == 0.0:
        return ()
    return (Arc(abs(state.v) / acceleration, state.x, state.v, copysign(acceleration, -state.v)),)


def brake_end(state: State, acceleration: float) -> float:
    """The depth at which `brake` comes to rest, m."""
    return state.x + state.v * abs(state.v) / (2.0 * acceleration)
